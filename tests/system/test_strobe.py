# SPDX-License-Identifier: Apache-2.0
"""The strobe's edges, to the microsecond."""

from __future__ import annotations

import itertools
import random
from collections.abc import Sequence

import pytest

from harness import ACCEPTED, FULL_PPM, INTERNAL, ON_OFF, SECOND_US, Light
from pharos import Edge

pytestmark = pytest.mark.usefixtures("udp_light")


def _start(light: Light, period_s: float, duty: float) -> int:
    """Strobes at full brightness; returns when the first flash began."""
    assert light.configure(100, period_s, duty) == ACCEPTED
    light.sim.edges()
    assert light.on() == ACCEPTED
    edges = light.sim.edges()
    assert [e.level_ppm for e in edges] == [FULL_PPM]
    return edges[0].time_us


def _phases(edges: Sequence[Edge]) -> list[tuple[int, int]]:
    """(level, how long) of every phase between two edges."""
    return [(a.level_ppm, b.time_us - a.time_us) for a, b in itertools.pairwise(edges)]


@pytest.mark.parametrize(
    ("period_us", "duty", "lit_us"),
    [(100_000, 50.0, 50_000), (100_000, 10.0, 10_000), (330_000, 70.0, 231_000)],
)
def test_10000_edges_each_on_its_exact_tick(
    udp_light: Light, period_us: int, duty: float, lit_us: int
) -> None:
    begin = _start(udp_light, period_us / 1e6, duty)
    expected = [
        begin + index * period_us + offset for index in range(5001) for offset in (0, lit_us)
    ][1:10_001]
    got: list[Edge] = []
    while len(got) < 10_000:
        udp_light.sim.advance(s=60)
        got += udp_light.sim.edges()
    assert [e.time_us for e in got[:10_000]] == expected
    assert [e.level_ppm for e in got[:10_000]] == [0, FULL_PPM] * 5_000


def test_drift_is_zero_over_a_day(udp_light: Light) -> None:
    # 7 Hz does not divide a second: 142857 µs, 604 800 whole periods less than a day by 86.4 ms.
    period_us = 142_857
    udp_light.mav.command_long(511, 440, -1)
    begin = _start(udp_light, period_us / 1e6, 50)
    reported = round(udp_light.status().strobe_period * 1e6)
    assert reported == period_us
    udp_light.sim.advance(s=86_400 - 10)
    udp_light.sim.skip_edges()
    udp_light.sim.advance(s=20)
    rising = [e.time_us for e in udp_light.sim.edges() if e.level_ppm]
    assert len(rising) >= 139
    assert {(t - begin) % period_us for t in rising} == {0}


def test_first_flash_begins_with_the_command(udp_light: Light) -> None:
    udp_light.configure(100, 0.5, 20)
    now = udp_light.sim.advance(123_456)
    udp_light.sim.edges()
    udp_light.on()
    assert udp_light.sim.edges() == [Edge(now, FULL_PPM)]


def test_off_is_dark_at_once_and_stays_so(udp_light: Light) -> None:
    _start(udp_light, 0.5, 50)
    udp_light.sim.advance(100_000)
    now = udp_light.sim.now_us()
    udp_light.sim.edges()
    udp_light.off()
    assert udp_light.sim.edges() == [Edge(now, 0)]
    udp_light.sim.advance(s=100)
    assert udp_light.sim.edges() == []


@pytest.mark.parametrize("seed", range(4))
def test_change_of_period_or_duty_makes_no_phase_shorter_than_either_setting_would(
    udp_light: Light, seed: int
) -> None:
    rng = random.Random(seed)
    current = (400_000, 50)
    _start(udp_light, current[0] / 1e6, current[1])
    for _ in range(50):
        udp_light.sim.advance(rng.randrange(3 * SECOND_US))
        udp_light.sim.edges()
        new = (rng.randrange(100_000, 2_000_000, 1000), rng.choice((10, 25, 50, 75, 90)))
        before = udp_light.level_ppm()
        since = udp_light.sim.now_us()
        assert udp_light.configure(100, new[0] / 1e6, new[1]) == ACCEPTED
        udp_light.sim.advance(s=6)
        phases = _phases([Edge(since, before), *udp_light.sim.edges()])[1:]
        lit = min(p * d // 100 for p, d in (current, new))
        dark = min(p * (100 - d) // 100 for p, d in (current, new))
        assert phases
        for level, length_us in phases:
            assert length_us >= (lit if level else dark) - 1, f"{current} → {new}: {phases}"
        current = new


def test_change_takes_effect_within_one_period_of_either_setting(udp_light: Light) -> None:
    _start(udp_light, 2.0, 50)
    udp_light.sim.advance(300_000)
    udp_light.configure(100, 0.2, 50)
    udp_light.sim.advance(2_200_000)
    udp_light.sim.edges()
    udp_light.sim.advance(s=2)
    assert {length for _, length in _phases(udp_light.sim.edges())} == {100_000}


def test_change_of_brightness_alone_keeps_the_rhythm(udp_light: Light) -> None:
    begin = _start(udp_light, 0.5, 50)
    for brightness in range(10, 100, 7):
        udp_light.sim.advance(170_000)
        udp_light.configure(brightness, 0.5, 50)
    udp_light.sim.advance(s=1)
    udp_light.sim.edges()
    udp_light.sim.advance(s=10)
    assert {(e.time_us - begin) % 250_000 for e in udp_light.sim.edges()} == {0}


def test_flashes_keep_their_rhythm_while_commands_pour_in(udp_light: Light) -> None:
    begin = _start(udp_light, 0.1, 50)
    for _ in range(200):
        for _ in range(5):
            udp_light.mav.send_command_long(ON_OFF, 1)
        udp_light.sim.advance(17_000)
    edges = udp_light.sim.edges()
    assert len(edges) > 60
    assert {(e.time_us - begin) % 50_000 for e in edges} == {0}
    assert udp_light.status().mode == INTERNAL
