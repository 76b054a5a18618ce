# SPDX-License-Identifier: Apache-2.0
"""Tests of a Zephyr image from the inside, in QEMU: PHAROS_QEMU_IMAGE names its zephyr.elf."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "host" / "src"), str(ROOT / "tests" / "system")]

import harness  # noqa: E402
from qemu import QemuSimulator  # noqa: E402


def configured(option: str) -> bool:
    """Whether the image was built with that, as `CONFIG_X=y`."""
    if not harness.QEMU_IMAGE:
        return False
    lines = Path(harness.QEMU_IMAGE).with_name(".config").read_text().splitlines()
    return f"{option}=y" in lines


@pytest.fixture(autouse=True)
def _only_on(request: pytest.FixtureRequest) -> None:
    for marker in request.node.iter_markers("only_on"):
        option = marker.args[0].removeprefix("!")
        if harness.QEMU_IMAGE and configured(option) == marker.args[0].startswith("!"):
            pytest.skip(f"needs another image: {marker.args[0]}")


@pytest.fixture
def sim() -> Iterator[QemuSimulator]:
    if not harness.QEMU_IMAGE:
        pytest.skip("PHAROS_QEMU_IMAGE names no image")
    with harness.simulator() as running:
        assert isinstance(running, QemuSimulator)
        yield running
