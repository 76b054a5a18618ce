# SPDX-License-Identifier: Apache-2.0
"""When a sensor that fails is heat (docs/startup.md): a short, or one that was on the way to the
shutdown, within 10 s by its trend. Noise may read as either."""

from __future__ import annotations

from collections import deque

TREND_S = 10.0
# Over which the trend is taken, and how much of it a noisy reading may make [degC in 10 s].
COURSE_US = 2_000_000
TREND_ERROR_C = 6.0


class SensorOracle:
    def __init__(self) -> None:
        self._course: deque[tuple[int, float]] = deque()
        self._foreseen: deque[tuple[int, float]] = deque()

    def sample(self, now_us: int, temp_c: float, sensor: str, failing: bool, hot_c: float) -> bool:
        """failing: it is, or may be, taken for failed. Whether that may be taken for heat."""
        before = list(self._foreseen)
        if self._course and abs(temp_c - self._course[-1][1]) > TREND_ERROR_C:
            self._course.clear()  # a jump that the world made: no trend
        self._course.append((now_us, temp_c))
        while now_us - self._course[0][0] > COURSE_US:
            self._course.popleft()
        began_us, began_c = self._course[0]
        passed_s = (now_us - began_us) / 1e6
        rise_c = (temp_c - began_c) / passed_s * TREND_S if passed_s >= 0.2 else 0.0
        self._foreseen.append((now_us, temp_c + max(rise_c, 0.0) + TREND_ERROR_C))
        while now_us - self._foreseen[0][0] > COURSE_US:
            self._foreseen.popleft()
        if sensor in ("short", "noisy"):
            return True
        return failing and any(foreseen >= hot_c for _, foreseen in before)
