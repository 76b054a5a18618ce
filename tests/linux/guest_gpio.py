# SPDX-License-Identifier: Apache-2.0
"""Simulated GPIO chips of the guest's kernel."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from guest_light import until

CONFIGFS = Path("/sys/kernel/config/gpio-sim")
PLATFORM = Path("/sys/devices/platform")


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
