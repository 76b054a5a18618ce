# SPDX-License-Identifier: Apache-2.0
"""The gimbal: servos, shell, DroneCAN. The model's servos say where the beam points: 1500 us is
straight ahead, 500 us more or less are 90 degrees."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from dronecan import uavcan

from harness import BUS, CONSOLE, NODE, Shell
from pharos import Simulator, read_vcd

Starts = Callable[..., Simulator]


def angles(sim: Simulator) -> tuple[float, float]:
    """Pan and tilt of the model's servos [deg]."""
    servos = sim.outputs()["servos"]
    return servos["pan"]["angle_mdeg"] / 1000, servos["tilt"]["angle_mdeg"] / 1000


def pulses(sim: Simulator) -> tuple[int, int]:
    servos = sim.outputs()["servos"]
    return int(servos["pan"]["pulse_ns"]), int(servos["tilt"]["pulse_ns"])


@pytest.fixture
def shell(start: Starts) -> Shell:
    sim = start({"console": CONSOLE})
    sim.advance(s=1)
    return Shell(sim)


# --- servos and shell -----------------------------------------------------------------------------
def test_starts_neutral(start: Starts) -> None:
    sim = start()
    assert pulses(sim) == (1_500_000, 1_500_000)
    sim.advance(s=1)
    assert angles(sim) == (0, 0)


def test_shell_points_and_the_servos_follow(shell: Shell) -> None:
    sim = shell.sim
    assert "ok" in shell("gimbal pan 45")
    assert "ok" in shell("gimbal tilt -22.5")
    sim.advance(s=2)
    assert angles(sim) == (45, -22.5)
    status = shell("gimbal status")
    assert "pan           45 deg" in status
    assert "tilt          -22.5 deg" in status
    assert "commander     shell" in status
    assert "ok" in shell("gimbal retract")
    sim.advance(s=2)
    assert angles(sim) == (0, -90)
    assert "ok" in shell("gimbal neutral")
    sim.advance(s=2)
    assert angles(sim) == (0, 0)


def test_shell_refuses_what_is_no_angle(shell: Shell) -> None:
    assert "is not a number of degrees" in shell("gimbal pan left")
    assert "is not a number of degrees" in shell("gimbal tilt 1e9")
    assert "out of range" in shell("gimbal tilt 361")
    shell.sim.advance(s=1)
    assert angles(shell.sim) == (0, 0)


def test_parameters_turn_trim_and_limit_the_servos(shell: Shell) -> None:
    shell("param set GMB_PAN_PW_MIN 2000")
    shell("param set GMB_PAN_PW_MAX 1000")
    shell("param set GMB_TLT_TRIM 50")
    shell("param set GMB_TLT_MIN -30")
    shell("gimbal pan 45")
    shell("gimbal tilt -80")
    shell.sim.advance(s=3)
    # 1500 - 250; the lowest tilt is now at 1000 us, and 50 us more
    assert pulses(shell.sim) == (1_250_000, 1_050_000)
    assert "at its limit" in shell("gimbal status")


def test_slew_rate_is_kept_and_servos_are_told_at_50_hz_while_they_move(start: Starts) -> None:
    sim = start({"console": CONSOLE}, options=["--record", "{folder}/r.vcd"])
    sim.advance(s=1)
    shell = Shell(sim)
    shell("param set GMB_PAN_RATE 30")
    shell("gimbal pan 30")
    sim.advance(s=5)
    assert sim.quit() == 0
    pan = read_vcd(sim.folder / "r.vcd")["pan_pulse_ns"]
    moves = [
        (time, pulse)
        for time, pulse in zip(pan.times_us, pan.values, strict=True)
        if isinstance(pulse, int) and pulse > 1_500_000
    ]
    assert len(moves) == 50  # 30 degrees at 30 degrees per second
    assert {b[0] - a[0] for a, b in pairwise(moves)} == {20_000}
    assert moves[-1][1] == 1_666_666  # 1500 us + 500 us / 3


def test_disabled_gimbal_is_not_there_after_a_reset(shell: Shell) -> None:
    sim = shell.sim
    shell("param set GMB_ENABLE 0")
    sim.advance(s=2)
    sim.reset()
    sim.advance(s=2)
    assert pulses(sim) == (0, 0)
    assert "there is no gimbal" in shell("gimbal pan 10")
    assert "there is no gimbal" in shell("gimbal status")


def test_reset_brings_it_back_to_neutral(shell: Shell) -> None:
    sim = shell.sim
    shell("gimbal pan 45")
    sim.advance(s=2)
    sim.reset()
    assert angles(sim) == (45, 0)
    sim.advance(s=2)
    assert angles(sim) == (0, 0)


# --- DroneCAN -------------------------------------------------------------------------------------
def actuators(**values: float) -> Any:
    """ArrayCommand: pan is servo 9, tilt servo 10; unitless."""
    ids = {"pan": 9, "tilt": 10}
    return uavcan.equipment.actuator.ArrayCommand(
        commands=[
            uavcan.equipment.actuator.Command(actuator_id=ids[name], command_value=value)
            for name, value in values.items()
        ]
    )


class Autopilot:
    """A node that commands servos; one throughout, so that its transfers count on."""

    def __init__(self, sim: Simulator) -> None:
        self.sim = sim
        self.node = sim.node(9)
        self.set("CAN_ACT_PAN", 9)
        self.set("CAN_ACT_TILT", 10)

    def set(self, name: str, value: int) -> None:
        request = uavcan.protocol.param.GetSet.Request()
        request.name.encode(name)
        request.value.integer_value = value
        assert self.node.ask(request, NODE, self.sim).value.integer_value == value

    def tell(self, **values: float) -> None:
        self.node.broadcast(actuators(**values))
        self.sim.advance(s=2)


@pytest.fixture
def autopilot(start: Starts) -> Autopilot:
    sim = start({"can0": BUS, "console": CONSOLE})
    sim.advance(s=1)
    return Autopilot(sim)


def test_dronecan_actuators_point_the_beam(autopilot: Autopilot) -> None:
    autopilot.tell(pan=0.5, tilt=-1.0)
    assert angles(autopilot.sim) == (45, -90)  # shares of the range of ±90 degrees
    autopilot.tell(pan=-1.0)
    assert angles(autopilot.sim) == (-90, -90)
    assert "pan and tilt 0" in Shell(autopilot.sim)("can")


def test_dronecan_repetition_does_not_take_the_gimbal_back(autopilot: Autopilot) -> None:
    autopilot.tell(pan=0.5)
    shell = Shell(autopilot.sim)
    shell("gimbal pan -10")
    autopilot.tell(pan=0.5)
    assert angles(autopilot.sim)[0] == -10
    assert "commander     shell" in shell("gimbal status")
    autopilot.tell(pan=0.25)
    assert angles(autopilot.sim)[0] == 22.5


def test_excluded_source_does_not_point(autopilot: Autopilot) -> None:
    autopilot.set("LGT_SRC_EXCL", 2)
    autopilot.tell(pan=0.5)
    assert angles(autopilot.sim)[0] == 0
    assert "ok" in Shell(autopilot.sim)("gimbal pan 5")


def test_without_a_gimbal_pan_and_tilt_are_counted(autopilot: Autopilot) -> None:
    autopilot.set("GMB_ENABLE", 0)
    autopilot.sim.advance(s=2)
    autopilot.sim.reset()
    autopilot.sim.advance(s=2)
    autopilot.tell(pan=0.5, tilt=0.5)
    assert "pan and tilt 2" in Shell(autopilot.sim)("can")
