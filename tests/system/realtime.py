# SPDX-License-Identifier: Apache-2.0
"""A light in real time, for programs that bring their own clock."""

from __future__ import annotations

import contextlib
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from harness import BINARY
from pharos.control import ControlClient

LIMIT_S = 60.0


@contextlib.contextmanager
def light_at(folder: Path, *options: str, wire: str = "udpin:127.0.0.1:0") -> Iterator[str]:
    """HOST:PORT of a light that runs in real time and listens there, over UDP or else."""
    control = folder / "control"
    process = subprocess.Popen(
        [str(BINARY), "--control", str(control), "--uart0", wire,
         "--console", "none", *options],
        stdin=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        yield str(_wires(process, control)["uart0"]["address"]).partition(":")[2]
    finally:
        process.kill()
        process.wait()


def _wires(process: subprocess.Popen[bytes], control: Path) -> dict[str, Any]:
    end = time.monotonic() + LIMIT_S
    while time.monotonic() < end:
        try:
            client = ControlClient(str(control))
        except OSError:
            with contextlib.suppress(subprocess.TimeoutExpired):
                raise AssertionError(f"the light ended with {process.wait(0.01)}") from None
            continue
        wires: dict[str, Any] = client.request("wires")["wires"]
        client.close()
        return wires
    raise AssertionError("the light opened no control socket")
