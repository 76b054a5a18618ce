# SPDX-License-Identifier: Apache-2.0
"""MAVSDK, which shares no code with this project or pymavlink, as a client in real time.

mavsdk_client.py does it all once; each test looks at a part of what it saw."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from harness import ACCEPTED, DENIED, UNSUPPORTED
from programs import ARDUPILOT, PX4, relay_to
from realtime import light_at

pytestmark = pytest.mark.realtime

CLIENT = Path(__file__).resolve().with_name("mavsdk_client.py")
# All its waits together; each alone is bounded in the client.
LIMIT_S = 300.0
# COMMAND_ACK.result_param2 of a self-test that passed
PASSED = 2


def run(address: str, folder: Path, *options: str) -> dict[str, Any]:
    """What the client saw."""
    done = subprocess.run(
        [sys.executable, str(CLIENT), address, str(folder), *options],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=LIMIT_S,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    content: dict[str, Any] = json.loads((folder / "seen.json").read_text(encoding="utf-8"))
    return content


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("mavsdk")
    with light_at(folder) as address:
        return run(address, folder)


def test_discovers_the_component(seen: dict[str, Any]) -> None:
    assert seen["system"] == 1
    assert seen["has_autopilot"] is False
    assert 243 in seen["components"]
    assert seen["heartbeat"]["type"] == 44  # MAV_TYPE_ILLUMINATOR
    assert seen["heartbeat"]["autopilot"] == 8  # MAV_AUTOPILOT_INVALID


def test_commands_are_answered(seen: dict[str, Any]) -> None:
    results = {name: ack["result"] for name, ack in seen["acks"].items()}
    assert results == {
        "on": ACCEPTED,
        "configure": ACCEPTED,
        "too_bright": DENIED,
        "unknown": UNSUPPORTED,
        "self_test": ACCEPTED,
    }
    assert seen["acks"]["self_test"]["result_param2"] == PASSED


def test_status_shows_what_was_commanded(seen: dict[str, Any]) -> None:
    status = seen["status"]
    assert status["enable"] == 1
    assert status["mode"] == 1
    assert status["strobe_period"] == 0.5
    assert status["strobe_duty_cycle"] == 10


def test_parameters_are_listed_and_set(seen: dict[str, Any]) -> None:
    parameters = seen["parameters"]
    assert parameters["others"] == 0
    assert parameters["floats"]["STRB_MIN"] == pytest.approx(0.01, rel=1e-7)
    assert parameters["floats"]["THR_SHUTDOWN"] == 100
    assert parameters["after_set"] == pytest.approx(0.02, rel=1e-7)


def test_refused_parameters_say_why(seen: dict[str, Any]) -> None:
    assert seen["parameters"]["refusals"] == {
        "STRB_MIN": "VALUE_OUT_OF_RANGE",
        "LGT_SRC_NOW": "READ_ONLY",
        "NOT_THERE": "DOES_NOT_EXIST",
    }


def test_files_come_whole_in_bursts_and_one_by_one(seen: dict[str, Any]) -> None:
    files = seen["files"]
    assert files["names"] == ["general.json", "parameters.json.xz"]
    assert set(files["results"].values()) == {"SUCCESS"}
    assert set(files["same"].values()) == {True}
    assert len(files["same"]) == 4
    assert files["remove"] == "FILE_PROTECTED"


def test_metadata_describes_every_parameter(seen: dict[str, Any]) -> None:
    rows = {row["name"]: row for row in seen["metadata"]["parameters"]}
    assert rows.keys() == seen["parameters"]["floats"].keys()
    assert rows["THR_SHUTDOWN"]["units"] == "degC"
    assert rows["THR_SHUTDOWN"]["default"] == 100


@pytest.mark.parametrize("autopilot", [ARDUPILOT, PX4])
def test_a_command_to_all_is_the_autopilots_to_answer(tmp_path: Path, autopilot: int) -> None:
    """It ends a command at the first acknowledgement, and the autopilot's comes late here: an
    UNSUPPORTED of the light's would make a vehicle that arms look as if it had not."""
    with light_at(tmp_path) as address, relay_to(address, autopilot) as relay:
        acks = run(relay.address, tmp_path, "broadcast")
    results = {name: ack["result"] for name, ack in acks.items()}
    assert results == {"arm": ACCEPTED, "request": ACCEPTED, "named": UNSUPPORTED}
