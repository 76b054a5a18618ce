# SPDX-License-Identifier: Apache-2.0
"""Start-up: the lamp is dark until its temperature is known and somebody watches; whatever fails,
hangs or comes late meanwhile is told, and only stalls are bitten."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from harness import (
    ACCEPTED,
    CONSOLE,
    FAILED,
    FULL_PPM,
    OVER_TEMPERATURE,
    STATE_ACTIVE,
    STATE_CRITICAL,
    THERMISTOR_FAILURE,
    WIRES,
    Light,
    Shell,
    from_light,
    of,
    texts,
)
from parameters import set_param
from pharos import Simulator

Start = Callable[..., Simulator]
MS = 1000
# A stall is noticed after 1 s, in steps of 0.25 s, and bitten at most 1 s later.
BITE_MS = 1000 + 250 + 1000


def _power_up(sim: Simulator, *faults: tuple[Any, ...]) -> Light:
    """Takes power away and gives it back, with faults (chip, kind, fields) that are there from the
    first instant."""
    light = Light(sim, sim.connect("uart0"))
    _restart(sim, *faults)
    return light


def _restart(sim: Simulator, *faults: tuple[Any, ...]) -> None:
    for name, kind, *rest in faults:
        sim.fault("chip", kind, name=name, **(rest[0] if rest else {}))
    sim.request("reset", cause="power-on")


def _begin(start: Start, *faults: tuple[Any, ...]) -> tuple[Light, Shell]:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    light = _power_up(sim, *faults)
    light.mav.heartbeat()
    light.sim.advance(s=2)
    light.mav.drain()
    return light, Shell(sim)


def _state(light: Light) -> int:
    return int(of("HEARTBEAT", from_light(light.collect(2)))[-1].system_status)


def _told(light: Light) -> list[str]:
    """Everything that it has said, and says again: within half a minute."""
    light.sim.advance(s=31)
    light.mav.drain()
    return texts(list(light.mav.history))


def _resets_of(sim: Simulator) -> int:
    return int(sim.outputs()["resets"])


def _resets(light: Light) -> int:
    return _resets_of(light.sim)


def _assert_dark_and_well(light: Light) -> None:
    """It answers, refuses to light the lamp, and nothing bites."""
    before = _resets(light)
    assert light.on() == FAILED
    light.sim.advance(s=20)
    assert light.level_ppm() == 0
    assert light.sim.outputs()["peak_ppm"] == 0
    assert _state(light) == STATE_CRITICAL
    assert _resets(light) == before


# --- the first sample -------------------------------------------------------------------------
def test_on_before_the_first_sample_is_accepted_and_lights_with_it(start: Start) -> None:
    sim = start({"uart0": WIRES["udp"]})
    light = _power_up(sim, ("adc", "late", {"delay_us": 80 * MS}))
    assert light.on() == ACCEPTED
    assert sim.now_us() < 80 * MS
    assert light.level_ppm() == 0
    sim.advance(79 * MS - sim.now_us())
    assert light.level_ppm() == 0
    sim.advance(2 * MS)
    assert light.level_ppm() == FULL_PPM


def test_on_without_a_sample_fails_once_samples_count_as_missing(start: Start) -> None:
    sim = start({"uart0": WIRES["udp"]})
    light = _power_up(sim, ("adc", "error"))
    assert light.on() == ACCEPTED
    sim.advance(600 * MS)
    assert light.on() == FAILED
    assert light.status().enable == 1  # it lights should a sample come
    assert light.level_ppm() == 0


def test_open_sensor_at_power_up_is_dark_and_one_that_opens_later_is_not(start: Start) -> None:
    sim = start({"uart0": WIRES["udp"]})
    sim.fault("thermistor", "open")
    light = _power_up(sim)
    light.greet()
    assert light.on() == FAILED
    assert light.status().error_status == THERMISTOR_FAILURE
    sim.fault("thermistor", "none")
    sim.advance(s=2)
    assert light.on() == ACCEPTED
    sim.fault("thermistor", "open")
    sim.advance(200 * MS)
    assert 0 < light.level_ppm() < FULL_PPM


def test_a_parameter_allows_the_safe_level_without_a_first_sample(start: Start) -> None:
    sim = start({"uart0": WIRES["udp"]})
    light = Light(sim, sim.connect("uart0"))
    light.greet()
    set_param(light, "THR_FIRST", 3)
    sim.advance(s=2)
    _restart(sim, ("adc", "never"))
    sim.advance(2900 * MS)
    assert light.on() == FAILED
    sim.advance(200 * MS)
    assert light.on() == ACCEPTED
    assert light.level_ppm() == 100_000  # THR_SAFE


# --- heat -------------------------------------------------------------------------------------
def test_reset_while_hotter_than_the_sensor_can_tell_stays_dark(start: Start) -> None:
    sim = start({"uart0": WIRES["udp"]})
    sim.set(ambient_mdegc=160_000, temp_mdegc=160_000)  # THR_SENS_MAX is 150
    light = _power_up(sim)
    light.greet()
    assert light.on() == FAILED
    assert light.status().error_status & OVER_TEMPERATURE
    assert _state(light) == STATE_CRITICAL
    sim.set(ambient_mdegc=20_000, temp_mdegc=20_000)
    sim.advance(s=5)
    assert light.on() == ACCEPTED
    assert light.level_ppm() > 0


def test_short_is_heat(start: Start) -> None:
    sim = start({"uart0": WIRES["udp"]})
    light = Light(sim, sim.connect("uart0"))
    light.greet()
    assert light.on() == ACCEPTED
    sim.fault("thermistor", "short")
    sim.advance(110 * MS)
    assert light.level_ppm() == 0
    assert light.status().error_status == OVER_TEMPERATURE | THERMISTOR_FAILURE
    set_param(light, "THR_HOT", 5)
    sim.fault("thermistor", "none")
    sim.advance(s=20)
    assert light.level_ppm() == FULL_PPM
    sim.fault("thermistor", "short")
    sim.advance(110 * MS)
    assert light.level_ppm() == 50_000


# --- steps that fail --------------------------------------------------------------------------
@pytest.mark.parametrize("chip", ["watchdog", "pwm", "gpio"])
def test_without_what_the_lamp_needs_it_stays_dark_and_says_so(start: Start, chip: str) -> None:
    light, shell = _begin(start, (chip, "error"))
    step = "watchdog" if chip == "watchdog" else "light"
    _assert_dark_and_well(light)
    assert any(t.startswith(f"Start failed: {step}, error -") for t in _told(light))
    shown = shell("startup")
    assert f"{step:<14}error -" in shown
    assert "stays dark" in shown
    assert "error -" not in shell("light status")
    assert "Pharos" in shell("version")


@pytest.mark.parametrize("kind", ["error", "never"])
def test_without_samples_it_stays_dark_and_says_so(start: Start, kind: str) -> None:
    light, shell = _begin(start, ("adc", kind))
    _assert_dark_and_well(light)
    assert "Temperature sensor failed: no samples" in texts(list(light.mav.history))
    assert light.status().error_status == THERMISTOR_FAILURE
    assert ("error -" in shell("startup")) == (kind == "error")
    assert "no samples" in shell("thermal")


@pytest.mark.parametrize(
    ("chip", "step"),
    [("counter", "edge time"), ("can0", "can0"), ("imc", "imc"), ("uart1", "uart1")],
)
def test_what_the_lamp_can_do_without_is_told_and_the_lamp_works(
    start: Start, chip: str, step: str
) -> None:
    light, shell = _begin(start, (chip, "error"))
    assert light.on() == ACCEPTED
    assert light.level_ppm() == FULL_PPM
    assert _state(light) == STATE_ACTIVE
    assert any(t.startswith(f"Start failed: {step}, error -") for t in _told(light))
    assert f"{step:<14}error -" in shell("startup")
    assert _resets(light) == 1


def test_every_step_of_a_whole_start_is_shown(start: Start) -> None:
    light, shell = _begin(start)
    shown = shell("startup")
    assert "watchdog      ok, 1000 ms" in shown
    for step in ("light", "sensor", "storage", "sync input", "uart0", "can0", "imc", "button"):
        assert f"{step:<14}ok" in shown
    assert "error" not in shown
    assert "not reached" not in shown
    assert not [t for t in _told(light) if "failed" in t]


# --- the watchdog -----------------------------------------------------------------------------
def test_a_watchdog_that_runs_already_is_taken_over(start: Start) -> None:
    light, shell = _begin(start, ("watchdog", "running"))
    assert light.on() == ACCEPTED
    light.sim.advance(s=20)
    assert light.level_ppm() == FULL_PPM
    assert _resets(light) == 1
    assert "watchdog      ok, 100 ms" in shell("startup")


def test_a_watchdog_that_is_fed_no_more_bites(start: Start) -> None:
    light, _ = _begin(start)
    light.sim.fault("chip", "error", name="watchdog")
    light.sim.advance(1100 * MS)
    outputs = light.sim.outputs()
    assert (outputs["resets"], outputs["reset_cause"]) == (2, "watchdog")


WATCHED = ["thermal", "command", "uart_link0", "uart_link1", "uart_link2", "uart_link3",
           "can_link", "imc_link"]  # fmt: skip


@pytest.mark.parametrize("thread", WATCHED)
def test_a_thread_that_stalls_before_its_first_report_is_bitten(start: Start, thread: str) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    sim.fault("thread", "stalled at start", name=thread)
    sim.request("reset", cause="power-on")
    assert sim.outputs()["resets"] == 1
    sim.advance(BITE_MS * MS)
    outputs = sim.outputs()
    assert (outputs["resets"], outputs["reset_cause"]) == (2, "watchdog")
    assert outputs["peak_ppm"] == 0
    sim.fault("thread", "none", name=thread)
    sim.advance(BITE_MS * MS)
    shell = Shell(sim)
    assert f"watchdog (thread {thread} stalled)" in shell("reset cause")


@pytest.mark.parametrize("thread", WATCHED)
def test_without_a_watchdog_the_supervisor_resets_the_board(start: Start, thread: str) -> None:
    light, _ = _begin(start, ("watchdog", "error"))
    light.sim.fault("thread", "stalled", name=thread)
    light.sim.advance(BITE_MS * MS)
    outputs = light.sim.outputs()
    assert (outputs["resets"], outputs["reset_cause"]) == (2, "software")
    light.sim.advance(s=1)
    assert f"software (thread {thread} stalled)" in Shell(light.sim)("reset cause")


@pytest.mark.parametrize("chip", ["pwm", "gpio", "storage"])
def test_a_start_that_hangs_is_bitten_and_dark(start: Start, chip: str) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    _restart(sim, (chip, "never"))
    sim.advance(s=10)
    outputs = sim.outputs()
    assert outputs["resets"] >= 5
    assert outputs["reset_cause"] == "watchdog"
    assert outputs["peak_ppm"] == 0
    sim.fault("chip", "none", name=chip)
    sim.advance(BITE_MS * MS)
    light = Light(sim, sim.connect("uart0"))
    light.greet()
    assert light.on() == ACCEPTED
    assert light.level_ppm() == FULL_PPM


@pytest.mark.parametrize(
    "line",
    ["light status", "light on", "light set brightness 5", "thermal", "param list", "mavlink",
     "link stats", "selftest", "power status", "can", "imc", "gimbal status",
     "display", "outputs", "route", "signing status",
     "startup", "reset cause"],
)  # fmt: skip
def test_the_shell_waits_for_no_thread_that_is_not_there(start: Start, line: str) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    sim.fault("thread", "stalled at start", name="command")
    sim.request("reset", cause="power-on")
    answer = Shell(sim)(line)
    assert _resets_of(sim) == 1
    assert answer.endswith("pharos:~$ "), answer
    asks = line.split()[0] not in ("thermal", "link", "startup", "reset")
    assert ("has not started" in answer) == asks


@pytest.mark.parametrize("line", ["light status", "param get thr_miss"])
def test_a_line_that_comes_during_the_start_is_done_after_it(start: Start, line: str) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    _restart(sim, ("storage", "late", {"delay_us": 300 * MS}))
    assert sim.now_us() == 0
    assert "has not started" not in Shell(sim)(line)
    assert sim.now_us() < 1000 * MS
    assert _resets_of(sim) == 1


def test_settings_that_are_never_stored_are_told_and_the_light_goes_on(start: Start) -> None:
    light, _ = _begin(start)
    light.sim.fault("chip", "never", name="storage")
    set_param(light, "LGT_LOSS", 5)
    assert light.on() == ACCEPTED
    light.sim.advance(s=12)
    light.mav.drain()
    said = [t for t in texts(list(light.mav.history)) if "stored" in t]
    assert said == ["Settings can't be stored: error -110"]
    assert light.level_ppm() == FULL_PPM
    assert _resets(light) == 1


# --- what fails later -------------------------------------------------------------------------
@pytest.mark.parametrize("chip", ["pwm", "gpio"])
def test_a_lamp_that_cannot_be_driven_is_dark_told_and_recovers(start: Start, chip: str) -> None:
    light, shell = _begin(start)
    light.configure(100, 1.0, 50)
    assert light.on() == ACCEPTED
    light.sim.advance(200 * MS)
    assert light.level_ppm() == FULL_PPM
    light.sim.fault("chip", "error", name=chip)
    light.sim.advance(s=2)
    light.sim.skip_edges()
    light.sim.advance(s=5)
    assert not light.sim.edges()
    assert light.level_ppm() == 0
    assert _resets(light) == 1
    assert light.on() == FAILED
    assert _state(light) == STATE_CRITICAL
    light.mav.drain()
    assert "Lamp driver reports a fault" in texts(list(light.mav.history))
    assert "that failed, last -5" in shell("light status")
    light.sim.fault("chip", "none", name=chip)
    light.sim.advance(s=12)
    light.mav.drain()
    assert "Lamp driver is well again" in texts(list(light.mav.history))
    assert light.on() == ACCEPTED
    assert len(light.sim.edges()) >= 10
    assert _state(light) == STATE_ACTIVE


def test_a_lamp_that_cannot_be_made_dark_is_reset(start: Start) -> None:
    light, _ = _begin(start)
    assert light.on() == ACCEPTED
    for chip in ("pwm", "gpio"):
        light.sim.fault("chip", "error", name=chip)
    assert light.level_ppm() == FULL_PPM
    light.off()
    light.sim.advance(110 * MS)
    assert light.level_ppm() == 0
    outputs = light.sim.outputs()
    assert (outputs["resets"], outputs["reset_cause"]) == (2, "software")
    light.sim.advance(s=10)
    assert _resets(light) == 2


@pytest.mark.parametrize(
    ("kind", "fields"), [("never", {}), ("error", {}), ("late", {"delay_us": 400 * MS})]
)
def test_an_adc_that_fails_later_leaves_the_safe_level(
    start: Start, kind: str, fields: dict[str, int]
) -> None:
    light, _ = _begin(start)
    assert light.on() == ACCEPTED
    light.sim.fault("chip", kind, name="adc", **fields)
    light.sim.advance(700 * MS)
    assert light.level_ppm() == 100_000  # THR_SAFE
    assert light.status().error_status == THERMISTOR_FAILURE
    light.sim.advance(s=20)
    assert _resets(light) == 1
    light.sim.fault("chip", "none", name="adc")
    light.sim.advance(s=20)
    # an ADC that has not answered in time is not asked again
    assert light.level_ppm() == (FULL_PPM if kind == "error" else 100_000)
