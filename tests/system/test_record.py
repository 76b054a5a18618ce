# SPDX-License-Identifier: Apache-2.0
"""--record writes what the lamp did as a value change dump that logic-analyser programs open."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from harness import FULL_PPM, WIRES, light_on
from pharos import Simulator, read_vcd


def test_recorded_level_is_what_the_edges_say(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    path = tmp_path / "light.vcd"
    sim = start({"uart0": WIRES["udp"]}, options=["--record", str(path)])
    light = light_on(sim)
    light.configure(100, 0.2, 25)
    sim.edges()
    light.on()
    sim.advance(s=3)
    edges = [(e.time_us, e.level_ppm) for e in sim.edges()]
    sim.quit()
    level = read_vcd(path)["level_ppm"]
    recorded = list(zip(level.times_us, level.values, strict=True))
    assert len(edges) == 30
    assert [r for r in recorded if r[0] >= edges[0][0]] == edges


def test_recorded_temperature_follows_the_heat(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    path = tmp_path / "heat.vcd"
    sim = start({"uart0": WIRES["udp"]}, options=["--record", str(path)])
    light = light_on(sim)
    light.configure(100)
    light.on()
    sim.advance(s=1800)
    last = light.status().temp_c
    sim.quit()
    temperature = read_vcd(path)["temp_mdegc"]
    values = [v for v in temperature.values if isinstance(v, (int, float))]
    assert values[-1] / 1000 == pytest.approx(last, abs=2)
    assert values[-1] > values[0] + 5_000


def test_commands_are_recorded(start: Callable[..., Simulator], tmp_path: Path) -> None:
    path = tmp_path / "commands.vcd"
    sim = start({"uart0": WIRES["udp"]}, options=["--record", str(path)])
    light = light_on(sim)
    for _ in range(5):
        sim.advance(100_000)
        light.on()
    sim.quit()
    command = read_vcd(path)["command"]
    assert [v for v in command.values if v == 405], "five 405s were sent"


def test_recording_without_a_command_has_every_signal_dark(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    path = tmp_path / "dark.vcd"
    sim = start(options=["--record", str(path)])
    sim.advance(s=10)
    sim.quit()
    assert FULL_PPM not in read_vcd(path)["level_ppm"].values


def test_killed_light_leaves_a_readable_recording(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    path = tmp_path / "killed.vcd"
    sim = start({"uart0": WIRES["udp"]}, options=["--record", str(path)])
    light = light_on(sim)
    light.configure(100, 0.1, 50)
    light.on()
    sim.advance(s=600)
    sim.stop()
    text = path.read_text()
    path.write_text(text[: text.rindex("\n") + 1])
    assert FULL_PPM in read_vcd(path)["level_ppm"].values
