# SPDX-License-Identifier: Apache-2.0
"""The shell's commands: one table for running, help and completion."""

from __future__ import annotations

import fnmatch
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any

from ..errors import CommandError, PharosError, SilentError, UsageError
from ..ftp import FileClient
from ..light import Light, Status
from ..parameters import (
    Parameter,
    Parameters,
    components_in,
    is_same,
    read_file,
    text_of,
    write_file,
)
from ..text import json_line, printable

OK, REFUSED, USAGE, SILENT = 0, 1, 2, 3
USAGE_WIDTH = 40

_UNITS = {"": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6}


def exit_code(error: PharosError) -> int:
    """What the process ends with because of that error."""
    from ..errors import LinkError, UrlError

    if isinstance(error, (UsageError, UrlError)):
        return USAGE
    return SILENT if isinstance(error, (SilentError, LinkError)) else REFUSED


class Printer:
    """Text for people, or one JSON object per line; errors also in one line on `err`. Whatever
    stands in a text, the terminal shows it and obeys none of it."""

    def __init__(self, out: IO[str], err: IO[str], as_json: bool = False) -> None:
        self._out = out
        self._err = err
        self.as_json = as_json

    def fields(self, text: str | Sequence[str], /, **fields: Any) -> None:
        """text: a line, or several. JSON has the fields instead."""
        lines = [text] if isinstance(text, str) else text
        shown = json_line(fields) if self.as_json else "\n".join(map(printable, lines))
        if shown:
            print(shown, file=self._out, flush=True)

    def error(self, error: PharosError, command: str = "") -> None:
        text = f"{command}: {error}" if command else str(error)
        if self.as_json:
            fields: dict[str, Any] = {"command": command} if command else {}
            if isinstance(error, CommandError):
                fields["result"] = error.result
            self.fields("", **fields, ok=False, error=str(error))
        self._out.flush()
        print(f"pharos: {printable(text)}", file=self._err, flush=True)


@dataclass(frozen=True)
class Command:
    """`parse` turns the words after the name into an action; UsageError if they make no sense."""

    usage: str
    help: str
    parse: Callable[[Sequence[str]], Callable[[Shell], None]]
    words: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return self.usage.split()[0]


@dataclass(frozen=True)
class Line:
    """One command, understood but not run."""

    name: str
    run: Callable[[Shell], None]


class Shell:
    """Runs commands on a light. `is_done` after quit."""

    def __init__(self, light: Light, printer: Printer) -> None:
        self.light = light
        self.printer = printer
        self.is_done = False

    def run(self, line: Line) -> int:
        """Runs it, prints what came of it, and returns the exit code."""
        try:
            line.run(self)
        except PharosError as error:
            self.printer.error(error, line.name)
            return exit_code(error)
        finally:
            self.print_texts()
        return OK

    def execute(self, text: str) -> int:
        """Runs a line of commands with ; between them, up to the first that fails."""
        try:
            lines = parse(text)
        except UsageError as error:
            self.printer.error(error)
            return USAGE
        for line in lines:
            code = self.run(line)
            if code != OK or self.is_done:
                return code
        return OK

    def print_texts(self) -> None:
        """What the light said to people meanwhile."""
        for text in self.light.texts:
            self.printer.fields(f"light: {text}", event="text", text=text)
        self.light.texts.clear()

    def say_ok(self, name: str) -> None:
        self.printer.fields("ok", command=name, ok=True)

    def print_status(self, name: str, status: Status) -> None:
        self.printer.fields(str(status), command=name, ok=True, **status.as_fields())


def parse(text: str) -> list[Line]:
    """Commands separated by ;. A # begins a comment. UsageError: nothing of it is understood."""
    lines = []
    for part in text.partition("#")[0].split(";"):
        words = part.split()
        if not words:
            continue
        lines.append(parse_words(words[0], words[1:]))
    return lines


def parse_words(name: str, words: Sequence[str]) -> Line:
    """One command, its arguments apart. UsageError: it makes no sense."""
    command = COMMANDS.get(name) or _ALIASES.get(name)
    if command is None:
        raise UsageError(f"'{name}' is no command; `help` lists them")
    try:
        return Line(command.name, command.parse(words))
    except UsageError as error:
        hint = f"{error}; " if str(error) else ""
        raise UsageError(f"{command.name}: {hint}usage: {command.usage}") from None


# --- arguments ------------------------------------------------------------------------------------
def _count(words: Sequence[str], low: int, high: int) -> None:
    if not low <= len(words) <= high:
        raise UsageError("")


def _number(text: str, suffix: str = "") -> float:
    try:
        value = float(text.removesuffix(suffix) if suffix else text)
    except ValueError:
        raise UsageError(f"'{text}' is no number") from None
    if not math.isfinite(value):
        raise UsageError(f"'{text}' is no number")
    return value


def _period(text: str) -> float:
    """Seconds from "0.5", "500ms", "2Hz"."""
    match = re.fullmatch(r"([-+0-9.eE]+?)(s|ms|us|[hH]z)?", text)
    if match is None:
        raise UsageError(f"'{text}' is no period")
    value, unit = _number(match[1]), match[2] or ""
    if unit.lower() == "hz":
        if value <= 0:
            raise UsageError(f"'{text}' is no frequency")
        return 1 / value
    return value * _UNITS[unit]


def _percent(text: str) -> float:
    return _number(text, "%")


# --- commands -------------------------------------------------------------------------------------
def _switch(name: str, act: Callable[[Light], None]) -> Callable[[Sequence[str]], Any]:
    def parse_it(words: Sequence[str]) -> Callable[[Shell], None]:
        _count(words, 0, 0)
        return _acting(name, act)

    return parse_it


def _acting(name: str, act: Callable[[Light], None]) -> Callable[[Shell], None]:
    def run(shell: Shell) -> None:
        act(shell.light)
        shell.say_ok(name)

    return run


def _parse_brightness(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 1, 1)
    percent = _percent(words[0])
    return _acting("brightness", lambda light: light.set_brightness(percent))


def _parse_strobe(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 1, 2)
    if words[0] == "off":
        _count(words, 1, 1)
        return _acting("strobe", lambda light: light.set_strobe(0))
    period = _period(words[0])
    duty = _percent(words[1]) if len(words) == 2 else None
    return _acting("strobe", lambda light: light.set_strobe(period, duty))


def _parse_sync(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 0, 1)
    if words and words[0] not in ("on", "off"):
        raise UsageError(f"'{words[0]}' is neither on nor off")
    external = list(words) != ["off"]
    return _acting("sync", lambda light: light.set_sync(external))


def _parse_status(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 0, 0)
    return lambda shell: shell.print_status("status", shell.light.fetch_status())


def _parse_watch(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 0, 1)
    if words and (not words[0].isdecimal() or int(words[0]) == 0):
        raise UsageError(f"'{words[0]}' is no number of reports")
    count = int(words[0]) if words else None

    def run(shell: Shell) -> None:
        left = count
        try:
            while left is None or left > 0:
                shell.print_status("watch", shell.light.next_status())
                shell.print_texts()
                left = None if left is None else left - 1
        except KeyboardInterrupt:
            if count is not None:
                raise

    return run


def _parse_info(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 0, 0)

    def run(shell: Shell) -> None:
        info = shell.light.fetch_information()
        target = shell.light.connection.target
        text = (
            f"{info.vendor_name} {info.model_name}, software {info.software_version}, "
            f"hardware {info.hardware_version}, serial {info.serial_number or 'unknown'}, "
            f"component {target.system}/{target.component}"
        )
        fields = {"system": target.system, "component": target.component, **asdict(info)}
        shell.printer.fields(text, command="info", ok=True, **fields)

    return run


def _parse_gimbal(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 2, 2)
    pan, tilt = _number(words[0]), _number(words[1])
    return _acting("gimbal", lambda light: light.point(pan, tilt))


def _parse_selftest(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 0, 1)
    percent = _percent(words[0]) if words else 0.0
    return _acting("selftest", lambda light: light.self_test(percent))


def _parse_reboot(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 0, 1)
    if words and words[0] != "force":
        raise UsageError(f"'{words[0]}' is not force")
    return _acting("reboot", lambda light: light.reboot(bool(words)))


def _parse_files(words: Sequence[str]) -> Callable[[Shell], None]:
    if not words or words[0] not in ("list", "get"):
        raise UsageError("")
    if words[0] == "list":
        _count(words[1:], 0, 1)
        return lambda shell: _files_list(shell, *words[1:])
    _count(words[1:], 1, 2)
    return lambda shell: _files_get(shell, *words[1:])


def _files_list(shell: Shell, folder: str = "/") -> None:
    for name, size in FileClient(shell.light).list_files(folder).items():
        text = name if name.endswith("/") else f"{name:<32} {size}"
        shell.printer.fields(text, command="files", ok=True, name=name, size=size)


def _files_get(shell: Shell, path: str, local: str = "") -> None:
    content = FileClient(shell.light).read(path)
    # What the device calls it must not lead elsewhere.
    target = Path(local or path.rstrip("/").rpartition("/")[2])
    try:
        target.write_bytes(content)
    except (OSError, ValueError) as error:
        raise PharosError(f"{target}: {error}") from error
    text = f"{len(content)} bytes in {target}"
    shell.printer.fields(text, command="files", ok=True, file=str(target), size=len(content))


def _parse_param(words: Sequence[str]) -> Callable[[Shell], None]:
    if not words or words[0] not in PARAM_ACTIONS:
        raise UsageError(f"'{words[0]}' is none of {', '.join(PARAM_ACTIONS)}" if words else "")
    run, low, high = PARAM_ACTIONS[words[0]]
    _count(words[1:], low, high)
    if words[0] == "set":
        _number(words[2])
    return lambda shell: run(shell, *words[1:])


def _say_parameter(shell: Shell, parameter: Parameter) -> None:
    text = f"{parameter.name:<16} {parameter.text}"
    shell.printer.fields(text, command="param", ok=True, **parameter.as_fields())


def _param_list(shell: Shell, pattern: str = "*") -> None:
    for parameter in Parameters(shell.light).fetch_all().values():
        if fnmatch.fnmatchcase(parameter.name, pattern.upper()):
            _say_parameter(shell, parameter)


def _param_get(shell: Shell, name: str) -> None:
    _say_parameter(shell, Parameters(shell.light).get(name.upper()))


def _param_set(shell: Shell, name: str, value: str) -> None:
    _say_parameter(shell, Parameters(shell.light).set(name.upper(), _number(value)))


def _param_save(shell: Shell, path: str) -> None:
    found = Parameters(shell.light).fetch_all()
    target = shell.light.connection.target
    write_file(path, found.values(), target.system, target.component)
    shell.printer.fields(
        f"{len(found)} parameters in {path}", command="param", ok=True, count=len(found), file=path
    )


def _param_load(shell: Shell, path: str) -> None:
    """Sets what it can; what it cannot is told, and makes it fail."""
    own = shell.light.connection.target.component
    wanted = read_file(path, own)
    others = [component for component in components_in(path) if component != own]
    done, refused = Parameters(shell.light).set_all(wanted)
    for parameter in done:
        _say_parameter(shell, parameter)
    for error in refused:
        shell.printer.error(error, "param")
    same = len(wanted) - len(done) - len(refused)
    text = f"{len(done)} set, {same} were so already"
    if others:
        text += f", left out: those of component {', '.join(map(str, others))}"
    if refused:
        raise PharosError(f"{text}, {len(refused)} refused")
    shell.printer.fields(text, command="param", ok=True, set=len(done), same=same, left_out=others)


def _param_diff(shell: Shell, path: str) -> None:
    """Exit code 1 if they differ, as diff has it."""
    wanted = read_file(path, shell.light.connection.target.component)
    now = Parameters(shell.light).fetch_all()
    lines = 0
    for name in [*wanted, *(name for name in now if name not in wanted)]:
        here = now[name].value if name in now else None
        there = wanted.get(name)
        if here is not None and there is not None and is_same(here, there):
            continue
        lines += 1
        shown = ["-" if value is None else text_of(value) for value in (there, here)]
        shell.printer.fields(
            f"{name:<16} {shown[0]} in the file, {shown[1]} in the light",
            command="param", name=name, file=there, light=here,
        )  # fmt: skip
    if lines:
        raise PharosError(f"{lines} parameter{'s differ' if lines > 1 else ' differs'}")


PARAM_ACTIONS: dict[str, tuple[Callable[..., None], int, int]] = {
    "list": (_param_list, 0, 1),
    "get": (_param_get, 1, 1),
    "set": (_param_set, 2, 2),
    "save": (_param_save, 1, 1),
    "load": (_param_load, 1, 1),
    "diff": (_param_diff, 1, 1),
}


def _parse_help(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 0, 1)
    if words and words[0] not in COMMANDS:
        raise UsageError(f"'{words[0]}' is no command")
    chosen = [COMMANDS[words[0]]] if words else list(COMMANDS.values())
    text = [f"{command.usage:<{USAGE_WIDTH}}{command.help}" for command in chosen]
    names = {command.name: command.usage for command in chosen}
    return lambda shell: shell.printer.fields(text, command="help", ok=True, usage=names)


def _parse_quit(words: Sequence[str]) -> Callable[[Shell], None]:
    _count(words, 0, 0)

    def run(shell: Shell) -> None:
        shell.is_done = True

    return run


COMMANDS: dict[str, Command] = {
    command.name: command
    for command in (
        Command("on", "switch the lamp on", _switch("on", Light.on)),
        Command("off", "switch the lamp off", _switch("off", Light.off)),
        Command("brightness PERCENT", "dim the lamp: 0 … 100 %", _parse_brightness),
        Command(
            "strobe PERIOD [DUTY] | off",
            "flash: 0.5, 500ms or 2Hz, lit for DUTY % of it; off: steady",
            _parse_strobe,
            ("off",),
        ),
        Command(
            "sync [on|off]",
            "let the sync input gate the lamp (on), or its own clock (off)",
            _parse_sync,
            ("on", "off"),
        ),
        Command("status", "what was commanded, temperature, errors", _parse_status),
        Command("watch [N]", "each status as it comes, N or until Ctrl-C", _parse_watch),
        Command("info", "maker, model, versions, serial number", _parse_info),
        Command("gimbal PAN TILT", "point the beam, in degrees: right, up", _parse_gimbal),
        Command(
            "files list [FOLDER] | get PATH [FILE]",
            "files in the light",
            _parse_files,
            ("list", "get"),
        ),
        Command("selftest [PERCENT]", "sweep the lamp and check it", _parse_selftest),
        Command(
            "reboot [force]", "not while the lamp is on, unless forced", _parse_reboot, ("force",)
        ),
        Command(
            "param ACTION …",
            "list [PATTERN], get NAME, set NAME VALUE, save FILE, load FILE, diff FILE",
            _parse_param,
            tuple(PARAM_ACTIONS),
        ),
        Command("help [COMMAND]", "this", _parse_help),
        Command("quit", "leave (also exit, Ctrl-D)", _parse_quit),
    )
}
_ALIASES = {"exit": COMMANDS["quit"], "?": COMMANDS["help"]}
