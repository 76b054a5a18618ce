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


@pytest.fixture
def sim() -> Iterator[QemuSimulator]:
    if not harness.QEMU_IMAGE:
        pytest.skip("PHAROS_QEMU_IMAGE names no image")
    with harness.simulator() as running:
        assert isinstance(running, QemuSimulator)
        yield running
