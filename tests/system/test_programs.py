# SPDX-License-Identifier: Apache-2.0
"""Light programs, from the lamp's recorded output: what is expected is written out here."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import pytest

from harness import ACCEPTED, CONSOLE, FULL_PPM, SECOND_US, WIRES, Light, Shell, light_on
from parameters import get_param, set_param
from pharos import Edge, Simulator

NONE, ANTI_COLLISION, DOUBLE_FLASH, FADE, SOS = range(5)  # LGT_PROGRAM

# International Morse code, ITU-R M.1677-1.
MORSE = {"S": "...", "O": "---"}


def morse(text: str, dot_us: int) -> list[tuple[bool, int]]:
    """(lit, how long) of every part, and the space between words after it."""
    letters = []
    for letter in text:
        signals = [[(True, {".": 1, "-": 3}[signal])] for signal in MORSE[letter]]
        letters.append(list(itertools.chain(*(s + [(False, 1)] for s in signals)))[:-1])
    parts = list(itertools.chain(*(letter + [(False, 3)] for letter in letters)))[:-1]
    return [(lit, dots * dot_us) for lit, dots in [*parts, (False, 7)]]


def run(light: Light, program: int, seconds: float) -> list[Edge]:
    """Lights the lamp with that program; what its output does from the first light on."""
    assert set_param(light, "LGT_PROGRAM", program) == program
    light.sim.edges()
    assert light.on() == ACCEPTED
    light.sim.advance(round(seconds * SECOND_US))
    return light.sim.edges()


def parts(edges: list[Edge]) -> list[tuple[bool, int]]:
    return [(a.level_ppm > 0, b.time_us - a.time_us) for a, b in itertools.pairwise(edges)]


@pytest.mark.parametrize("rate", [40, 60, 100])
def test_anti_collision_flashes_at_its_rate(udp_light: Light, rate: int) -> None:
    set_param(udp_light, "PRG_RATE", rate)
    edges = run(udp_light, ANTI_COLLISION, 60)
    flashes = [e for e in edges[:-1] if e.level_ppm]
    assert len(flashes) in (rate, rate + 1)  # the first at 0 s, perhaps one at 60 s
    period = 60 * SECOND_US // rate
    expected = [(True, 100_000), (False, period - 100_000)]
    assert parts(edges)[: 2 * (rate - 1)] == expected * (rate - 1)
    assert {e.level_ppm for e in edges} == {0, FULL_PPM}


def test_double_flash(udp_light: Light) -> None:
    set_param(udp_light, "PRG_RATE", 50)
    set_param(udp_light, "PRG_FLASH", 0.06)
    edges = run(udp_light, DOUBLE_FLASH, 30)
    # every 1.2 s: 60 ms lit, 60 ms dark, 60 ms lit, and dark for the rest
    expected = [(True, 60_000), (False, 60_000), (True, 60_000), (False, 1_020_000)]
    assert parts(edges)[:96] == expected * 24


@pytest.mark.parametrize("dot_ms", [50, 200, 1000])
def test_sos_is_morse(udp_light: Light, dot_ms: int) -> None:
    set_param(udp_light, "PRG_DOT", dot_ms / 1000)
    edges = run(udp_light, SOS, 4 * 34 * dot_ms / 1000)
    once = morse("SOS", dot_ms * 1000)
    assert sum(length for _, length in once) == 34 * dot_ms * 1000
    assert parts(edges)[: 3 * len(once)] == 3 * once


def test_fade_breathes(udp_light: Light) -> None:
    edges = run(udp_light, FADE, 12)
    breaths = {k: [e.level_ppm for e in edges if _breath(edges, e) == k] for k in (0, 1, 2)}
    assert breaths[1] == breaths[2]
    levels = breaths[1]
    top = levels.index(max(levels))
    assert levels[:top] == sorted(levels[:top])
    assert levels[top:] == sorted(levels[top:], reverse=True)
    assert levels[top] >= 0.99 * FULL_PPM * 0.99
    assert levels[0] < 0.001 * FULL_PPM
    # even to the eye: half way up in time is a quarter of the light
    half = next(e for e in edges if e.time_us - edges[0].time_us >= SECOND_US)
    assert half.level_ppm == pytest.approx(FULL_PPM / 4, rel=0.03)
    # steps of 20 ms: nobody sees them
    assert {length for _, length in parts(edges)} <= {20_000, 40_000}


def _breath(edges: list[Edge], edge: Edge) -> int:
    return (edge.time_us - edges[0].time_us) // (4 * SECOND_US)


def test_a_program_does_not_drift_in_a_day(udp_light: Light) -> None:
    udp_light.mav.command_long(511, 440, -1)
    set_param(udp_light, "PRG_RATE", 70)  # 857 142 us, which divides neither second nor day
    begin = run(udp_light, ANTI_COLLISION, 1)[0].time_us
    udp_light.sim.advance(s=86_400 - 10)
    udp_light.sim.skip_edges()
    udp_light.sim.advance(s=20)
    rising = [e.time_us for e in udp_light.sim.edges() if e.level_ppm]
    assert len(rising) >= 22
    assert {(t - begin) % 857_142 for t in rising} == {0}


def test_406_means_what_it_always_meant(udp_light: Light) -> None:
    """A program shows only where 406 commands no strobe, and 440 says what was commanded."""
    run(udp_light, SOS, 1)
    assert udp_light.configure(50, 0.0, 100) == ACCEPTED
    status = udp_light.status()
    assert (status.enable, status.brightness, status.strobe_period) == (1, 50.0, 0.0)
    assert status.strobe_duty_cycle == 100.0
    assert udp_light.configure(100, 0.5, 50) == ACCEPTED
    udp_light.sim.advance(s=3)
    udp_light.sim.edges()
    udp_light.sim.advance(s=5)
    assert {length for _, length in parts(udp_light.sim.edges())} == {250_000}
    # a strobe that is lit all the time is steady light
    assert udp_light.configure(100, 0.5, 100) == ACCEPTED
    udp_light.sim.advance(s=1)
    udp_light.sim.edges()
    udp_light.sim.advance(s=10)
    assert udp_light.sim.edges() == []
    assert udp_light.level_ppm() == FULL_PPM
    # and without a strobe the program is back, from its beginning
    assert udp_light.configure(100, 0.0, 100) == ACCEPTED
    udp_light.sim.advance(s=14)
    edges = udp_light.sim.edges()
    assert parts(edges)[:17] == morse("SOS", 200_000)[1:18]
    udp_light.off()
    assert udp_light.level_ppm() == 0
    udp_light.sim.edges()
    udp_light.sim.advance(s=10)
    assert udp_light.sim.edges() == []


def test_brightness_and_heat_limit_a_program(udp_light: Light) -> None:
    assert set_param(udp_light, "LGT_CURVE", 0) == 0  # linear
    assert udp_light.configure(40, 0.0, 100) == ACCEPTED
    assert max(e.level_ppm for e in run(udp_light, FADE, 8)) == pytest.approx(396_000, rel=0.01)
    # the sensor fails: no more than THR_SAFE, whatever the program says
    safe = get_param(udp_light, "THR_SAFE") * 10_000  # % to ppm
    udp_light.sim.fault("thermistor", "open")
    udp_light.sim.advance(s=2)
    udp_light.sim.edges()
    udp_light.sim.advance(s=8)
    assert max(e.level_ppm for e in udp_light.sim.edges()) == safe


def test_over_temperature_ends_every_program(udp_light: Light) -> None:
    run(udp_light, FADE, 4)
    udp_light.sim.set(ambient_mdegc=110_000)
    udp_light.sim.advance(s=3600)
    assert udp_light.status().error_status & 2
    udp_light.sim.edges()
    udp_light.sim.advance(s=60)
    assert udp_light.sim.edges() == []
    assert udp_light.level_ppm() == 0


def test_the_shell_picks_a_program(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    light = light_on(sim)
    shell = Shell(sim)
    light.on()
    for at, name in enumerate(("none", "anti-collision", "double-flash", "fade", "sos")):
        assert "ok" in shell(f"light program {name}")
        assert get_param(light, "LGT_PROGRAM") == at
        assert f"program       {name}\n" in shell("light status")
    assert "there are: none, anti-collision, double-flash, fade, sos" in shell(
        "light program disco"
    )
    light.configure(100, 1, 50)
    assert "sos, but a strobe or external sync is commanded" in shell("light status")
