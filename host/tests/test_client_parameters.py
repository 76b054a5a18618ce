# SPDX-License-Identifier: Apache-2.0
"""Parameters over the wire and in files, and the shell's verbs for them."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from model_light import ModelLight
from pharos import Light, MavlinkConnection, PharosError, SilentError, Simulator, UsageError
from pharos.cli.shell import OK, REFUSED, USAGE, Printer, Shell
from pharos.parameters import (
    Parameter,
    ParameterError,
    Parameters,
    components_in,
    is_same,
    read_file,
    text_of,
    write_file,
)

INT32, UINT8, REAL32 = 6, 1, 9
BYTEWISE, C_CAST = 16, 131_072


class Store(ModelLight):
    """A light with parameters of several types, which it keeps."""

    encoding = BYTEWISE

    def __init__(self) -> None:
        super().__init__()
        self.table: dict[str, tuple[int, float]] = {
            "A_REAL": (REAL32, 0.1),
            "B_INT": (INT32, -7),
            "C_BYTE": (UINT8, 200),
        }
        self.lost: set[int] = set()
        self.counts = 0

    def say_information(self) -> None:
        message = self.d.MAVLink_component_information_basic_message(
            0, 8192 | self.encoding, 0, b"", b"", b"", b"", b""
        )
        self.say(message)

    def wire(self, kind: int, value: float) -> float:
        if kind == REAL32 or self.encoding == C_CAST:
            return value
        layout = {INT32: "<i", UINT8: "<B"}[kind]
        packed = struct.pack(layout, int(value)).ljust(4, b"\0")
        return float(struct.unpack("<f", packed)[0])

    def value(self, kind: int, wire: float) -> float:
        if kind == REAL32 or self.encoding == C_CAST:
            return wire
        layout = {INT32: "<i", UINT8: "<B"}[kind]
        return float(struct.unpack_from(layout, struct.pack("<f", wire))[0])

    def say_parameter(self, index: int, name: str | None = None) -> None:
        del name
        self.counts += 1
        if self.counts in self.lost:
            return
        names = list(self.table)
        kind, value = self.table[names[index]]
        self.say(
            self.d.MAVLink_param_value_message(
                names[index].encode(), self.wire(kind, value), kind, len(names), index
            )
        )

    def on_param_request_list(self, message: Any) -> None:
        for index in range(len(self.table)):
            self.say_parameter(index)

    def on_param_request_read(self, message: Any) -> None:
        name = str(message.param_id)
        if message.param_index >= 0:
            self.say_parameter(message.param_index)
        elif name in self.table:
            self.say_parameter(list(self.table).index(name))

    def on_param_set(self, message: Any) -> None:
        name = str(message.param_id)
        kind, _ = self.table[name]
        value = self.value(kind, message.param_value)
        if value <= 1000:
            self.table[name] = (kind, value)
        self.say_parameter(list(self.table).index(name))


class Cast(Store):
    encoding = C_CAST


def parameters(light: ModelLight) -> Parameters:
    connection = MavlinkConnection(light, light, light.d)
    found = Light(connection)
    found.find()
    return Parameters(found)


@pytest.mark.parametrize("kind", [Store, Cast])
def test_values_are_what_they_are_whichever_way_they_cross(kind: type[Store]) -> None:
    light = kind()
    found = parameters(light).fetch_all()
    assert {name: p.value for name, p in found.items()} == {
        "A_REAL": 0.1, "B_INT": -7, "C_BYTE": 200,
    }  # fmt: skip
    assert isinstance(found["B_INT"].value, int)
    own = parameters(light)
    assert own.set("B_INT", -123).value == -123
    assert light.table["B_INT"][1] == -123
    assert own.set("A_REAL", 2.5).value == 2.5
    assert own.get("C_BYTE") == Parameter("C_BYTE", 200, UINT8, 2)


def test_what_was_lost_of_a_list_is_asked_for() -> None:
    light = Store()
    light.lost = {2}
    assert list(parameters(light).fetch_all()) == ["A_REAL", "B_INT", "C_BYTE"]


def test_a_value_that_is_not_taken_is_an_error() -> None:
    with pytest.raises(ParameterError, match=r"5000 was not taken; it is -7"):
        parameters(Store()).set("B_INT", 5000)


def test_what_fits_no_type_is_not_sent() -> None:
    own = parameters(Store())
    with pytest.raises(UsageError, match="whole number"):
        own.set("B_INT", 0.5)
    with pytest.raises(UsageError, match="uint8"):
        own.set("C_BYTE", 300)
    with pytest.raises(UsageError, match="1 to 16"):
        own.get("A_NAME_THAT_IS_TOO_LONG")


def test_no_parameters_are_told_of() -> None:
    light = Store()
    light.table = {}
    with pytest.raises(SilentError, match="no parameters"):
        parameters(light).fetch_all()
    with pytest.raises(ParameterError, match="no such parameter"):
        parameters(light).get("A_REAL")


# --- files ----------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "text",
    [
        "A_REAL           0.1\nB_INT            -7\n",
        "# by hand\nA_REAL,0.1\n\nB_INT,-7  # with a word\n",
        "# Onboard parameters\n1\t243\tA_REAL\t0.1\t9\n1\t243\tB_INT\t-7\t6\n",
    ],
    ids=["MAVProxy", "Mission Planner", "QGroundControl"],
)
def test_files_of_each_station_are_read(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.parm"
    path.write_text(text)
    assert read_file(path) == {"A_REAL": 0.1, "B_INT": -7.0}


def test_a_vehicles_file_of_qgroundcontrol_has_other_components_too(
    sim: Simulator, tmp_path: Path
) -> None:
    path = tmp_path / "vehicle.params"
    path.write_text(
        "1\t1\tLGT_FALLBACK\t2\t9\n1\t1\tRC1_MIN\t1100\t4\n"
        "1\t154\tGMB_PAN_MIN\t-50\t9\n1\t243\tTHR_THROTTLE\t78\t9\n"
    )
    assert components_in(path) == [1, 154, 243]
    assert read_file(path, 243) == {"THR_THROTTLE": 78.0}
    desk = Desk(sim)
    assert desk(f"param load {path}") == OK
    assert desk.out.getvalue().splitlines() == [
        "THR_THROTTLE     78",
        "1 set, 0 were so already, left out: those of component 1, 154",
    ]
    assert desk("param get LGT_FALLBACK") == OK
    assert desk.out.getvalue().split() == ["LGT_FALLBACK", "0"]
    assert desk(f"param diff {path}") == REFUSED
    assert "GMB_PAN_MIN" not in desk.out.getvalue()


@pytest.mark.parametrize("name", ["a.parm", "a.params"])
def test_what_is_written_is_read_back(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    some = [Parameter("A_REAL", 0.1, REAL32, 0), Parameter("B_INT", -7, INT32, 1)]
    write_file(path, some, 1, 243)
    assert read_file(path) == {"A_REAL": 0.1, "B_INT": -7.0}


@pytest.mark.parametrize(
    ("text", "hint"),
    [("A_REAL\n", "line 1"), ("A 1\nB x\n", "line 2"), ("A 1 2\n", "line 1"), ("\xff", "no text")],
)
def test_what_is_no_file_of_parameters_is_said(tmp_path: Path, text: str, hint: str) -> None:
    path = tmp_path / "a.parm"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(PharosError, match=hint):
        read_file(path)
    with pytest.raises(PharosError, match="No such file"):
        read_file(tmp_path / "none")


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_texts_are_the_very_floats(value: float) -> None:
    assert is_same(float(text_of(value)), value)


# --- on our light, and in the shell ---------------------------------------------------------------
class Desk:
    def __init__(self, sim: Simulator, as_json: bool = False) -> None:
        self.out, self.err = io.StringIO(), io.StringIO()
        light = Light(sim.connect("uart0"))
        light.find()
        self.shell = Shell(light, Printer(self.out, self.err, as_json))

    def __call__(self, text: str) -> int:
        for stream in (self.out, self.err):
            stream.seek(0)
            stream.truncate()
        return self.shell.execute(text)


@pytest.fixture
def sim(binary: Path) -> Iterator[Simulator]:
    with Simulator(binary, {"uart0": "udpin:127.0.0.1:0"}) as sim:
        yield sim


def test_the_shell_lists_sets_saves_and_loads(sim: Simulator, tmp_path: Path) -> None:
    desk, path = Desk(sim), tmp_path / "light.parm"
    assert desk("param list LGT_*") == OK
    lines = desk.out.getvalue().splitlines()
    assert len(lines) > 5
    assert all(line.startswith("LGT_") for line in lines)
    assert desk(f"param save {path}") == OK
    assert desk(f"param diff {path}") == OK
    assert desk("param set lgt_fallback 1; param get LGT_FALLBACK") == OK
    assert desk.out.getvalue().split() == ["LGT_FALLBACK", "1"] * 2
    assert desk(f"param diff {path}") == REFUSED
    assert desk.out.getvalue().split()[:2] == ["LGT_FALLBACK", "0"]
    assert desk(f"param load {path}") == OK
    assert desk.out.getvalue().splitlines()[0].split() == ["LGT_FALLBACK", "0"]
    assert desk.out.getvalue().splitlines()[1].startswith("1 set, ")


def test_the_shell_says_what_was_refused(sim: Simulator, tmp_path: Path) -> None:
    desk, path = Desk(sim), tmp_path / "light.parm"
    assert desk("param set LGT_FALLBACK 77") == REFUSED
    assert "LGT_FALLBACK" in desk.err.getvalue()
    path.write_text("LGT_FALLBACK 77\nLGT_RESTORE 1\nNO_SUCH 1\n")
    assert desk(f"param load {path}") == REFUSED
    errors = desk.err.getvalue().splitlines()
    assert len(errors) == 3
    assert "1 set, 0 were so already, 2 refused" in errors[-1]
    for text in ("param", "param dance", "param set LGT_RESTORE x", "param get", "param list a b"):
        assert desk(text) == USAGE


def test_json_has_a_line_a_parameter(sim: Simulator) -> None:
    desk = Desk(sim, as_json=True)
    assert desk("param get LGT_RESTORE") == OK
    fields = json.loads(desk.out.getvalue())
    assert (fields["name"], fields["value"], fields["ok"]) == ("LGT_RESTORE", 0, True)


def test_a_lossy_line_costs_no_parameter(sim: Simulator) -> None:
    desk = Desk(sim)
    whole = len(Parameters(desk.shell.light).fetch_all())
    sim.fault("uart0", "lost", rate_ppm=1000)
    assert len(Parameters(desk.shell.light).fetch_all()) == whole
