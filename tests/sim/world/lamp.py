# SPDX-License-Identifier: Apache-2.0
"""What a lamp may be told to do, and what commands make of it: MAVLink common 405 and 406."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

INTERNAL = 1


@dataclass(frozen=True)
class Lamp:
    """What was commanded, as ILLUMINATOR_STATUS says it."""

    enable: bool = False
    mode: int = INTERNAL
    brightness: float = 100.0
    period: float = 0.0
    duty: float = 100.0

    kept: bool = False  # over a reset, in parts per million and microseconds: so rounded

    @property
    def glows(self) -> bool:
        return self.brightness > 0.0 and self.mode == INTERNAL

    def shows_as(self, said: Lamp) -> bool:
        """Whether a status that says this fits: exactly, or rounded if it was kept."""
        if (said.enable, said.mode) != (self.enable, self.mode):
            return False
        pairs = (
            (self.brightness, said.brightness, 1.5e-4),
            (self.period, said.period, 1.5e-6),
            (self.duty, said.duty, 1.5e-4),
        )
        return all(a == b or (self.kept and abs(a - b) < error) for a, b, error in pairs)


# docs/parameters.md: the beacon by default.
BEACON = Lamp(enable=True, brightness=100.0, period=1.0, duty=10.0)

Effect = Callable[[Lamp], Lamp]


def turned(on: bool) -> Effect:
    return lambda lamp: replace(lamp, enable=on)


def configured(brightness: float, period: float, duty: float, mode: int) -> Effect:
    return lambda lamp: replace(
        lamp, brightness=brightness, period=period, duty=duty, mode=mode, kept=False
    )


def dimmed(value: int) -> Effect:
    """IMC's SetLedBrightness: 0 is off and keeps the brightness, else that share of 255."""
    if value == 0:
        return turned(False)
    return lambda lamp: replace(lamp, enable=True, brightness=value / 2.55, kept=True)


def nothing(lamp: Lamp) -> Lamp:
    return lamp


def is_in_range(brightness: float, period: float, duty: float, mode: int) -> bool:
    """common.xml, MAV_CMD_DO_ILLUMINATOR_CONFIGURE; 0.01 to 10 s are this light's."""
    return (
        0.0 <= brightness <= 100.0
        and (period == 0.0 or 0.0099999 <= period <= 10.0)
        and 0.0 <= duty <= 100.0
        and mode in (1, 2)
    )
