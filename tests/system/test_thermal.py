# SPDX-License-Identifier: Apache-2.0
"""The lamp protects itself: throttling, shutdown, recovery, and every way a thermistor fails, as a
client sees them in ILLUMINATOR_STATUS and STATUSTEXT, and as the lamp's output shows them."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import pytest

from harness import (
    ACCEPTED,
    FAILED,
    FULL_PPM,
    OVER_TEMPERATURE,
    STATE_ACTIVE,
    STATE_CRITICAL,
    STATE_EMERGENCY,
    THERMISTOR_FAILURE,
    THROTTLING,
    WIRES,
    Light,
    from_light,
    light_on,
    of,
    texts,
)
from pharos import Simulator, read_vcd

# Far above any shutdown temperature a lamp may have [°C].
HOT = 120.0
COOL = 10.0


def _flags(light: Light) -> int:
    return int(light.status().error_status)


def _until_flag(light: Light, flag: int, seconds: int = 3600) -> None:
    for _ in range(seconds):
        light.sim.advance(s=1)
        light.mav.drain()
        last = [m for m in light.mav.history if m.get_type() == "ILLUMINATOR_STATUS"][-1]
        if last.error_status & flag:
            return
    raise AssertionError(f"error flag {flag} did not come within {seconds} s")


def _shut_down(light: Light) -> None:
    light.configure(100)
    assert light.on() == ACCEPTED
    light.sim.set_ambient(HOT)
    _until_flag(light, OVER_TEMPERATURE)


def test_throttling_is_seen_in_status_and_text(udp_light: Light) -> None:
    udp_light.configure(100)
    udp_light.on()
    udp_light.sim.set_ambient(70)
    _until_flag(udp_light, THROTTLING)
    assert 0 < udp_light.level_ppm() < FULL_PPM
    assert any("hrottl" in t for t in texts(list(udp_light.mav.history)))


def test_throttling_ends_and_says_so_when_it_is_cool_again(udp_light: Light) -> None:
    test_throttling_is_seen_in_status_and_text(udp_light)
    before = len(texts(list(udp_light.mav.history)))
    udp_light.sim.set_ambient(COOL)
    udp_light.sim.advance(s=3600)
    assert _flags(udp_light) == 0
    assert udp_light.level_ppm() == FULL_PPM
    assert len(texts(list(udp_light.mav.history))) > before


def test_shutdown_is_dark_and_seen_in_status_text_and_heartbeat(udp_light: Light) -> None:
    _shut_down(udp_light)
    assert udp_light.level_ppm() == 0
    assert _flags(udp_light) & OVER_TEMPERATURE
    heartbeat = of("HEARTBEAT", from_light(udp_light.collect(2)))[0]
    assert heartbeat.system_status in (STATE_CRITICAL, STATE_EMERGENCY)
    said = [t.lower() for t in texts(list(udp_light.mav.history))]
    assert any("shutdown" in t or "shut down" in t for t in said), said


def test_on_in_thermal_shutdown_is_failed_and_the_lamp_stays_dark(udp_light: Light) -> None:
    _shut_down(udp_light)
    assert udp_light.on() == FAILED
    assert udp_light.level_ppm() == 0
    assert udp_light.off() == ACCEPTED
    assert udp_light.on() == FAILED
    assert udp_light.status().enable == 0


def test_configure_in_thermal_shutdown_is_accepted_and_the_lamp_stays_dark(
    udp_light: Light,
) -> None:
    _shut_down(udp_light)
    assert udp_light.configure(50) == ACCEPTED
    assert udp_light.status().brightness == 50.0
    assert udp_light.level_ppm() == 0


def test_shutdown_is_latched_until_cool_then_recovers(udp_light: Light) -> None:
    _shut_down(udp_light)
    shutdown_c = udp_light.status().temp_c
    udp_light.sim.set_ambient(COOL)
    while _flags(udp_light) & OVER_TEMPERATURE:
        assert udp_light.level_ppm() == 0
        udp_light.sim.advance(s=1)
    assert udp_light.status().temp_c < shutdown_c - 3
    udp_light.sim.advance(s=3600)
    assert _flags(udp_light) == 0
    assert of("HEARTBEAT", from_light(udp_light.collect(2)))[0].system_status == STATE_ACTIVE
    assert udp_light.on() == ACCEPTED
    udp_light.sim.advance(s=1)
    assert udp_light.level_ppm() == FULL_PPM


def test_full_power_with_a_working_fan_in_a_cool_place_runs_for_ever(udp_light: Light) -> None:
    udp_light.configure(100)
    udp_light.on()
    udp_light.sim.set_ambient(20)
    udp_light.sim.advance(s=3600)
    assert _flags(udp_light) == 0
    assert udp_light.level_ppm() == FULL_PPM


def test_failed_fan_in_a_hot_place_shuts_the_lamp_down(udp_light: Light) -> None:
    udp_light.configure(100)
    udp_light.on()
    udp_light.sim.set_ambient(60)
    udp_light.sim.set_fan(False)
    _until_flag(udp_light, OVER_TEMPERATURE)
    assert udp_light.level_ppm() == 0


@pytest.mark.parametrize("kind", ["open", "short", "stuck", "noisy"])
def test_thermistor_failure_limits_the_lamp_and_is_seen(udp_light: Light, kind: str) -> None:
    udp_light.configure(100)
    udp_light.on()
    udp_light.sim.advance(s=10)
    assert udp_light.level_ppm() == FULL_PPM
    udp_light.sim.fault("thermistor", kind)
    # An open or shorted sensor shows in the next sample (10 Hz), the others in time.
    if kind in ("open", "short"):
        udp_light.sim.advance(110_000)
    else:
        _until_flag(udp_light, THERMISTOR_FAILURE, seconds=600)
    assert _flags(udp_light) & THERMISTOR_FAILURE
    if kind == "short":  # the hot end of an NTC
        assert _flags(udp_light) & OVER_TEMPERATURE
        assert udp_light.level_ppm() == 0
    else:
        assert 0 < udp_light.level_ppm() < FULL_PPM
    udp_light.sim.advance(s=5)
    udp_light.mav.drain()
    said = [t.lower() for t in texts(list(udp_light.mav.history))]
    assert any("sensor" in t or "thermistor" in t for t in said), said


@pytest.mark.parametrize("kind", ["open", "short", "stuck", "noisy"])
def test_repaired_thermistor_is_trusted_again(udp_light: Light, kind: str) -> None:
    test_thermistor_failure_limits_the_lamp_and_is_seen(udp_light, kind)
    udp_light.sim.fault("thermistor", "none")
    udp_light.sim.advance(s=120)
    assert _flags(udp_light) == 0
    assert udp_light.level_ppm() == FULL_PPM


def test_thermistor_failing_in_shutdown_does_not_light_the_lamp(udp_light: Light) -> None:
    _shut_down(udp_light)
    udp_light.sim.fault("thermistor", "open")
    udp_light.sim.advance(s=60)
    assert udp_light.level_ppm() == 0
    assert udp_light.on() == FAILED


def _abuse(light: Light, seed: int) -> None:
    """An hour: heat and cold, a failing fan, a failing sensor, and commands all the time."""
    rng = random.Random(seed)
    end = light.sim.now_us() + 3_600_000_000
    while light.sim.now_us() < end:
        choice = rng.randrange(8)
        if choice == 0:
            light.sim.set_ambient(rng.uniform(-20, 110))
        elif choice == 1:
            light.sim.set_fan(rng.random() < 0.5)
        elif choice == 2:
            light.sim.fault("thermistor", rng.choice(["none", "none", "open", "short", "noisy"]))
        elif choice == 3:
            light.off()
        elif choice == 4:
            light.configure(rng.uniform(0, 100), rng.choice([0, 0.1, 0.5]), rng.uniform(0, 100))
        else:
            light.configure(100)
            light.on()
        light.sim.advance(rng.randrange(20_000_000))


@pytest.mark.parametrize("seed", [1, 2])
def test_over_an_hour_of_abuse_the_lamp_never_exceeds_the_limit_of_the_last_sample(
    start: Callable[..., Simulator], tmp_path: Path, seed: int
) -> None:
    record = tmp_path / "abuse.vcd"
    sim = start({"uart0": WIRES["udp"]}, seed=seed, options=["--record", str(record)])
    light = light_on(sim)
    _abuse(light, seed)
    light.mav.drain()
    flags = {m.error_status for m in light.mav.history if m.get_type() == "ILLUMINATOR_STATUS"}
    seen = [any(f & bit for f in flags) for bit in (1, 2, 4)]
    assert seen == [True, True, True], f"the abuse was too mild: flags {sorted(flags)}"
    assert sim.quit() == 0

    signals = read_vcd(record)
    level, limit = signals["level_ppm"], signals["limit_ppm"]
    instants = sorted({*level.times_us, *limit.times_us})
    assert len(instants) > 1000
    for instant in instants:
        now, allowed = level.at(instant), limit.at(instant)
        assert isinstance(now, int)
        assert isinstance(allowed, int)
        assert now <= allowed, f"{now} ppm at {instant} µs with a limit of {allowed} ppm"


def test_the_limit_falls_with_the_very_sample_that_is_too_hot(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    record = tmp_path / "hot.vcd"
    sim = start({"uart0": WIRES["udp"]}, options=["--record", str(record)])
    light = light_on(sim)
    _shut_down(light)
    sim.quit()
    signals = read_vcd(record)
    level, limit = signals["level_ppm"], signals["limit_ppm"]
    dark = next(
        t for t, v in zip(limit.times_us, limit.values, strict=True) if v == 0 and t > 1_000_000
    )
    assert level.at(dark) == 0
    before = level.at(dark - 1)
    assert isinstance(before, int)
    assert before > 0
