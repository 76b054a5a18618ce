# SPDX-License-Identifier: Apache-2.0
"""The light in real time, as the tests in the guest see it: by its shell and its control socket.

Nothing here asserts a time: until() waits for what must happen, and PATIENCE_S only ends a wait for
what never does.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from pharos.control import ControlClient

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 30.0
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
# The light over Debian's libgpiod (1 in Debian 12, 2 in 13), and guest.py's over libgpiod 2.
BINARIES = {"debian": BUILD / "pharos"}
if "PHAROS_LIGHT2" in os.environ:
    BINARIES["libgpiod2"] = Path(os.environ["PHAROS_LIGHT2"])


def until(what: str, condition: Callable[[], Any], patience_s: float = PATIENCE_S) -> Any:
    """The first true value of condition(), asked again and again."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        os.sched_yield()
    raise AssertionError(f"{what}: not within {patience_s:.0f} s")


def pass_time(seconds: float) -> None:
    """For what shows only when time has passed, such as a pulse that is over."""
    end = time.monotonic() + seconds
    until(f"{seconds} s", lambda: time.monotonic() > end)


Start = Callable[..., "Light"]


class Light:
    """The native light in real time, with a shell and a control socket."""

    def __init__(self, binary: Path, folder: Path, *options: str, sampled: bool = True) -> None:
        """sampled: its temperature will be known."""
        control = folder / "control"
        self.stderr = folder / "stderr"
        with self.stderr.open("wb") as stderr, (folder / "console").open("wb") as console:
            self.process = subprocess.Popen(
                [str(binary), "--time", "real", "--control", str(control), *options],
                stdin=subprocess.PIPE, stdout=console, stderr=stderr, cwd=folder,
            )  # fmt: skip
        self._console = folder / "console"
        try:
            self._control = until("the control socket", lambda: self._connect(control))
            if sampled:
                until("a first sample", lambda: self.do("outputs")["limit_ppm"] > 0)
        except BaseException:
            self.process.kill()
            self.process.wait(PATIENCE_S)
            raise

    @classmethod
    @contextlib.contextmanager
    def starter(cls, binary: Path, folder: Path) -> Iterator[Start]:
        """Starts lights, each in a folder of its own, and ends them."""
        with contextlib.ExitStack() as stack:
            count = 0

            def begin(*options: str) -> Light:
                nonlocal count
                count += 1
                (folder / str(count)).mkdir()
                light = cls(binary, folder / str(count), *options)
                stack.callback(light.close)
                return light

            yield begin

    def _connect(self, path: Path) -> ControlClient | None:
        assert self.process.poll() is None, self.errors()
        try:
            return ControlClient(str(path))
        except OSError:
            return None

    def errors(self) -> str:
        return self.stderr.read_text()

    def console(self) -> str:
        return self._console.read_text(errors="replace")

    def do(self, op: str, **fields: Any) -> dict[str, Any]:
        return dict(self._control.request(op, **fields))

    def line(self, name: str) -> int:
        return int(self.do("outputs")["lines"][name])

    def shell(self, *lines: str) -> None:
        """Types lines; the last one has been carried out when `until` sees what it does."""
        assert self.process.stdin is not None
        self.process.stdin.write("".join(f"{line}\n" for line in lines).encode())
        self.process.stdin.flush()

    def ask(self, command: str, pattern: str) -> str:
        """The line that matches in what the shell answers to a command."""
        seen = len(self.console())
        self.shell(command)

        def line() -> str:
            found = re.search(f"^{pattern}$(?=\n)", self.console()[seen:], re.MULTILINE)
            return found[0] if found else ""

        return str(until(command, line))

    def status(self) -> str:
        """The line on the lamp's driver in what `light status` says now."""
        return self.ask("light status", "driver .*")

    def signal(self, number: signal.Signals) -> int:
        """Its exit status then; -number: it was killed by that signal."""
        self.process.send_signal(number)
        return self.process.wait(PATIENCE_S)

    def guards(self) -> dict[int, str]:
        """Process id and state of each of its guards; "Z": ended, and nobody has noticed."""
        found = {}
        for stat in Path("/proc").glob("[0-9]*/stat"):
            with contextlib.suppress(OSError):  # it has ended meanwhile
                pid, name, state, parent, *_ = stat.read_text().split()
                if name == "(pharos-guard)" and int(parent) == self.process.pid:
                    found[int(pid)] = state
        return found

    def guard(self) -> int:
        """The process id of its guard; 0: it has none."""
        return next((pid for pid, state in self.guards().items() if state != "Z"), 0)

    def close(self) -> None:
        self._control.close()
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait(PATIENCE_S)
        if self.process.stdin is not None:
            self.process.stdin.close()
