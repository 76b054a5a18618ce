# SPDX-License-Identifier: Apache-2.0
"""A component's parameters over MAVLink, and the files that ground stations keep them in.

Values are as people read them: numbers with a fraction for REAL32, whole ones for integer types.
How integers cross the wire, as bytes or as floats, the component says in its capabilities.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .errors import CommandError, PharosError, UsageError
from .light import TRIES, TRY_US, Light

REAL32 = 9
# MAV_PARAM_TYPE of four bytes and fewer, as struct has them.
INTEGERS = {1: "B", 2: "b", 3: "H", 4: "h", 5: "I", 6: "i"}
TYPES = {
    1: "uint8", 2: "int8", 3: "uint16", 4: "int16", 5: "uint32", 6: "int32", REAL32: "real32",
}  # fmt: skip
ENCODE_C_CAST = 131_072
# A list is over when nothing of it came for this long [µs]; its rest is asked for one by one.
QUIET_US = 1_500_000
NAME_MAX = 16
REASONS = {
    1: "there is no such parameter",
    2: "the value is out of range",
    3: "setting it is not permitted",
    4: "there is no such component",
    5: "it is read-only",
    6: "its type is not supported",
    7: "it has another type",
    8: "it cannot be read",
}


class ParameterError(PharosError):
    """The component refused a parameter; `error`: MAV_PARAM_ERROR, 0 if it gave no reason."""

    def __init__(self, name: str, reason: str, error: int = 0) -> None:
        super().__init__(f"{name}: {reason}")
        self.error = error


@dataclass(frozen=True)
class Parameter:
    name: str
    value: float | int
    kind: int  # MAV_PARAM_TYPE
    index: int

    @property
    def text(self) -> str:
        return text_of(self.value)

    def as_fields(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "value": self.value,
            "type": TYPES.get(self.kind, str(self.kind)),
            "index": self.index,
        }


def text_of(value: float | int) -> str:
    """The shortest decimal that is this 32-bit float."""
    if isinstance(value, int):
        return str(value)
    texts = (f"{value:.{digits}g}" for digits in range(6, 10))
    return next((text for text in texts if is_same(float(text), value)), f"{value:.9g}")


class Parameters:
    """The parameters of the component that `light` addresses."""

    def __init__(self, light: Light) -> None:
        self._light = light
        self._is_cast: bool | None = None

    # --- the wire -----------------------------------------------------------------------------
    def _casts(self) -> bool:
        """Whether integers cross as floats of their value, not as their bytes."""
        if self._is_cast is None:
            try:
                self._is_cast = bool(self._light.fetch_information().capabilities & ENCODE_C_CAST)
            except PharosError:
                self._is_cast = False
        return self._is_cast

    def _decode(self, message: Any) -> Parameter:
        kind, wire = int(message.param_type), float(message.param_value)
        value: float | int = float(text_of(wire))
        if kind in INTEGERS:
            packed = struct.pack("<f", wire)
            value = (
                round(wire)
                if self._casts()
                else int(struct.unpack_from(f"<{INTEGERS[kind]}", packed)[0])
            )
        return Parameter(_name_of(message), value, kind, int(message.param_index))

    def _encode(self, kind: int, value: float) -> float:
        if kind not in INTEGERS or self._casts():
            return value
        try:
            packed = struct.pack(f"<{INTEGERS[kind]}", int(value)).ljust(4, b"\0")
        except struct.error as error:
            raise UsageError(f"{text_of(value)} does not fit into {TYPES[kind]}") from error
        return float(struct.unpack("<f", packed)[0])

    def _ask(self, message: Any, name: str, index: int = -1) -> Parameter | int:
        """The PARAM_VALUE that answers it, or the reason of a PARAM_ERROR."""
        light = self._light
        for _ in range(TRIES):
            light.connection.send(message)
            end = light.connection.pacer.now_us() + TRY_US
            while (left := end - light.connection.pacer.now_us()) > 0:
                for answer in light.poll_target(left):
                    kind = answer.get_type()
                    if kind == "PARAM_ERROR" and _name_of(answer) == name:
                        return int(answer.error)
                    if kind == "PARAM_VALUE" and (
                        _name_of(answer) == name or (index >= 0 and answer.param_index == index)
                    ):
                        return self._decode(answer)
        return 0

    # --- one ----------------------------------------------------------------------------------
    def get(self, name: str) -> Parameter:
        """ParameterError: there is none of that name."""
        self._casts()
        return self._read(_checked(name), -1)

    def _read(self, name: str, index: int) -> Parameter:
        connection = self._light.connection
        target = connection.target
        answer = self._ask(
            connection.dialect.MAVLink_param_request_read_message(
                target.system, target.component, name.encode(), index
            ),
            name,
            index,
        )
        if isinstance(answer, Parameter):
            return answer
        # The protocol has no refusal but the newer PARAM_ERROR: nothing comes. Of somebody who
        # answers nothing at all either, that says nothing.
        if not answer:
            with suppress(CommandError):
                self._light.fetch_status()
        raise ParameterError(name or f"#{index}", REASONS.get(answer, REASONS[1]), answer)

    def set(self, name: str, value: float) -> Parameter:
        """What is in force afterwards: between two steps of the parameter, the nearer one.
        ParameterError: what was before."""
        now = self.get(name)
        if now.kind in INTEGERS and value != int(value):
            raise UsageError(f"{name} is a whole number, not {text_of(value)}")
        connection = self._light.connection
        target = connection.target
        answer = self._ask(
            connection.dialect.MAVLink_param_set_message(
                target.system,
                target.component,
                name.encode(),
                self._encode(now.kind, value),
                now.kind,
            ),
            name,
        )
        if not isinstance(answer, Parameter):
            if answer:
                raise ParameterError(name, REASONS.get(answer, f"error {answer}"), answer)
            raise connection.silence(f"no answer to setting {name}")
        if not is_same(answer.value, value):
            error = self._reason(name)
            if error or is_same(answer.value, now.value):
                raise ParameterError(
                    name, f"{text_of(value)} was not taken; it is {answer.text}", error
                )
        return answer

    def _reason(self, name: str) -> int:
        """Of a PARAM_ERROR that follows the value, if one does."""
        for answer in self._light.poll_target(100_000):
            if answer.get_type() == "PARAM_ERROR" and _name_of(answer) == name:
                return int(answer.error)
        return 0

    # --- all ----------------------------------------------------------------------------------
    def fetch_all(self) -> dict[str, Parameter]:
        """In the order of their index. SilentError: the component has none, or does not answer."""
        self._casts()
        light = self._light
        connection = light.connection
        target = connection.target
        found: dict[int, Parameter] = {}
        count = 0
        for _ in range(TRIES):
            connection.send(
                connection.dialect.MAVLink_param_request_list_message(
                    target.system, target.component
                )
            )
            quiet = connection.pacer.now_us() + QUIET_US
            while connection.pacer.now_us() < quiet and (not count or len(found) < count):
                for message in light.poll_target(quiet - connection.pacer.now_us()):
                    if message.get_type() == "PARAM_VALUE" and message.param_index < 65535:
                        count = int(message.param_count)
                        parameter = self._decode(message)
                        found[parameter.index] = parameter
                        quiet = connection.pacer.now_us() + QUIET_US
            if count:
                break
        if not count:
            raise connection.silence("no parameters came")
        for index in range(count):
            if index not in found:
                found[index] = self._read("", index)
        return {found[index].name: found[index] for index in sorted(found)}

    def set_all(self, values: Mapping[str, float]) -> tuple[list[Parameter], list[PharosError]]:
        """Sets those that differ; those that were set, and why others were not."""
        now = self.fetch_all()
        done: list[Parameter] = []
        refused: list[PharosError] = []
        for name, value in values.items():
            try:
                if name not in now:
                    raise ParameterError(name, REASONS[1], 1)
                if not is_same(now[name].value, value):
                    done.append(self.set(name, value))
            except (ParameterError, UsageError) as error:
                refused.append(error)
        return done, refused


def is_same(a: float, b: float) -> bool:
    """As 32-bit floats, which is how they cross the wire."""
    return a == b or struct.pack("<f", a) == struct.pack("<f", b)


def _name_of(message: Any) -> str:
    name = message.param_id
    text = name.decode("ascii", "backslashreplace") if isinstance(name, bytes) else str(name)
    return text.rstrip("\0")


def _checked(name: str) -> str:
    if not name or len(name.encode()) > NAME_MAX:
        raise UsageError(f"'{name}' is no parameter: a name has 1 to {NAME_MAX} characters")
    return name


# --- files ----------------------------------------------------------------------------------------
def _read_lines(path: str | Path) -> Iterator[tuple[int | None, str, float]]:
    """Component, if the line names one, name and value of each."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise PharosError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise PharosError(f"{path}: no text") from error
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            component = None
            if len(words) == 5 and words[0].isdecimal():
                component = int(words[1])
                words = words[2:4]
            name, value = words
            yield component, _checked(name), float(value)
        except (ValueError, UsageError):
            raise PharosError(f"{path}: line {number} is no NAME VALUE: '{line}'") from None


def read_file(path: str | Path, component: int | None = None) -> dict[str, float]:
    """Name and value of each line of MAVProxy's .parm (NAME VALUE), Mission Planner's (NAME,VALUE)
    or QGroundControl's (system, component, NAME, VALUE, type), of which a component's can be
    picked: a vehicle's file has those of all. PharosError: what is wrong, and in which line."""
    return {
        name: value
        for of, name, value in _read_lines(path)
        if component is None or of is None or of == component
    }


def components_in(path: str | Path) -> list[int]:
    """The components that the lines of a file of QGroundControl are of; of other files none."""
    return sorted({of for of, _, _ in _read_lines(path) if of is not None})


def write_file(path: str | Path, parameters: Iterable[Parameter], system: int, of: int) -> None:
    """QGroundControl's form if the name ends with .params, else NAME VALUE. of: the component."""
    is_qgc = str(path).endswith(".params")
    lines = [f"# Parameters of component {system}/{of}"]
    for p in parameters:
        if is_qgc:
            lines.append(f"{system}\t{of}\t{p.name}\t{p.text}\t{p.kind}")
        else:
            lines.append(f"{p.name:<{NAME_MAX}} {p.text}")
    try:
        Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise PharosError(f"{path}: {error.strerror}") from error
