# SPDX-License-Identifier: Apache-2.0
"""`pharos check` with a light sensor: what the lamp itself does."""

from __future__ import annotations

import sys
from bisect import bisect_right
from collections.abc import Callable
from pathlib import Path

import pytest

from checking import OPTICAL_FAULTS, checked, failing, on_simulator
from model_light import ModelLight
from pharos import LinkError, Simulator, UsageError
from pharos.check import Level, selected
from pharos.photodiode import open_photodiode
from real_light import wait_for


# --- with a sensor --------------------------------------------------------------------------------
class Sensor:
    """Sees a light of ours, or of another make, once each millisecond of its time."""

    def __init__(self, clock: Callable[[], int], level: Callable[[int], float]) -> None:
        self._clock = clock
        self._level = level
        self._since_us = 0

    def take(self) -> list[tuple[float, float]]:
        start, self._since_us = self._since_us, self._clock()
        return [(t / 1e6, self._level(t)) for t in range(start, self._since_us, 1000)]

    def close(self) -> None:
        pass


def test_a_right_lamp_passes() -> None:
    light = ModelLight()
    report = checked(light, "OP", photodiode=Sensor(light.now_us, light.level))
    assert [r.outcome for r in report.results] == ["passed"] * 5


@pytest.mark.parametrize("fault", OPTICAL_FAULTS)
def test_each_fault_of_the_lamp_is_seen(fault: str) -> None:
    light = ModelLight({fault})
    report = checked(light, "OP", photodiode=Sensor(light.now_us, light.level))
    assert tuple(report.broken()) == OPTICAL_FAULTS[fault]


def test_a_lamp_that_does_not_dim_is_weak() -> None:
    light = ModelLight({"is all the same to brightness"})
    report = checked(light, "OP", photodiode=Sensor(light.now_us, light.level))
    assert failing(report, Level.SHOULD) == ["OP-5"]


def test_our_lamp_passes(binary: Path) -> None:
    with Simulator(binary, {"uart0": "udpin:127.0.0.1:0"}) as sim:
        edges: list[tuple[int, int]] = [(0, 0)]

        def level(time_us: int) -> float:
            """From the light's own record of its output, which is fetched as time goes on."""
            if edges[-1][0] <= time_us:
                edges.extend((e.time_us, e.level_ppm) for e in sim.edges())
            at = bisect_right(edges, (time_us, 1 << 40))
            return edges[at - 1][1] / 1e6

        sensor = Sensor(sim.now_us, level)
        report = on_simulator(
            sim, sim.connect("uart0"), requirements=selected(["OP"]), photodiode=sensor
        )
    assert [r.outcome for r in report.results] == ["passed"] * 5


def test_a_sensor_is_a_command(tmp_path: Path) -> None:
    script = tmp_path / "sensor.py"
    script.write_text("import signal; print('0.5 12'); print('0.6 13', flush=True); signal.pause()")
    sensor = open_photodiode(f"{sys.executable} {script}")
    samples: list[tuple[float, float]] = []

    def came() -> bool:
        samples.extend(sensor.take())
        return len(samples) == 2

    wait_for(came, "two samples")
    sensor.close()
    assert samples == [(0.5, 12.0), (0.6, 13.0)]


@pytest.mark.parametrize(("text", "hint"), [("print('much light')", "much light"), ("", "ended")])
def test_a_sensor_that_says_nothing_useful_is_told_of(tmp_path: Path, text: str, hint: str) -> None:
    script = tmp_path / "sensor.py"
    script.write_text(text)
    sensor = open_photodiode(f"{sys.executable} {script}")

    def has_ended() -> bool:
        try:
            return bool(sensor.take())
        except LinkError as error:
            return hint in str(error)

    wait_for(has_ended, hint)
    sensor.close()
    with pytest.raises(UsageError):
        open_photodiode("/nonexistent/sensor")


def test_a_sensor_of_the_kernels_is_read(tmp_path: Path) -> None:
    raw = tmp_path / "in_intensity_raw"
    raw.write_text("42\n")
    sensor = open_photodiode(f"iio:{raw}")
    samples: list[tuple[float, float]] = []
    wait_for(lambda: bool(samples.extend(sensor.take()) or len(samples) > 3), "samples")
    sensor.close()
    assert {level for _, level in samples} == {42.0}
    with pytest.raises(LinkError):
        open_photodiode(f"iio:{tmp_path}/none")
