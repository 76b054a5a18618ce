# SPDX-License-Identifier: Apache-2.0
"""MAVProxy from PyPI, as it comes, in real time; alone and beside an autopilot."""

from __future__ import annotations

import json
import lzma
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from pharos import Parameters, connect
from pharos.parameters import read_file
from programs import ARDUPILOT, PARAM_REQUEST_LIST, PX4, MavProxy, mavproxy, relay_to
from realtime import light_at

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
        received = program.type("param fetch", r"Received \d+ parameters \(ftp\)")
    table = json.loads(lzma.decompress((tmp_path / "parameters.json.xz").read_bytes()))
    json.loads((tmp_path / "general.json").read_bytes())
    assert f"Received {len(table['parameters'])} parameters" in received


def wait_for(program: MavProxy, name: str, value: str) -> None:
    """It sets in its own time, and says nothing when that is done."""
    for _ in range(100):
        if f"{name} = {value}" in program.type(f"param fetch {name}", rf"{name} = [\d.]+\s"):
            return
    raise AssertionError(f"{name} did not become {value}")


@pytest.mark.parametrize(
    ("way", "autopilot"),
    [("list", None), ("list", ARDUPILOT), ("list", PX4), ("file", None)],
)
def test_it_shows_sets_saves_and_loads_parameters(
    address: str, tmp_path: Path, way: str, autopilot: int | None
) -> None:
    """Of integers it makes something else beside each autopilot; a REAL32 is the same always. What
    it saves the `pharos` command reads, and the other way round."""
    saved = tmp_path / "mine.parm"
    with (
        relay_to(address, autopilot) as relay,
        mavproxy(relay.address, tmp_path, PARAMETERS) as program,
    ):
        program.type(f"set param_ftp {way == 'file'}", r".")
        program.type("param fetch", r"Received 69 parameters")
        shown = program.type("param show *", r"(?s)BCN_BRIGHT.*ZOOM_TIME +[\d.]+\s")
        values = {
            n: float(v) for n, v in re.findall(r"^(?:MAV> )?(\w+) +(\S+)\s*$", shown, re.MULTILINE)
        }
        assert len(values) == 69
        for name, value in SHOWN.items():
            assert values[name] == pytest.approx(value, rel=1e-7)
        program.type("param set THR_SHUTDOWN 95.5", r"")
        wait_for(program, "THR_SHUTDOWN", "95.5")
        said = program.type(f"param save {saved}", r"Saved \d+ parameters")
        assert "Failed" not in said
        program.type("param set THR_SHUTDOWN 90", r"")
        wait_for(program, "THR_SHUTDOWN", "90.0")
        program.type(f"param load {saved}", r"Loaded \d+ parameters")
        wait_for(program, "THR_SHUTDOWN", "95.5")
    with connect(f"udpout:{address}") as light:
        done, refused = Parameters(light).set_all(read_file(saved))
        assert (done, refused) == ([], [])


def test_with_a_target_it_asks_for_one_list(address: str, tmp_path: Path) -> None:
    """As README has it. It looks every two seconds whether it has all."""
    with relay_to(address) as relay, mavproxy(relay.address, tmp_path, PARAMETERS) as program:
        program.until(r"Received 69 parameters \(ftp\)")
        program.type("set param_ftp False", r".")
        program.type("param fetch", r"Received 69 parameters\s")
        for _ in range(6):  # a heartbeat a second
            program.type("watch HEARTBEAT", r"(?s)HEARTBEAT.*HEARTBEAT")
        assert relay.asked[PARAM_REQUEST_LIST] == 1


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
