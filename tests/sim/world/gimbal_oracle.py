# SPDX-License-Identifier: Apache-2.0
"""A model of the gimbal, from docs/gimbal.md and MAVLink's DO_MOUNT_CONTROL: after the time that
the servos take it is where a command that may have been obeyed pointed it, and was if one
surely was."""

from __future__ import annotations

from collections.abc import Callable

Aim = tuple[float, float]  # pan, tilt [deg]

NEUTRAL: Aim = (0.0, 0.0)
MOVED_US = 4_000_000
NEAR_DEG = 0.2


class GimbalOracle:
    def __init__(self, broken: Callable[[int, str], None]) -> None:
        self._broken = broken
        self._aims: set[Aim] = {NEUTRAL}
        self._waiting: list[tuple[int, Aim]] = []
        self._steady_us = 0

    def sent(self, now_us: int, aim: Aim) -> None:
        self._waiting.append((now_us, aim))
        self._steady_us = now_us

    def acknowledged(self, now_us: int, accepted: bool) -> None:
        """The last one's: those before it were obeyed, or not."""
        if not self._waiting:
            return
        *earlier, (_, aim) = self._waiting
        self._aims |= {each for _, each in earlier}
        if accepted:
            self._aims = {aim}
        self._waiting.clear()
        self._steady_us = now_us

    def restarted(self, now_us: int) -> None:
        self._aims = {NEUTRAL}
        self._waiting.clear()
        self._steady_us = now_us

    def sample(self, now_us: int, is_at: Aim, healthy: bool) -> None:
        if not healthy:
            self._steady_us = now_us
            return
        if now_us - self._steady_us < MOVED_US:
            return
        possible = self._aims | {aim for _, aim in self._waiting}
        if not any(max(abs(a - b) for a, b in zip(is_at, p, strict=True)) < NEAR_DEG
                   for p in possible):  # fmt: skip
            self._broken(now_us, f"the gimbal is at {is_at}, not at {sorted(possible)}")
            self._steady_us = now_us
