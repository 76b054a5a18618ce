# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests that need a kernel with CAN and GPIO: guest.py runs them in its guest.

vcan0, vcan1     names of virtual CAN interfaces that are up, with room for CAN FD frames
gpio_sim         gpio_sim("name of line 0", …): a chip of gpio-sim
light, binary    the native light in real time; each test runs over every libgpiod there is
"""

from __future__ import annotations

import os
import subprocess
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
    from guest_light import GpioSim, Light

BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
BINARIES = {"libgpiod1": BUILD / "pharos"}
if "PHAROS_LIGHT2" in os.environ:
    BINARIES["libgpiod2"] = Path(os.environ["PHAROS_LIGHT2"])


def _ip(*words: str) -> None:
    subprocess.run(["ip", "link", *words], check=True)


def _vcan(name: str) -> Iterator[str]:
    _ip("add", "dev", name, "type", "vcan")
    _ip("set", name, "mtu", "72", "up")
    yield name
    _ip("del", name)


@pytest.fixture
def vcan0() -> Iterator[str]:
    yield from _vcan("vcan0")


@pytest.fixture
def vcan1() -> Iterator[str]:
    yield from _vcan("vcan1")


@pytest.fixture
def gpio_sim() -> Iterator[Callable[..., GpioSim]]:
    chips: list[GpioSim] = []

    def make(*lines: str) -> GpioSim:
        chips.append(GpioSim(f"chip{len(chips)}", lines))
        return chips[-1]

    yield make
    for chip in chips:
        chip.remove()


@pytest.fixture(params=sorted(BINARIES))
def binary(request: pytest.FixtureRequest) -> Path:
    return BINARIES[str(request.param)]


@pytest.fixture
def start(binary: Path, tmp_path: Path) -> Iterator[Callable[..., Light]]:
    """start(option, …): lights that end with the test."""
    with ExitStack() as stack:
        count = 0

        def begin(*options: str) -> Light:
            nonlocal count
            count += 1
            folder = tmp_path / str(count)
            folder.mkdir()
            light = Light(binary, folder, *options)
            stack.callback(light.close)
            return light

        yield begin
