# SPDX-License-Identifier: Apache-2.0
"""What every bench of `pharos check` keeps: what was sent and seen, and whether it is silent."""

from __future__ import annotations

from ..link import Pacer

LOG_MAX = 60


class Transcript:
    """`log` tells what was sent and seen since begin(). silence_us: so long without a word from
    who is checked means that it is gone; heard_us: its last one."""

    def __init__(self, pacer: Pacer, silence_us: int) -> None:
        self.pacer = pacer
        self.log: list[str] = []
        self._silence_us = silence_us
        self._start_us = self.heard_us = pacer.now_us()

    def now(self) -> int:
        return self.pacer.now_us()

    def is_silent(self) -> bool:
        return self.now() - self.heard_us > self._silence_us

    def begin(self) -> None:
        self.log = []

    def note(self, text: str) -> None:
        if len(self.log) < LOG_MAX:
            self.log.append(f"{(self.now() - self._start_us) / 1e6:9.3f}  {text}")
        elif len(self.log) == LOG_MAX:
            self.log.append("           …")
