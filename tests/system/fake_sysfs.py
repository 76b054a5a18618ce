# SPDX-License-Identifier: Apache-2.0
"""A folder that stands for /sys (--sysfs), of plain files. Real ones: tests/linux."""

from __future__ import annotations

from pathlib import Path


class FakeSysfs:
    """Devices are folders of their classes, with a link to what they belong to."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def add(self, entry: str, device: str = "", **attributes: object) -> Path:
        """entry: "class/hwmon/hwmon0"; device: "1-0048". Attributes as files of one line."""
        path = self.root / entry
        path.mkdir(parents=True)
        if device:
            behind = self.root / "devices" / device
            behind.mkdir(parents=True, exist_ok=True)
            (path / "device").symlink_to(behind)
        for name, value in attributes.items():
            self.set(path, name, value)
        return path

    @staticmethod
    def set(path: Path, name: str, value: object) -> None:
        (path / name).write_text(f"{value}\n")

    @staticmethod
    def get(path: Path, name: str) -> str:
        """The first line: a shorter one is written over a longer one."""
        return (path / name).read_text().split("\n")[0]

    def pwmchip(self, number: int, device: str = "", channels: int = 4) -> list[Path]:
        """Its channels, which are exported: a plain file cannot do that."""
        chip = self.add(f"class/pwm/pwmchip{number}", device, npwm=channels, export="", unexport="")
        files = {"duty_cycle": 0, "period": 0, "enable": 0, "polarity": "normal"}
        return [
            self.add(f"{chip.relative_to(self.root)}/pwm{channel}", "", **files)
            for channel in range(channels)
        ]

    def hwmon(self, number: int, name: str, device: str = "", **attributes: object) -> Path:
        return self.add(f"class/hwmon/hwmon{number}", device, name=name, **attributes)

    def zone(self, number: int, kind: str, **attributes: object) -> Path:
        return self.add(f"class/thermal/thermal_zone{number}", "", type=kind, **attributes)

    def iio(self, number: int, name: str, **attributes: object) -> Path:
        return self.add(f"bus/iio/devices/iio:device{number}", "", name=name, **attributes)
