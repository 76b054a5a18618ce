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
    # 15 flashes in 3 s, and the one that begins with the last instant.
    assert len(edges) == 31
    # The end of the process turns the lamp off.
    assert [r for r in recorded if r[0] >= edges[0][0]] == [*edges, (edges[-1][0], 0)]


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


def test_commanded_settings_are_recorded(start: Callable[..., Simulator], tmp_path: Path) -> None:
    path = tmp_path / "settings.vcd"
    sim = start({"uart0": WIRES["udp"]}, options=["--record", str(path)])
    light = light_on(sim)
    begin = sim.now_us()
    light.configure(40, 0.25, 30)
    light.on()
    sim.advance(s=1)
    end = sim.now_us()
    sim.quit()
    signals = read_vcd(path)
    assert signals["enable"].at(begin - 1) == 0
    expected = {
        "enable": 1,
        "mode": 1,
        "brightness_ppm": 400_000,
        "strobe_period_us": 250_000,
        "strobe_duty_ppm": 300_000,
    }
    assert {name: signals[name].at(end - 1) for name in expected} == expected


def test_each_command_is_recorded_by_its_number(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    path = tmp_path / "commands.vcd"
    sim = start({"uart0": WIRES["udp"]}, options=["--record", str(path)])
    light = light_on(sim)
    for _ in range(5):
        sim.advance(100_000)
        light.on()
    sim.quit()
    assert read_vcd(path)["command"].values.count(405) == 5


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
