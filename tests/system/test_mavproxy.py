# SPDX-License-Identifier: Apache-2.0
"""MAVProxy from PyPI, as it comes, in real time; alone and beside an autopilot."""

from __future__ import annotations

import json
import lzma
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from harness import ROOT
from parameters import OF_GIMBAL, OF_LIGHT
from pharos import Parameters, connect
from pharos.parameters import read_file
from programs import (
    ARDUPILOT,
    COMMAND_ACK,
    FILE_TRANSFER_PROTOCOL,
    HEARTBEAT,
    PARAM_REQUEST_LIST,
    PROTOCOL_VERSION,
    PX4,
    MavProxy,
    mavproxy,
    relay_to,
)
from realtime import LIMIT_S, light_at

PARAMETERS = "--default-modules=ftp,param"
pytestmark = pytest.mark.realtime
# docs/parameters.md
SHOWN = {
    "THR_SHUTDOWN": 100, "THR_SENS_MIN": -55, "LGT_SRC_HOLD": 5, "STRB_MIN": 0.01,
    "PRG_DOT": 0.2, "BCN_DUTY": 10, "CAN_LIGHT_ID": 254, "CAN_BITRATE": 1e6, "IMC_ID": 33858,
}  # fmt: skip


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """HOST:PORT of a light that runs in real time and listens over UDP."""
    with light_at(tmp_path) as found:
        yield found


def test_it_turns_the_light_on(address: str, tmp_path: Path) -> None:
    with mavproxy(address, tmp_path, "--default-modules=cmdlong") as program:
        program.type("long ILLUMINATOR_ON_OFF 1", r"ILLUMINATOR_ON_OFF.*ACCEPTED")


def test_it_fetches_files_and_packed_parameters(address: str, tmp_path: Path) -> None:
    with mavproxy(address, tmp_path, PARAMETERS) as program:
        program.until(r"Received \d+ parameters \(ftp\)")
        program.type("ftp list", r"parameters\.json\.xz")
        for name in ("general.json", "parameters.json.xz"):
            program.type(f"ftp get {name}", rf"Wrote \d+ bytes to {re.escape(name)}")
        # a line later, since the file is closed after that is said
        said = program.type("param fetch", r"Received \d+ parameters \(ftp\)")
    table = json.loads(lzma.decompress((tmp_path / "parameters.json.xz").read_bytes()))
    json.loads((tmp_path / "general.json").read_bytes())
    assert {row["name"] for row in table["parameters"]} == OF_LIGHT
    assert f"Received {len(OF_LIGHT)} parameters" in said


def wait_for(program: MavProxy, name: str, value: str) -> None:
    """It sets in its own time, and says nothing when that is done."""
    for _ in range(100):
        if f"{name} = {value}" in program.type(f"param fetch {name}", rf"{name} = -?[\d.]+\s"):
            return
    raise AssertionError(f"{name} did not become {value}")


def assert_nothing_failed(program: MavProxy) -> None:
    """What it sets it tries three times, a second each, before it says that it failed."""
    program.pass_seconds(5)
    assert "fail" not in program.said.lower()


def received(count: int) -> str:
    """What it says when it has a list."""
    return rf"Received {count} parameters\s*\n"


@pytest.mark.parametrize(
    ("way", "autopilot"),
    [("list", None), ("list", ARDUPILOT), ("list", PX4), ("file", None)],
)
def test_it_shows_sets_saves_and_loads_parameters(
    address: str, tmp_path: Path, way: str, autopilot: int | None
) -> None:
    """Of integers it makes something else beside each autopilot; a REAL32 is the same always. What
    it saves the `pharos` command reads, and the other way round."""
    saved, kept = tmp_path / "mine.parm", tmp_path / "kept.parm"
    pharos = (sys.executable, "-m", "pharos", "param")
    with (
        relay_to(address, autopilot) as relay,
        mavproxy(relay.address, tmp_path, PARAMETERS) as program,
    ):
        program.until(r"Received \d+ parameters \(ftp\)")
        program.type(f"set param_ftp {way == 'file'}", r"")
        count = len(OF_LIGHT)
        program.type(
            "param fetch",
            received(count) if way == "list" else rf"Received {count} parameters \(ftp\)",
        )
        shown = program.type("param show *", r"(?s)BCN_BRIGHT.*ZOOM_TIME +[\d.]+\s")
        values = {
            n: float(v) for n, v in re.findall(r"^(?:MAV> )?(\w+) +(\S+)\s*$", shown, re.MULTILINE)
        }
        assert set(values) == OF_LIGHT
        for name, value in SHOWN.items():
            assert values[name] == pytest.approx(value, rel=1e-7)
        program.type("param set THR_SHUTDOWN 95.5", r"")
        wait_for(program, "THR_SHUTDOWN", "95.5")
        program.type(f"param save {saved}", rf"Saved {count} parameters")
        program.type("param set THR_SHUTDOWN 90", r"")
        wait_for(program, "THR_SHUTDOWN", "90.0")
        program.type(f"param load {saved}", rf"Loaded {count} parameters")
        wait_for(program, "THR_SHUTDOWN", "95.5")
        url = f"udp:{address}"
        subprocess.run([*pharos, "save", url, str(kept)], check=True, timeout=LIMIT_S)
        program.type("param set THR_SHUTDOWN 90", r"")
        wait_for(program, "THR_SHUTDOWN", "90.0")
        program.type(f"param load {kept}", r"Loaded \d+ parameters")
        wait_for(program, "THR_SHUTDOWN", "95.5")
        assert_nothing_failed(program)
    with connect(f"udpout:{address}") as light:
        done, refused = Parameters(light).set_all(read_file(saved))
        assert (done, refused) == ([], [])


def test_it_says_when_it_failed(address: str, tmp_path: Path) -> None:
    """So that the tests beside this one would see it."""
    with mavproxy(address, tmp_path, PARAMETERS) as program:
        program.until(r"Received \d+ parameters \(ftp\)")
        program.type("param set THR_SHUTDOWN 1e6", r"")
        with pytest.raises(AssertionError):
            assert_nothing_failed(program)
        assert "Failed to set THR_SHUTDOWN" in program.said


@pytest.mark.parametrize("way", ["option", "command"])
def test_the_gimbals_parameters(address: str, tmp_path: Path, way: str) -> None:
    """Component 154 has no files, and says so: it is asked for a list at once."""
    component = 154 if way == "option" else 243
    with (
        relay_to(address) as relay,
        mavproxy(relay.address, tmp_path, PARAMETERS, component=component) as program,
    ):
        if way == "command":
            program.until(r"Received \d+ parameters \(ftp\)")
            program.type("vehicle 1:154", r"Set vehicle 1:154")
        before = relay.asked.get(FILE_TRANSFER_PROTOCOL, 0)
        program.until(received(len(OF_GIMBAL)))
        program.type("param show GMB_PAN_MIN", r"GMB_PAN_MIN +-90.0\s")
        program.type("param set GMB_PAN_MIN -80.5", r"")
        wait_for(program, "GMB_PAN_MIN", "-80.5")
        shown = program.type("param show *", r"(?s)GMB_ASK_DATA.*GMB_TLT_TRIM +[\d.]+\s")
        assert set(re.findall(r"GMB_\w+", shown)) == OF_GIMBAL
        assert_nothing_failed(program)
        assert relay.asked.get(FILE_TRANSFER_PROTOCOL, 0) - before <= 4, "it did not try again"


WATCHED_S = 20


@pytest.mark.parametrize("autopilot", [None, ARDUPILOT])
def test_with_a_target_it_asks_for_one_list(
    address: str, tmp_path: Path, autopilot: int | None
) -> None:
    """It looks every second whether it has all, for WATCHED_S here."""
    with (
        relay_to(address, autopilot) as relay,
        mavproxy(relay.address, tmp_path, PARAMETERS) as program,
    ):
        program.until(r"Received \d+ parameters \(ftp\)")
        program.type("set param_ftp False", r"")
        program.type("param fetch", received(len(OF_LIGHT)))
        program.pass_seconds(WATCHED_S)
        assert relay.asked[PARAM_REQUEST_LIST] == 1


def test_without_a_target_it_asks_for_ever(address: str, tmp_path: Path) -> None:
    """It takes a target from an autopilot's heartbeat alone, and asks until its target, 0/0, has
    parameters. It looks every second, and asks where 2 s have passed since it did: every 2 to 3 s.
    """
    modules = "--default-modules=link,param"
    with (
        relay_to(address) as relay,
        mavproxy(relay.address, tmp_path, modules, component=None) as program,
    ):
        program.pass_seconds(3)
        before = relay.asked[PARAM_REQUEST_LIST]
        program.pass_seconds(WATCHED_S)
        asked = relay.asked[PARAM_REQUEST_LIST] - before
        assert WATCHED_S / 3 - 1 <= asked <= WATCHED_S / 2 + 1
        program.type("vehicle 1:243", r"Set vehicle 1:243")
        program.pass_seconds(3)
        before = relay.asked[PARAM_REQUEST_LIST]
        program.pass_seconds(WATCHED_S)
        assert relay.asked[PARAM_REQUEST_LIST] == before


def test_in_version_1_it_gets_what_only_version_2_carries(address: str, tmp_path: Path) -> None:
    """The handshake of the MAVLink guide: acknowledged in 1, answered in 2. This MAVProxy then ends
    its own main loop, as at each COMMAND_ACK in version 1."""
    with (
        relay_to(address) as relay,
        mavproxy(relay.address, tmp_path, "--mav10", "--default-modules=cmdlong") as program,
    ):
        relay.until(1, HEARTBEAT)
        before = set(relay.told)
        program.type(f"long REQUEST_MESSAGE {PROTOCOL_VERSION}", r"")
        relay.until(1, COMMAND_ACK)
        relay.until(2, PROTOCOL_VERSION)
        assert {version for version, _ in before} == {1}
        assert (2, COMMAND_ACK) not in relay.told


def test_two_at_one_tcp_wire(tmp_path: Path) -> None:
    modules = "--default-modules=cmdlong,ftp,link,param"
    folders = [tmp_path / name for name in ("one", "two")]
    for folder in folders:
        folder.mkdir()
    with (
        light_at(tmp_path, wire="tcpin:127.0.0.1:0") as address,
        mavproxy(address, folders[0], modules, link="tcp") as one,
        mavproxy(address, folders[1], modules, link="tcp") as two,
    ):
        both = (one, two)
        for program in both:
            program.until(r"Received \d+ parameters \(ftp\)")
        for _ in range(20):
            for program in both:
                program.type("long ILLUMINATOR_ON_OFF 1", r"ILLUMINATOR_ON_OFF.*ACCEPTED")


PAGES = {"README.md": "**MAVProxy**", "docs/vehicles.md": "## MAVProxy"}


def lines_of(page: str) -> list[str]:
    """Of the blocks with MAVProxy's prompt, under its heading."""
    text = (ROOT / page).read_text(encoding="utf-8").partition(PAGES[page])[2]
    text = re.split(r"^(?:## |\*\*)", text, maxsplit=1, flags=re.MULTILINE)[0]
    blocks = re.findall(r"^```\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return [line for block in blocks if "MAV> " in block for line in block.splitlines()]


@pytest.mark.parametrize("page", sorted(PAGES))
def test_the_pages_lines_do_what_they_show(tmp_path: Path, page: str) -> None:
    """As they are typed, beside a light as `make run` starts it. A temperature is any."""
    first, *lines = lines_of(page)
    options = shlex.split(first.removeprefix("$ mavproxy.py "))
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    (wire,) = re.findall(r"^ARGS \?= --uart0 (\S+)", makefile, re.MULTILINE)
    program = MavProxy(tmp_path, *options)
    try:
        with light_at(tmp_path, wire=wire):
            for line in lines:
                typed = re.fullmatch(r"MAV> ([a-z].*)", line)
                if typed:
                    program.type(typed[1], r"")
                    continue
                shown = re.escape(line.removeprefix("MAV> "))
                program.until(re.sub(r"\d+\\\.\d\\ °C", r"-?[\\d.]+ °C", shown))
            program.pass_seconds(5)
            assert "fail" not in program.said.lower()
    finally:
        program.close()


@pytest.mark.parametrize("autopilot", [None, ARDUPILOT])
def test_the_module_switches_and_strobes(
    address: str, tmp_path: Path, autopilot: int | None
) -> None:
    with (
        relay_to(address, autopilot) as relay,
        mavproxy(relay.address, tmp_path, "--default-modules=link") as program,
    ):
        program.type("module load pharos", r"light: illuminator 1/243")
        program.type("light on", r"light: ok")
        program.type("light strobe 2 10", r"light: ok")
        program.type("light status", r"light: on, 100 %, strobe 2 s at 10 %")
        program.type("light brightness 140", r"light: denied: a value is out of range")
        program.type("light dance", r"usage: light on")
        program.type("light off", r"light: ok")
