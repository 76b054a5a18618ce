# SPDX-License-Identifier: Apache-2.0
"""External sync: an input line gates the lamp."""

from __future__ import annotations

import pytest

from harness import ACCEPTED, EXTERNAL_SYNC, FULL_PPM, INTERNAL, Light

# The input line's name on the native board.
LINE = "sync"


@pytest.fixture
def synced(udp_light: Light) -> Light:
    """A lamp that is on, at full brightness, and follows the input, which is low."""
    udp_light.sim.gpio(LINE, False)
    assert udp_light.configure(100, mode=EXTERNAL_SYNC) == ACCEPTED
    assert udp_light.on() == ACCEPTED
    udp_light.sim.advance(10_000)
    udp_light.sim.edges()
    return udp_light


def test_lamp_follows_the_input(synced: Light) -> None:
    assert synced.level_ppm() == 0
    for value in (True, False, True, False):
        synced.sim.gpio(LINE, value)
        synced.sim.advance(10_000)
        assert synced.level_ppm() == (FULL_PPM if value else 0)


def test_pulse_length_is_kept_to_the_tick(synced: Light) -> None:
    for length_us in (5_000, 12_345, 77_777):
        synced.sim.gpio(LINE, True)
        synced.sim.advance(length_us)
        synced.sim.gpio(LINE, False)
        synced.sim.advance(20_000)
        rise, fall = synced.sim.edges()
        assert (rise.level_ppm, fall.level_ppm) == (FULL_PPM, 0)
        assert fall.time_us - rise.time_us == length_us


def test_glitch_shorter_than_the_filter_is_not_seen(synced: Light) -> None:
    for _ in range(10):
        synced.sim.gpio(LINE, True)
        synced.sim.advance(10)
        synced.sim.gpio(LINE, False)
        synced.sim.advance(10_000)
    assert synced.sim.edges() == []


def test_input_does_nothing_in_internal_mode(synced: Light) -> None:
    assert synced.configure(100, mode=INTERNAL) == ACCEPTED
    synced.sim.edges()
    for value in (True, False, True):
        synced.sim.gpio(LINE, value)
        synced.sim.advance(10_000)
    assert synced.sim.edges() == []
    assert synced.level_ppm() == FULL_PPM


def test_off_wins_over_the_input(synced: Light) -> None:
    synced.sim.gpio(LINE, True)
    synced.sim.advance(10_000)
    assert synced.off() == ACCEPTED
    assert synced.level_ppm() == 0
    synced.sim.gpio(LINE, False)
    synced.sim.gpio(LINE, True)
    synced.sim.advance(10_000)
    assert synced.level_ppm() == 0


def test_brightness_applies_to_the_synced_lamp(synced: Light) -> None:
    assert synced.configure(50, mode=EXTERNAL_SYNC) == ACCEPTED
    synced.sim.gpio(LINE, True)
    synced.sim.advance(10_000)
    assert 0 < synced.level_ppm() < FULL_PPM
