# SPDX-License-Identifier: Apache-2.0
"""Chips on the guest's I2C bus. i2c-stub keeps their registers; the kernel's own drivers drive
them, and /dev/i2c-0 looks past these."""

from __future__ import annotations

import ctypes
import fcntl
import os
from pathlib import Path

from guest_light import until

BUS = Path("/sys/bus/i2c/devices/i2c-0")
DRIVERS = Path("/sys/bus/i2c/drivers")

# linux/i2c-dev.h, linux/i2c.h
I2C_SLAVE_FORCE, I2C_SMBUS = 0x0706, 0x0720
WRITE, READ = 0, 1
BYTE_DATA, WORD_DATA = 2, 3


class _Call(ctypes.Structure):
    _fields_ = (
        ("direction", ctypes.c_uint8),
        ("command", ctypes.c_uint8),
        ("size", ctypes.c_uint32),
        ("data", ctypes.c_void_p),
    )


class Chip:
    """A chip of that kind at an address; the kernel's driver is bound to it."""

    def __init__(self, kind: str, address: int, driver: str) -> None:
        self.address = address
        self.device = f"0-{address:04x}"
        self._driver = DRIVERS / driver
        (BUS / "new_device").write_text(f"{kind} {address:#x}")
        self._bus = os.open("/dev/i2c-0", os.O_RDWR)
        fcntl.ioctl(self._bus, I2C_SLAVE_FORCE, address)

    def unplug(self) -> None:
        (self._driver / "unbind").write_text(self.device)

    def plug(self) -> None:
        (self._driver / "bind").write_text(self.device)

    def remove(self) -> None:
        os.close(self._bus)
        (BUS / "delete_device").write_text(f"{self.address:#x}")

    def transfer(self, direction: int, register: int, size: int, value: int = 0) -> int:
        block = (ctypes.c_uint8 * 34)(value & 0xFF, value >> 8)
        call = _Call(direction, register, size, ctypes.addressof(block))
        fcntl.ioctl(self._bus, I2C_SMBUS, call)
        return block[0] | block[1] << 8 if size == WORD_DATA else block[0]


class Lm75(Chip):
    """A temperature sensor; hwmon shows it."""

    TEMP = 0

    def __init__(self, address: int = 0x48, celsius: float = 25.0) -> None:
        super().__init__("lm75", address, "lm75")
        until("its hwmon", lambda: list((BUS / self.device).glob("hwmon/hwmon*")))
        self.celsius(celsius)

    def celsius(self, value: float) -> None:
        """Half degrees, from bit 7 on; SMBus sends the low byte first, the chip's is the high."""
        code = (round(value * 2) << 7) & 0xFFFF
        self.transfer(WRITE, self.TEMP, WORD_DATA, code >> 8 | (code & 0xFF) << 8)


class Pca9685(Chip):
    """Sixteen PWM outputs; /sys/class/pwm shows them."""

    ON_L, PRESCALE, FULL = 6, 0xFE, 0x10

    def __init__(self, address: int = 0x40) -> None:
        super().__init__("pca9685", address, "pca9685-pwm")

    @property
    def folder(self) -> Path:
        """As sysfs calls it, by class."""
        (chip,) = (BUS / self.device / "pwm").glob("pwmchip*")
        return Path("/sys/class/pwm", chip.name)

    def exported(self) -> list[int]:
        return sorted(int(path.name[3:]) for path in self.folder.glob("pwm[0-9]*"))

    def export(self, channel: int) -> None:
        (self.folder / "export").write_text(str(channel))

    def read(self, channel: int, attribute: str) -> str:
        return (self.folder / f"pwm{channel}" / attribute).read_text().strip()

    def prescale(self) -> int:
        return self.transfer(READ, self.PRESCALE, BYTE_DATA)

    def duty(self, channel: int) -> float:
        """Of the registers: 12 bits from ON to OFF, and a bit each for always on and always off."""
        on_low, on_high, off_low, off_high = (
            self.transfer(READ, self.ON_L + 4 * channel + i, BYTE_DATA) for i in range(4)
        )
        if off_high & self.FULL:
            return 0.0
        if on_high & self.FULL:
            return 1.0
        counts = (off_low | off_high << 8) - (on_low | on_high << 8)
        return counts % 4096 / 4096
