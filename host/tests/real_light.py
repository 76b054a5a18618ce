# SPDX-License-Identifier: Apache-2.0
"""The light as a process in real time, for programs that talk to it as a user does. Where a test
waits, it waits for something that comes, with an end to its patience."""

from __future__ import annotations

import os
import select
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from pharos.control import ControlClient

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
BINARY = BUILD / "pharos"
# The command, as an installation runs it.
PHAROS = (sys.executable, "-m", "pharos")
PATIENCE_S = 20.0
# The other end of each kind of wire.
CLIENT_OF = {"udpin": "udp", "tcpin": "tcp", "pty": "pty"}


def wait_for(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, f"never came: {what}"
        select.select([], [], [], 0.005)


def environment() -> dict[str, str]:
    """A home of its own for history and cache would cost a second per test: only the path."""
    source = str(ROOT / "host" / "src")
    return {**os.environ, "PYTHONPATH": source, "TERM": "xterm"}


def run(*args: str, stdin: str = "") -> subprocess.CompletedProcess[str]:
    """`pharos ARGS…` to its end."""
    return subprocess.run(
        [*PHAROS, *args],
        input=stdin,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
        env=environment(),
    )


class RealLight:
    """The light with one wire, and its control socket; on no bus, which others share, unless the
    options name one."""

    def __init__(self, folder: Path, *options: str) -> None:
        if "--can0" not in options:
            options = (*options, "--can0", "none")
        self._console = (folder / "console").open("wb")
        self.process = subprocess.Popen(
            [str(BINARY), "--control", str(folder / "control"), "--console", "none", *options],
            stdin=subprocess.DEVNULL,
            stdout=self._console,
            stderr=subprocess.STDOUT,
            cwd=folder,
        )
        self._path = str(folder / "control")
        self._control: ControlClient | None = None
        wait_for(self._try_connect, "the light's control socket")

    def _try_connect(self) -> bool:
        assert self.process.poll() is None, "the light ended at start"
        try:
            self._control = ControlClient(self._path)
        except OSError:
            return False
        return True

    @property
    def control(self) -> ControlClient:
        assert self._control is not None
        return self._control

    def url(self, name: str = "uart0") -> str:
        """How `pharos shell` reaches that wire."""
        address = str(self.control.request("wires")["wires"][name]["address"])
        kind, _, rest = address.partition(":")
        return f"{CLIENT_OF[kind]}:{rest}"

    def close(self) -> None:
        if self._control is not None:
            self._control.close()
        self.process.kill()
        self.process.wait()
        self._console.close()
