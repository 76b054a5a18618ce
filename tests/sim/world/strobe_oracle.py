# SPDX-License-Identifier: Apache-2.0
"""A model of the strobe's edges, from MAVLink common 406 and app/core/strobe.h: a phase that begins
with a timing, or under it, has the length that it says, from the first one on; and two phases are a
period, so that nothing accumulates."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

PERIOD_ERROR_US = 1.0
# The duty cycle is kept in parts per million, and edges in microseconds.
PHASE_ERROR_US = 1.5
PHASE_ERROR_PART = 0.5e-6


class StrobeOracle:
    def __init__(self, broken: Callable[[int, str], None]) -> None:
        self._broken = broken
        self._edges: deque[tuple[int, bool]] = deque(maxlen=3)
        self._is_lit = False

    def edge(self, at_us: int, ppm: int) -> bool:
        """A change of the level: whether the lamp went on or off."""
        if (ppm > 0) == self._is_lit:
            return False
        self._is_lit = ppm > 0
        self._edges.append((at_us, self._is_lit))
        return True

    def check(self, since_us: int, period_us: float, on_us: float) -> None:
        """The timing is in force, and nothing else has darkened the lamp, since `since_us`."""
        recent = [edge for edge in self._edges if edge[0] >= since_us]
        if len(recent) >= 2:
            (begun_us, lit), (end_us, _) = recent[-2:]
            wanted_us = on_us if lit else period_us - on_us
            error_us = PHASE_ERROR_US + PHASE_ERROR_PART * period_us
            if abs(end_us - begun_us - wanted_us) > error_us:
                kind = "lit" if lit else "dark"
                self._broken(end_us, f"{kind} for {end_us - begun_us} us, not {wanted_us:.0f}")
        if len(recent) == 3 and abs(recent[2][0] - recent[0][0] - period_us) > PERIOD_ERROR_US:
            lasted_us = recent[2][0] - recent[0][0]
            self._broken(recent[2][0], f"a period of {lasted_us} us, not {period_us:.0f}")
