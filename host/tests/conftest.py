# SPDX-License-Identifier: Apache-2.0
"""The package is tested from the tree, installed or not."""

from __future__ import annotations

import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from real_light import BINARY, RealLight


@pytest.fixture(scope="session")
def binary() -> Path:
    if not BINARY.is_file():
        pytest.exit(f"{BINARY}: no such file; run `make build` first", returncode=2)
    return BINARY


@pytest.fixture
def real_light(binary: Path, tmp_path: Path) -> Iterator[Callable[..., RealLight]]:
    """real_light("--uart0", …): the light in real time, which ends with the test."""
    with ExitStack() as stack:

        def start(*options: str) -> RealLight:
            light = RealLight(tmp_path, *options)
            stack.callback(light.close)
            return light

        yield start


@pytest.fixture
def can_light(real_light: Callable[..., RealLight]) -> Iterator[tuple[RealLight, str]]:
    """A light on a CAN bus of its own, and that bus for the command line."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as reserved:
        reserved.bind(("127.0.0.1", 0))
        channel = f"127.255.255.255:{reserved.getsockname()[1]}"
        yield real_light("--can0", f"udp:{channel}"), f"pharos-udp/{channel}"
