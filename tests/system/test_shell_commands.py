# SPDX-License-Identifier: Apache-2.0
"""What the device's shell says to a command that it cannot carry out, and that the command changed
nothing; and commands that no other page tries."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from harness import CONSOLE, FULL_PPM, WIRES, Light, Shell, light_on
from pharos import MavlinkConnection, Simulator, Source

# A processor is longer at it than at other lines.
LIST_US = 2_000_000


@pytest.fixture
def both(start: Callable[..., Simulator]) -> tuple[Light, Shell]:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    return light_on(sim), Shell(sim)


# --- parameters -----------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("param get nothing", "no parameter begins with 'nothing' (see: param list)"),
        ("param set LGT_LOS 1", "no parameter 'LGT_LOS' (see: param list)"),
        ("param set LGT_SRC_NOW 1", "LGT_SRC_NOW is read-only"),
        ("param set LGT_LOSS abc", "'abc' is not a number, such as 2 or 0.5"),
        ("param set LGT_SRC_EXCL 1.5", "'1.5' is not a whole number"),
        ("param set LGT_SRC_EXCL 16", "16 is out of range (see: param get LGT_SRC_EXCL)"),
        (
            "param set THR_RECOVER 90",
            "90 does not go with a related parameter (see: param get THR_)",
        ),
    ],
)
def test_a_parameter_that_is_refused(both: tuple[Light, Shell], line: str, said: str) -> None:
    shell = both[1]
    before = shell.keys("param list\r", LIST_US).partition("\n")[2]
    assert said in shell(line)
    assert shell.keys("param list\r", LIST_US).partition("\n")[2] == before
    assert re.search(r"THR_RECOVER +79 degC ", shell("param set THR_RECOVER 79"))


def test_all_parameters_go_back_to_their_defaults(both: tuple[Light, Shell]) -> None:
    shell = both[1]
    shell("param set LGT_LOSS 43.21")
    shell("param set THR_SAFE 5")
    assert "all parameters are at their defaults" in shell("param reset")
    assert re.search(r"LGT_LOSS +0 s ", shell("param get LGT_LOSS"))
    assert re.search(r"THR_SAFE +10 % ", shell("param get THR_SAFE"))


# --- the lamp -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("light set brightness forty", "brightness: 'forty' is not a number of percent"),
        ("light set period -1", "period: '-1' is not a number of seconds"),
        ("light set duty 1e3", "duty: '1e3' is not a number of percent"),
        ("light set mode foo", "mode: 'foo' is neither internal nor sync"),
    ],
)
def test_a_setting_that_is_refused(both: tuple[Light, Shell], line: str, said: str) -> None:
    light, shell = both
    light.configure(60)
    before = shell("light status").partition("\n")[2]
    assert said in shell(line)
    assert shell("light status").partition("\n")[2] == before


def test_the_mode_is_set_and_told(both: tuple[Light, Shell]) -> None:
    light, shell = both
    assert "\nok" in shell("light set mode SYNC")
    assert "external sync" in shell("light status")
    assert light.status().mode == 2
    assert "\nok" in shell("light set mode internal")
    assert light.status().mode == 1


def test_a_lamp_that_is_too_hot_stays_dark(both: tuple[Light, Shell]) -> None:
    light, shell = both
    light.sim.set(temp_mdegc=90_000)
    light.sim.advance(s=2)
    assert re.search(r"state +throttling", shell("thermal"))
    light.sim.set(temp_mdegc=105_000)
    light.sim.advance(s=2)
    assert "not now: over temperature (see: thermal)" in shell("light on")
    assert light.level_ppm() == 0
    assert "over temperature" in shell("selftest")
    light.sim.set(temp_mdegc=25_000)
    light.sim.advance(s=15)
    assert "\nok" in shell("light on")
    assert light.level_ppm() == FULL_PPM


# --- who may --------------------------------------------------------------------------------------
EXCLUDED = "the shell may not command (see: param get LGT_SRC_EXCL)"


def test_an_excluded_shell_says_so(both: tuple[Light, Shell]) -> None:
    light, shell = both
    light.configure(60)
    shell("param set THR_SAFE 5")
    shell("param set LGT_SRC_EXCL 8")
    assert EXCLUDED in shell("light on")
    assert EXCLUDED in shell("param reset")
    assert EXCLUDED in shell("selftest")
    assert "the shell is excluded" in shell("param set THR_SAFE 6")
    assert "refused: not on this board, or the shell may not command now" in shell("power on aux")
    assert light.level_ppm() == 0
    assert re.search(r"THR_SAFE +5 % ", shell("param get THR_SAFE"))
    assert re.search(r"aux +off", shell("power status"))
    shell("param set LGT_SRC_EXCL 0")
    assert "\nok" in shell("light on")


def test_a_shell_that_is_outranked_says_so(both: tuple[Light, Shell]) -> None:
    light, shell = both
    shell("param set LGT_SRC_PRIO 1")
    light.configure(60)
    light.on()
    said = "not now: another source is in command (see: light status)"
    assert said in shell("light off")
    assert said in shell("selftest")
    assert light.status().enable == 1
    shell("param set LGT_SRC_PRIO 0")
    assert "\nok" in shell("light off")


# --- power, resets, the vehicle -------------------------------------------------------------------
def test_a_channel_that_is_saved_is_on_after_a_start(both: tuple[Light, Shell]) -> None:
    light, shell = both
    if "aux" not in shell("power status"):
        pytest.skip("needs channels of power, which the board has not")
    assert "no channel 'x' (see: power status)" in shell("power save x")
    shell("power on aux")
    assert re.search(r"aux +on, after a start off", shell("power status"))
    assert "\nok" in shell("power save aux")
    assert re.search(r"aux +on, after a start on", shell("power status"))
    light.sim.advance(s=2)
    light.sim.request("reset", cause="power-on")
    light.sim.advance(s=1)
    assert re.search(r"aux +on, after a start on", shell("power status"))


def test_a_reset_by_hand_is_dark_first(both: tuple[Light, Shell]) -> None:
    light, shell = both
    light.on()
    assert light.level_ppm() > 0
    resets = light.sim.outputs()["resets"]
    shell("reset now")
    light.sim.advance(s=1)
    assert light.sim.outputs()["resets"] == resets + 1
    assert light.level_ppm() == 0
    assert "software" in shell("reset cause")


def test_the_system_id_says_where_it_is_from(both: tuple[Light, Shell]) -> None:
    light, shell = both
    assert "1, until a vehicle is heard" in shell("mavlink")
    autopilot = MavlinkConnection(light.mav.link, light.sim, light.mav.dialect, Source(7, 1))
    autopilot.send(autopilot.dialect.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3))
    light.sim.advance(20_000)  # a processor's time
    assert "a vehicle is heard, waiting for others" in shell("mavlink")
