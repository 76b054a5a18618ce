# SPDX-License-Identifier: Apache-2.0
"""Commands that take time: the self-test (MAV_CMD_USER_1 with param1 1), step by step and ended in
every way; and the commands that maintain the light, which are done at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from harness import (
    ACCEPTED,
    CONFIGURE,
    CONSOLE,
    DENIED,
    FAILED,
    FULL_PPM,
    INF,
    NAN,
    ON_OFF,
    QEMU_IMAGE,
    UNSUPPORTED,
    WIRES,
    Light,
    Shell,
    light_on,
    of,
    texts,
)
from parameters import get_param, set_param
from pharos import MavlinkConnection, Simulator, Source, Target

SELF_TEST = 31010  # MAV_CMD_USER_1
STORAGE = 245  # MAV_CMD_PREFLIGHT_STORAGE
REBOOT = 246  # MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN
FORCE = 20190226.0  # REBOOT_SHUTDOWN_CONDITIONS_FORCE

TEMPORARILY_REJECTED = 1
IN_PROGRESS = 5
CANCELLED = 6

# COMMAND_ACK.result_param2 of the self-test
PASSED = 2
SENSOR_FAILED = 3
DRIVER_FAILED = 4
TOO_HOT = 5
INTERRUPTED = 7

TEST_US = 2_000_000


def _begin(light: Light, *params: float) -> None:
    ack = light.mav.command_long(SELF_TEST, 1, *params)
    assert (ack.result, ack.progress, ack.result_param2) == (IN_PROGRESS, 0, 0)


def _acks(messages: list[Any], command: int = SELF_TEST) -> list[Any]:
    return [ack for ack in of("COMMAND_ACK", messages) if ack.command == command]


def _end(mav: MavlinkConnection, timeout_us: int = TEST_US + 500_000) -> Any:
    """The final acknowledgement; what comes before it is progress."""
    return mav.recv(
        "COMMAND_ACK",
        timeout_us=timeout_us,
        where=lambda ack: ack.command == SELF_TEST and ack.result != IN_PROGRESS,
    )


def _cancel(mav: MavlinkConnection, command: int = SELF_TEST, target: Target | None = None) -> None:
    to = target or mav.target
    mav.send(mav.dialect.MAVLink_command_cancel_message(to.system, to.component, command))


# --- the test ------------------------------------------------------------------------------------


def test_says_how_far_it_is_and_then_once_that_it_passed(light: Light) -> None:
    begin_us = light.sim.now_us()
    _begin(light)
    acks = _acks(light.collect(4))
    *progress, end = acks
    assert {ack.result for ack in progress} == {IN_PROGRESS}
    percents = [ack.progress for ack in progress]
    assert percents == list(range(10, 100, 10))
    assert (end.result, end.progress, end.result_param2) == (ACCEPTED, 0, PASSED)
    source = light.mav.source
    for ack in acks:
        assert (ack.target_system, ack.target_component) == (source.system, source.component)
    assert light.sim.now_us() - begin_us > TEST_US


def test_lamp_goes_up_to_full_and_down_again(udp_light: Light) -> None:
    udp_light.sim.skip_edges()
    _begin(udp_light)
    udp_light.sim.advance(s=3)
    levels = [edge.level_ppm for edge in udp_light.sim.edges()]
    top = levels.index(max(levels))
    assert levels[top] == FULL_PPM
    assert levels[:top] == sorted(levels[:top])
    assert levels[top:] == sorted(levels[top:], reverse=True)
    assert len(levels) >= 35
    assert udp_light.level_ppm() == 0
    assert udp_light.status().enable == 0


@pytest.mark.parametrize(("percent", "full"), [(0, 100), (NAN, 100), (100, 100), (50, 50)])
def test_peak_is_what_param2_says(udp_light: Light, percent: float, full: float) -> None:
    udp_light.sim.skip_edges()
    set_param(udp_light, "LGT_CURVE", 0)
    _begin(udp_light, percent)
    assert _end(udp_light.mav).result == ACCEPTED
    peak = max(edge.level_ppm for edge in udp_light.sim.edges())
    assert peak == pytest.approx(full * FULL_PPM / 100, rel=0.001)


def test_says_it_to_people(udp_light: Light) -> None:
    _begin(udp_light)
    assert "Self-test: passed" in texts(udp_light.collect(3))


def test_lamp_and_status_are_as_they_were_commanded(udp_light: Light) -> None:
    assert udp_light.configure(40, 0.5, 50) == ACCEPTED
    assert udp_light.on() == ACCEPTED
    udp_light.sim.advance(s=5)
    before = udp_light.settings()
    _begin(udp_light)
    udp_light.sim.advance(s=1)
    assert udp_light.settings() == before
    udp_light.sim.advance(s=2)
    assert udp_light.settings() == before
    udp_light.sim.skip_edges()
    udp_light.sim.advance(s=5)
    edges = udp_light.sim.edges()
    assert len(edges) == 20, "ten flashes in 5 s"
    assert {edge.level_ppm for edge in edges} == {0, max(edge.level_ppm for edge in edges)}


def test_heat_limits_the_lamp_meanwhile(udp_light: Light) -> None:
    udp_light.sim.set_ambient(90)
    udp_light.sim.advance(s=600)
    limit = int(udp_light.sim.outputs()["limit_ppm"])
    assert 0 < limit < FULL_PPM
    udp_light.sim.skip_edges()
    _begin(udp_light)
    assert _end(udp_light.mav).result == ACCEPTED
    assert max(edge.level_ppm for edge in udp_light.sim.edges()) <= limit


@pytest.mark.parametrize(
    "params",
    [(0,), (2,), (NAN,), (1.5,), (1, -1), (1, 100.5), (1, INF), (1, -INF), (255, 50)],
)
def test_bad_parameters_are_denied_and_begin_nothing(
    udp_light: Light, params: tuple[float, ...]
) -> None:
    udp_light.sim.skip_edges()
    assert udp_light.mav.command_long(SELF_TEST, *params).result == DENIED
    assert _acks(udp_light.collect(1)) == []
    assert udp_light.sim.edges() == []


# --- the same again ------------------------------------------------------------------------------


def test_the_same_command_again_is_in_progress(light: Light) -> None:
    _begin(light)
    light.sim.advance(s=1)
    light.mav.drain()
    light.mav.inbox.clear()
    again = light.mav.command_long(SELF_TEST, 1, confirmation=1)
    assert again.result == IN_PROGRESS
    assert 40 <= again.progress <= 50
    acks = _acks(light.collect(3))
    assert [ack.result for ack in acks if ack.result != IN_PROGRESS] == [ACCEPTED]


def test_other_parameters_are_rejected_for_now(udp_light: Light) -> None:
    _begin(udp_light, 80)
    assert udp_light.mav.command_long(SELF_TEST, 1, 81).result == TEMPORARILY_REJECTED
    # another maker's USER_1, as at any other time
    assert udp_light.mav.command_long(SELF_TEST, 2, 80).result == DENIED
    assert udp_light.mav.command_long(SELF_TEST, 1, 80).result == IN_PROGRESS
    assert _end(udp_light.mav).result == ACCEPTED
    assert udp_light.mav.command_long(SELF_TEST, 1, 81).result == IN_PROGRESS


def test_command_int_is_the_same_command(udp_light: Light) -> None:
    _begin(udp_light, 80)
    assert udp_light.mav.command_int(SELF_TEST, 1, 80).result == IN_PROGRESS
    assert udp_light.mav.command_int(SELF_TEST, 1, 81).result == TEMPORARILY_REJECTED


def test_the_result_goes_to_who_asked_first(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"], "uart1": WIRES["tcp"]})
    light = light_on(sim)
    other = sim.connect("uart1", Source(254, 191))
    _begin(light)
    assert other.command_long(SELF_TEST, 1).result == IN_PROGRESS
    assert _end(light.mav).result == ACCEPTED
    assert _acks(other.pass_time(1_000_000)) == []


# --- cancelled -----------------------------------------------------------------------------------


def test_cancel_ends_it_and_the_lamp_is_back(light: Light) -> None:
    _begin(light)
    light.sim.advance(s=1)
    assert light.level_ppm() > 0
    _cancel(light.mav)
    end = _end(light.mav, 200_000)
    assert (end.result, end.progress, end.result_param2) == (CANCELLED, 0, 0)
    assert light.level_ppm() == 0
    assert _acks(light.collect(3)) == []


def test_another_client_may_cancel_and_both_are_told(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"], "uart1": WIRES["tcp"]})
    light = light_on(sim)
    other = sim.connect("uart1", Source(254, 191))
    _begin(light)
    _cancel(other)
    assert _end(other, 500_000).result == CANCELLED
    assert _end(light.mav, 500_000).result == CANCELLED


def test_cancelling_something_else_ends_nothing(udp_light: Light) -> None:
    _begin(udp_light)
    _cancel(udp_light.mav, ON_OFF)
    _cancel(udp_light.mav, SELF_TEST, Target(1, 1))
    assert _end(udp_light.mav).result == ACCEPTED


def test_cancelling_nothing_is_met_with_silence(udp_light: Light) -> None:
    for command in (SELF_TEST, ON_OFF, 0, 65535):
        _cancel(udp_light.mav, command)
    assert of("COMMAND_ACK", udp_light.collect(1)) == []


def test_after_a_cancel_it_can_begin_again(udp_light: Light) -> None:
    for _ in range(3):
        _begin(udp_light)
        _cancel(udp_light.mav)
        assert _end(udp_light.mav, 200_000).result == CANCELLED


# --- interrupted, and failed ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "params"), [(ON_OFF, (1,)), (ON_OFF, (0,)), (CONFIGURE, (1, 30, 0, 100))]
)
def test_another_command_interrupts_it_and_rules(
    udp_light: Light, command: int, params: tuple[float, ...]
) -> None:
    _begin(udp_light)
    udp_light.sim.advance(s=1)
    udp_light.mav.drain()
    udp_light.mav.inbox.clear()
    assert udp_light.mav.command_long(command, *params).result == ACCEPTED
    end = _end(udp_light.mav, 200_000)
    assert (end.result, end.result_param2) == (FAILED, INTERRUPTED)
    on = udp_light.status().enable == 1
    assert on == ((command, params) == (ON_OFF, (1,)))
    assert (udp_light.level_ppm() > 0) == on


def test_a_denied_command_does_not_interrupt(udp_light: Light) -> None:
    _begin(udp_light)
    assert udp_light.configure(brightness=101) == DENIED
    assert udp_light.mav.command_long(12345).result == UNSUPPORTED
    assert _end(udp_light.mav).result == ACCEPTED


def test_fails_at_once_with_a_failed_sensor(udp_light: Light) -> None:
    udp_light.sim.fault("thermistor", "open")
    udp_light.sim.advance(s=1)
    udp_light.sim.skip_edges()
    ack = udp_light.mav.command_long(SELF_TEST, 1)
    assert (ack.result, ack.result_param2) == (FAILED, SENSOR_FAILED)
    udp_light.sim.advance(s=3)
    assert udp_light.sim.edges() == []


@pytest.mark.parametrize("kind", ["open", "short"])
def test_finds_a_sensor_that_fails_meanwhile(udp_light: Light, kind: str) -> None:
    _begin(udp_light)
    udp_light.sim.advance(s=1)
    udp_light.sim.fault("thermistor", kind)
    end = _end(udp_light.mav, 500_000)
    assert (end.result, end.result_param2) == (FAILED, SENSOR_FAILED)
    assert "Self-test: temperature sensor failed" in texts(udp_light.collect(1)) + texts(
        list(udp_light.mav.history)
    )
    assert udp_light.level_ppm() == 0


def test_finds_a_fault_of_the_driver(udp_light: Light) -> None:
    _begin(udp_light)
    udp_light.sim.gpio("driver_fault", False)
    end = _end(udp_light.mav, 500_000)
    assert (end.result, end.result_param2) == (FAILED, DRIVER_FAILED)
    ack = udp_light.mav.command_long(SELF_TEST, 1)
    assert (ack.result, ack.result_param2) == (FAILED, DRIVER_FAILED)
    udp_light.sim.gpio("driver_fault", True)
    udp_light.sim.advance(s=1)
    _begin(udp_light)


def test_fails_while_too_hot(udp_light: Light) -> None:
    udp_light.sim.set_ambient(120)
    udp_light.sim.advance(s=1200)
    ack = udp_light.mav.command_long(SELF_TEST, 1)
    assert (ack.result, ack.result_param2) == (FAILED, TOO_HOT)


def test_driver_faults_are_told_to_people(udp_light: Light) -> None:
    udp_light.sim.gpio("driver_fault", False)
    assert texts(udp_light.collect(1)) == ["Lamp driver reports a fault"]
    udp_light.sim.gpio("driver_fault", True)
    assert texts(udp_light.collect(20)) == ["Lamp driver is well again"]


# --- from the shell ------------------------------------------------------------------------------


@pytest.fixture
def shell_light(start: Callable[..., Simulator]) -> tuple[Light, Shell]:
    sim = start({"uart0": WIRES["udp"]}, options=["--console", CONSOLE])
    return light_on(sim), Shell(sim)


def test_shell_runs_it_and_says_the_result(shell_light: tuple[Light, Shell]) -> None:
    light, shell = shell_light
    light.sim.skip_edges()
    shell.keys("selftest 30\r", 1_000_000)
    assert light.mav.command_long(SELF_TEST, 1).result == TEMPORARILY_REJECTED
    assert "passed" in shell.keys("", 2_000_000)
    assert light.sim.edges()
    light.sim.fault("thermistor", "open")
    light.sim.advance(s=1)
    assert "temperature sensor failed" in shell("selftest")


@pytest.mark.parametrize("argument", ["0", "-1", "101", "x", "100.00001"])
def test_shell_refuses_what_is_no_brightness(
    shell_light: tuple[Light, Shell], argument: str
) -> None:
    light, shell = shell_light
    light.sim.skip_edges()
    assert "is not a brightness" in shell(f"selftest {argument}")
    assert light.sim.edges() == []


# --- commands that maintain the light ------------------------------------------------------------


def _boots(light: Light) -> int:
    return int(light.sim.outputs()["resets"])


@pytest.mark.parametrize("component", [0, 243])
def test_reboots_after_the_answer(light: Light, component: int) -> None:
    boots = _boots(light)
    assert light.mav.command_long(REBOOT, 0, 0, 1, component).result == ACCEPTED
    light.sim.advance(s=2)
    assert _boots(light) == boots + 1
    light.greet()
    assert light.status().uptime_ms < 5000


def test_a_parameter_set_just_before_survives_the_reboot(udp_light: Light) -> None:
    if QEMU_IMAGE:
        pytest.skip("needs settings that outlast a reset: the board keeps them in RAM")
    assert set_param(udp_light, "LGT_RESTORE", 1) == 1
    assert udp_light.mav.command_long(REBOOT, 0, 0, 1).result == ACCEPTED
    udp_light.sim.advance(s=2)
    udp_light.greet()
    assert get_param(udp_light, "LGT_RESTORE") == 1


def test_a_lamp_that_is_on_needs_force(udp_light: Light) -> None:
    assert udp_light.on() == ACCEPTED
    boots = _boots(udp_light)
    assert udp_light.mav.command_long(REBOOT, 0, 0, 1).result == TEMPORARILY_REJECTED
    udp_light.sim.advance(s=2)
    assert _boots(udp_light) == boots
    ack = udp_light.mav.command_long(REBOOT, 0, 0, 1, 0, 0, FORCE)
    assert ack.result == ACCEPTED
    udp_light.sim.advance(s=2)
    assert _boots(udp_light) == boots + 1


@pytest.mark.parametrize(
    "params", [(1,), (1, 1), (0, 0, 2), (0, 0, 3), (0, 0, NAN), (0, 0, 1, 1), (0, 0, 1, NAN)]
)
def test_other_reboots_are_denied(udp_light: Light, params: tuple[float, ...]) -> None:
    boots = _boots(udp_light)
    assert udp_light.mav.command_long(REBOOT, *params).result == DENIED
    udp_light.sim.advance(s=2)
    assert _boots(udp_light) == boots


@pytest.mark.parametrize("action", [2, 4])
def test_parameters_go_back_to_their_defaults_and_are_told(udp_light: Light, action: int) -> None:
    assert set_param(udp_light, "STRB_MIN", 0.02) == 0.02
    udp_light.mav.drain()
    udp_light.mav.inbox.clear()
    assert udp_light.mav.command_long(STORAGE, action, -1).result == ACCEPTED
    told = [m.param_id for m in of("PARAM_VALUE", udp_light.mav.pass_time(1_000_000))]
    assert told == ["STRB_MIN"]
    assert get_param(udp_light, "STRB_MIN") == 0.01
    udp_light.sim.reset()
    udp_light.greet()
    assert get_param(udp_light, "STRB_MIN") == 0.01


def test_reading_and_writing_the_store_have_nothing_to_do(udp_light: Light) -> None:
    assert set_param(udp_light, "STRB_MIN", 0.02) == 0.02
    for action in (0, 1):
        assert udp_light.mav.command_long(STORAGE, action).result == ACCEPTED
    assert get_param(udp_light, "STRB_MIN") == 0.02


@pytest.mark.parametrize("action", [3, 5, -1, NAN, 0.5])
def test_other_actions_on_the_store_are_denied(udp_light: Light, action: float) -> None:
    assert udp_light.mav.command_long(STORAGE, action).result == DENIED
