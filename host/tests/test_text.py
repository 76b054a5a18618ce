# SPDX-License-Identifier: Apache-2.0
"""What a device says is shown, and obeyed by no terminal."""

from __future__ import annotations

import io
import json
from types import SimpleNamespace
from typing import Any, cast

import pytest
from dronecan import uavcan
from hypothesis import given
from hypothesis import strategies as st

from pharos import CommandError, Light, MavlinkConnection, PharosError, Source, Target
from pharos.can_node import DronecanNode
from pharos.can_transfer import Header, Transfer
from pharos.cli.can import Monitor, Seen
from pharos.cli.imc import show
from pharos.cli.shell import Printer, Shell
from pharos.dialect import load_dialect
from pharos.imc import Packet, message
from pharos.link import Link
from pharos.text import json_line, printable

# Sets the window's title, clears the screen.
HOSTILE = "\x1b]0;x\x07\x1b[2J"
SHOWN = "\\x1b]0;x\\x07\\x1b[2J"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain, 21.5 °C …", "plain, 21.5 °C …"),
        (HOSTILE, SHOWN),
        ("two\r\nlines\u2028three", "two\\r\\nlines\\u2028three"),
        ("\x9b2J\x7f", "\\x9b2J\\x7f"),  # the control sequence introducer of one character
        ("abc\u202edef", "abc\\u202edef"),  # writes to the left
        ("\U000e0041\udc80", "\\U000e0041\\udc80"),
    ],
)
def test_what_is_not_printable_is_shown_as_its_escape(text: str, shown: str) -> None:
    assert printable(text) == shown


@given(st.text())
def test_any_text_is_one_safe_line(text: str) -> None:
    assert printable(text).isprintable()
    line = json_line({"text": text})
    assert line.isprintable()
    assert json.loads(line) == {"text": text}


def test_json_has_no_nan() -> None:
    text = json_line({"a": float("nan"), "b": [float("inf"), (1.5,)]})
    assert json.loads(text, parse_constant=pytest.fail) == {"a": None, "b": [None, [1.5]]}


class Desk:
    """Printers of both kinds, and what they printed."""

    def __init__(self) -> None:
        self.out, self.err = io.StringIO(), io.StringIO()

    def printer(self, as_json: bool) -> Printer:
        return Printer(self.out, self.err, as_json)

    def lines(self) -> list[str]:
        text = self.out.getvalue() + self.err.getvalue()
        assert all(line.isprintable() for line in text.split("\n"))
        return text.splitlines()


@pytest.fixture
def desk() -> Desk:
    return Desk()


class Recorded(Link):
    """A link on which all was said at the beginning."""

    def __init__(self, *frames: bytes) -> None:
        super().__init__()
        self.inbox.extend(frames)

    def fileno(self) -> int:
        return -1

    def poll(self, timeout_s: float) -> bool:
        return False

    def _write(self, data: bytes) -> None:
        pass

    def _read(self) -> bytes:
        return b""

    def close(self) -> None:
        pass


class Clock:
    """A pacer whose time passes when it is asked to."""

    def __init__(self) -> None:
        self.now = 0

    def now_us(self) -> int:
        return self.now

    def pump(self, us: int) -> None:
        self.now += us


def light_that_said(*messages: Any) -> Light:
    dialect = load_dialect()
    codec = dialect.MAVLink(None, 1, 243)
    link = Recorded(*(bytes(message.pack(codec)) for message in messages))
    return Light(MavlinkConnection(link, Clock(), dialect, Source(), Target(1)))


@pytest.mark.parametrize("as_json", [False, True])
def test_a_lights_texts_are_shown(desk: Desk, as_json: bool) -> None:
    dialect = load_dialect()
    light = light_that_said(dialect.MAVLink_statustext_message(4, HOSTILE.encode()))
    light.poll()
    Shell(light, desk.printer(as_json)).print_texts()
    (line,) = desk.lines()
    if as_json:
        assert json.loads(line)["text"] == HOSTILE
    else:
        assert line == f"light: {SHOWN}"


@pytest.mark.parametrize("as_json", [False, True])
def test_a_lights_names_are_shown(desk: Desk, as_json: bool) -> None:
    dialect = load_dialect()
    name = HOSTILE.encode()
    light = light_that_said(
        dialect.MAVLink_command_ack_message(512, 0),
        dialect.MAVLink_component_information_basic_message(
            0, 0, 0, b"two\nlines", name, name, name, name
        ),
    )
    assert Shell(light, desk.printer(as_json)).execute("info") == 0
    (line,) = desk.lines()
    if as_json:
        assert json.loads(line)["model_name"] == HOSTILE
    else:
        assert line.count(SHOWN) == 4
        assert line.startswith("two\\nlines ")


@pytest.mark.parametrize("as_json", [False, True])
def test_names_of_nodes_are_shown(desk: Desk, as_json: bool) -> None:
    info = uavcan.protocol.GetNodeInfo.Response()
    info.name.from_bytes(HOSTILE.encode() + b"\xff")
    seen = Seen(5, uavcan.protocol.NodeStatus(), info)
    desk.printer(as_json).fields(str(seen), **seen.as_fields())
    assert len(desk.lines()) == 1


@pytest.mark.parametrize("as_json", [False, True])
def test_transfers_are_shown(desk: Desk, as_json: bool) -> None:
    log = uavcan.protocol.debug.LogMessage()
    log.source.encode("x\n")
    log.text.encode(HOSTILE + "\x9b")
    monitors: list[Any] = []
    node = SimpleNamespace(monitors=monitors, clock=lambda: 0)
    Monitor(cast(DronecanNode, node), desk.printer(as_json), frames=False)
    monitors[0](Transfer(Header(16383, 5), 0, log, False))
    assert len(desk.lines()) == 1


@pytest.mark.parametrize("as_json", [False, True])
def test_imc_packets_are_shown(desk: Desk, as_json: bool) -> None:
    what = message("EntityInfo", label=HOSTILE.encode() + b"\xff", component="\x9b\n")
    show(Packet(what, 1, 1, 2, 2, 0.0), desk.printer(as_json))
    assert len(desk.lines()) == 1


@pytest.mark.parametrize("as_json", [False, True])
def test_errors_stay_one_line(desk: Desk, as_json: bool) -> None:
    for error in (PharosError(f"{HOSTILE}\n\u2028"), CommandError(HOSTILE, 2)):
        desk.printer(as_json).error(error, "on")
    assert len(desk.lines()) == (4 if as_json else 2)
