# SPDX-License-Identifier: Apache-2.0
"""What a reset does: the lamp is off at that instant, and the light says why it came back."""

from __future__ import annotations

import pytest

from harness import ACCEPTED, Light, of, texts

# Longest time that a stalled thread may go unnoticed [s].
BITE_S = 10


@pytest.mark.parametrize("thread", ["command", "thermal"])
def test_stalled_thread_lets_the_watchdog_reset_the_light(udp_light: Light, thread: str) -> None:
    udp_light.configure(100)
    assert udp_light.on() == ACCEPTED
    udp_light.sim.edges()
    boots = udp_light.sim.outputs()["resets"]
    udp_light.sim.fault("thread", "stalled", name=thread)
    stalled_us = udp_light.sim.now_us()
    udp_light.sim.advance(s=BITE_S)
    outputs = udp_light.sim.outputs()
    assert outputs["resets"] == boots + 1
    assert outputs["reset_cause"] == "watchdog"
    assert outputs["level_ppm"] == 0
    dark = udp_light.sim.edges()[-1]
    assert dark.level_ppm == 0
    assert dark.time_us - stalled_us < BITE_S * 1_000_000
    assert dark.time_us == outputs["reset_us"], "the lamp is off at the instant of the reset"


def test_light_answers_after_a_watchdog_reset_with_the_lamp_off(udp_light: Light) -> None:
    udp_light.on()
    udp_light.sim.fault("thread", "stalled", name="command")
    udp_light.sim.advance(s=BITE_S)
    udp_light.greet()
    assert udp_light.status().enable == 0
    assert udp_light.on() == ACCEPTED


def test_stalled_command_thread_falls_silent(udp_light: Light) -> None:
    udp_light.sim.fault("thread", "stalled", name="command")
    udp_light.sim.advance(s=1)
    stalled_us = udp_light.sim.now_us()
    udp_light.collect(0)
    came = udp_light.collect(1)
    if udp_light.sim.outputs()["resets"] == 0:
        assert of("HEARTBEAT", came) == [], f"a heartbeat after {stalled_us} µs came from a timer"


@pytest.mark.parametrize("waiting", range(9))
def test_odd_numbers_of_bytes_that_wait_over_a_reset_shift_nothing(
    udp_light: Light, waiting: int
) -> None:
    """What is carried over lies behind them; a sanitizer notices when it is not aligned."""
    before = udp_light.sim.wires()["uart0"].rx_bytes
    udp_light.mav.link.send(bytes(waiting))
    udp_light.sim.reset()
    udp_light.greet()
    assert udp_light.on() == ACCEPTED
    assert udp_light.sim.wires()["uart0"].rx_bytes >= before + waiting


def test_reset_cause_is_said_after_boot(udp_light: Light) -> None:
    udp_light.sim.fault("thread", "stalled", name="command")
    udp_light.sim.advance(s=BITE_S)
    udp_light.greet()
    udp_light.sim.advance(s=5)
    udp_light.mav.drain()
    said = " ".join(texts(list(udp_light.mav.history))) + udp_light.sim.console()
    assert "watchdog" in said


def test_reset_line_turns_the_lamp_off_and_uptime_starts_anew(udp_light: Light) -> None:
    udp_light.sim.advance(s=100)
    udp_light.on()
    udp_light.sim.edges()
    now = udp_light.sim.now_us()
    udp_light.sim.reset()
    udp_light.sim.advance(0)
    edges = udp_light.sim.edges()
    assert [(e.time_us, e.level_ppm) for e in edges] == [(now, 0)]
    udp_light.greet()
    assert udp_light.status().uptime_ms < 3000
    assert udp_light.sim.now_us() > 100_000_000
    assert udp_light.sim.outputs()["reset_cause"] == "pin"


def test_heat_survives_a_reset(udp_light: Light) -> None:
    udp_light.configure(100)
    udp_light.on()
    udp_light.sim.advance(s=1800)
    hot = udp_light.status().temp_c
    udp_light.sim.reset()
    udp_light.greet()
    assert udp_light.status().temp_c == pytest.approx(hot, abs=2)


def test_ten_resets_in_a_row(light: Light) -> None:
    for _ in range(10):
        assert light.on() == ACCEPTED
        light.sim.reset()
        light.greet()
        assert light.status().enable == 0
