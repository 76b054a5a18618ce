# SPDX-License-Identifier: Apache-2.0
"""Same seed and same inputs: the same trace, byte for byte."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from harness import TRANSPORTS, light_on, simulator


def _trace(folder: Path, name: str, seed: int, transport: str = "udp", load: int = 0) -> bytes:
    path = folder / name
    over = TRANSPORTS[transport]
    wires = {over.wire: over.address}
    with simulator(wires, seed=seed, options=["--trace", str(path)]) as sim:
        light = light_on(sim, transport=over)
        light.configure(80, 0.3, 40)
        light.on()
        sim.fault(over.wire, "flipped", rate_ppm=5_000)
        for step in range(40):
            light.mav.send_command_long(405, step % 2)
            sim.advance(97_531)
            # Host time passes here without effect on the light's time.
            sum(range(load))
        sim.set_ambient(60)
        sim.advance(s=300)
        assert sim.quit() == 0
    return path.read_bytes()


@pytest.mark.parametrize("transport", sorted(TRANSPORTS))
def test_same_seed_and_inputs_give_the_same_trace(tmp_path: Path, transport: str) -> None:
    first = _trace(tmp_path, "first", 7, transport)
    second = _trace(tmp_path, "second", 7, transport, load=100_000)
    assert len(first) > 10_000
    assert first == second


def test_another_seed_gives_another_trace(tmp_path: Path) -> None:
    assert _trace(tmp_path, "seven", 7) != _trace(tmp_path, "eight", 8)


def test_how_time_is_cut_into_advances_makes_no_difference(
    tmp_path: Path, start: Callable[..., object]
) -> None:
    traces = []
    for name, step_us in (("coarse", 60_000_000), ("fine", 1_234_567)):
        path = tmp_path / name
        with simulator(seed=3, options=["--trace", str(path)]) as sim:
            left = 60_000_000
            while left:
                left -= (us := min(left, step_us))
                sim.advance(us)
            sim.quit()
        traces.append(path.read_bytes())
    assert traces[0] == traces[1]
