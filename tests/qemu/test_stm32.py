# SPDX-License-Identifier: Apache-2.0
"""An image with an STM32's own drivers, on QEMU's STM32F405 (boards/olimex_stm32_h405.overlay). Its
ADC never says that it is done; with boards/adc_fixed.overlay the image has a stand-in for it."""

from __future__ import annotations

import pytest

from harness import ACCEPTED, Light, Shell, light_on, of, texts
from qemu import QemuSimulator

FAILED = 4  # MAV_RESULT_FAILED
CRITICAL = 5  # MAV_STATE_CRITICAL
SENSOR_FAILED = 4  # ILLUMINATOR_ERROR_FLAGS_THERMISTOR_FAILURE
# An output of the GPIO port C is set and reset by its BSRR, at 0x18: the enable line is bit 1.
BSRR_WRITE = "GPIOC: unimplemented device write (size 4, offset 0x018, value 0x"
SET, RESET = 1 << 1, 1 << 17


pytestmark = pytest.mark.only_on("CONFIG_SOC_SERIES_STM32F4X")
real_adc = pytest.mark.only_on("!CONFIG_PHAROS_ADC_FIXED")
stand_in = pytest.mark.only_on("CONFIG_PHAROS_ADC_FIXED")


def _enable_writes(sim: QemuSimulator) -> list[int]:
    return [
        int(line.rpartition("0x")[2].rstrip(")"), 16)
        for line in sim.log().splitlines()
        if BSRR_WRITE in line
    ]


@pytest.fixture
def light(sim: QemuSimulator) -> Light:
    return light_on(sim)


def test_shell_and_mavlink_answer(sim: QemuSimulator, light: Light) -> None:
    shell = Shell(sim)
    assert "output now" in shell("light status")
    assert light.status().uptime_ms > 0


@real_adc
def test_dark_and_says_why_when_the_adc_never_answers(sim: QemuSimulator, light: Light) -> None:
    assert light.on() == FAILED
    heard = light.collect(2.5)
    assert {m.system_status for m in of("HEARTBEAT", heard)} == {CRITICAL}
    assert light.status().error_status & SENSOR_FAILED
    assert "Temperature sensor failed: no samples" in sim.console()
    shell = Shell(sim)
    assert "no samples" in shell("thermal")
    assert "output now    0 %" in shell("light status")
    # the watchdog is fed: a sensor that is silent is no stall
    assert light.status().uptime_ms > 4000
    assert not [value for value in _enable_writes(sim) if value & SET]


@stand_in
def test_lit_and_strobes(sim: QemuSimulator, light: Light) -> None:
    assert light.on() == ACCEPTED
    sim.advance(s=1)
    assert "output now    100 %" in Shell(sim)("light status")
    assert _enable_writes(sim)[-1] & SET
    assert light.configure(brightness=50, period_s=0.1, duty=50) == ACCEPTED
    before = len(_enable_writes(sim))
    sim.advance(s=1)
    edges = _enable_writes(sim)[before:]
    assert 18 <= len(edges) <= 22, "ten periods of 100 ms"
    assert all(bool(a & SET) != bool(b & SET) for a, b in zip(edges, edges[1:], strict=False))
    assert light.off() == ACCEPTED
    sim.advance(s=1)
    assert _enable_writes(sim)[-1] & RESET
    assert not [text for text in texts(light.mav.inbox) if "failed" in text]
