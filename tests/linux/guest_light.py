# SPDX-License-Identifier: Apache-2.0
"""What the tests in the guest build on: simulated GPIO chips, CAN interfaces, a light in real time.

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
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pharos.control import ControlClient

PATIENCE_S = 30.0
CONFIGFS = Path("/sys/kernel/config/gpio-sim")
PLATFORM = Path("/sys/devices/platform")


def until(what: str, condition: Callable[[], Any]) -> Any:
    """The first true value of condition(), asked again and again."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        os.sched_yield()
    raise AssertionError(f"{what}: not within {PATIENCE_S:.0f} s")


def pass_time(seconds: float) -> None:
    """For what shows only when time has passed, such as a pulse that is over."""
    end = time.monotonic() + seconds
    until(f"{seconds} s", lambda: time.monotonic() > end)


class GpioSim:
    """A chip of the kernel's gpio-sim: what is outside of it is moved and seen here."""

    def __init__(self, name: str, lines: Sequence[str]) -> None:
        self._folder = CONFIGFS / name
        self._bank = self._folder / "gpio-bank0"
        self._lines = list(lines)
        self._bank.mkdir(parents=True)
        self.label = name
        (self._bank / "label").write_text(name)
        (self._bank / "num_lines").write_text(str(len(lines)))
        for number, line in enumerate(lines):
            (self._bank / f"line{number}").mkdir()
            (self._bank / f"line{number}" / "name").write_text(line)
        self.plug()

    def plug(self) -> None:
        (self._folder / "live").write_text("1")
        chip = (self._bank / "chip_name").read_text().strip()
        self.device = f"/dev/{chip}"
        self._sysfs = PLATFORM / (self._folder / "dev_name").read_text().strip() / chip
        until(self.device, lambda: Path(self.device).exists())

    def unplug(self) -> None:
        (self._folder / "live").write_text("0")

    def remove(self) -> None:
        self.unplug()
        for number in range(len(self._lines)):
            (self._bank / f"line{number}").rmdir()
        self._bank.rmdir()
        self._folder.rmdir()

    def _attribute(self, line: str, name: str) -> Path:
        return self._sysfs / f"sim_gpio{self.number(line)}" / name

    def number(self, line: str) -> int:
        return self._lines.index(line)

    def value(self, line: str) -> int:
        return int(self._attribute(line, "value").read_text())

    def pull(self, line: str, level: int) -> None:
        """Moves an input, with an edge if that is a change."""
        self._attribute(line, "pull").write_text("pull-up" if level else "pull-down")


class KeepingChip:
    """A chip in front of one line of a GpioSim (gpio-aggregator). As those of most processors, it
    keeps its last level when the process that had the line is gone."""

    DRIVER = Path("/sys/bus/platform/drivers/gpio-aggregator")

    def __init__(self, behind: GpioSim, line: str) -> None:
        before = set(self.DRIVER.glob("gpio-aggregator.*"))
        (self.DRIVER / "new_device").write_text(f"{behind.label} {behind.number(line)}")
        (self._folder,) = set(self.DRIVER.glob("gpio-aggregator.*")) - before
        (chip,) = self._folder.glob("gpiochip*")
        self.device = f"/dev/{chip.name}"
        until(self.device, lambda: Path(self.device).exists())

    def remove(self) -> None:
        (self.DRIVER / "delete_device").write_text(self._folder.name)


class Light:
    """The native light in real time, with a shell and a control socket."""

    def __init__(self, binary: Path, folder: Path, *options: str) -> None:
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
            until("a first sample", lambda: self.do("outputs")["limit_ppm"] > 0)
        except BaseException:
            self.process.kill()
            self.process.wait(PATIENCE_S)
            raise

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

    def status(self) -> str:
        """The line on the lamp's driver in what `light status` says now."""
        seen = len(self.console())
        self.shell("light status")

        def line() -> str:
            found = re.search(r"^driver .*$(?=\n)", self.console()[seen:], re.MULTILINE)
            return found[0] if found else ""

        return str(until("the status", line))

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
