# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests that need a kernel with CAN and GPIO: guest.py runs them in its guest.
What they are made of is in guest_can.py, guest_gpio.py and guest_light.py."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
IN_GUEST = os.environ.get("PHAROS_GUEST") == "1"

if not IN_GUEST:
    collect_ignore_glob = ["*"]
else:
    sys.path.insert(0, str(ROOT / "host" / "src"))
    sys.path.insert(0, str(ROOT / "tests" / "native"))
    from guest_can import vcan
    from guest_gpio import GpioSim
    from guest_i2c import Lm75
    from guest_light import BINARIES, Light, Start


@pytest.fixture
def vcan0() -> Iterator[str]:
    """The name of a virtual CAN interface that is up, with room for CAN FD frames."""
    with vcan("vcan0") as name:
        yield name


@pytest.fixture
def vcan1() -> Iterator[str]:
    with vcan("vcan1") as name:
        yield name


@pytest.fixture
def gpio_sim() -> Iterator[Callable[..., GpioSim]]:
    """gpio_sim("name of line 0", …): a chip of gpio-sim."""
    with ExitStack() as stack:
        count = 0

        def make(*lines: str) -> GpioSim:
            nonlocal count
            chip = GpioSim(f"chip{count}", lines)
            count += 1
            stack.callback(chip.remove)
            return chip

        yield make


@pytest.fixture(params=sorted(BINARIES) if IN_GUEST else [])
def binary(request: pytest.FixtureRequest) -> Path:
    """The native light with each libgpiod there is."""
    return BINARIES[str(request.param)]


@pytest.fixture
def start(binary: Path, tmp_path: Path) -> Iterator[Start]:
    """start(option, …): lights in real time that end with the test."""
    with Light.starter(binary, tmp_path) as begin:
        yield begin


@pytest.fixture
def start_can(tmp_path: Path) -> Iterator[Start]:
    """The same where the libgpiod is beside the point: with the sanitizer, if it is there."""
    with Light.starter(BINARIES[max(BINARIES)], tmp_path) as begin:
        yield begin


@pytest.fixture
def lm75() -> Iterator[Lm75]:
    """A temperature sensor on the guest's I2C bus."""
    chip = Lm75()
    yield chip
    chip.remove()
