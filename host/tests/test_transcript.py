# SPDX-License-Identifier: Apache-2.0
"""What a bench of `pharos check` keeps of what was sent and seen."""

from __future__ import annotations

from pharos.check.transcript import LOG_MAX, Transcript


class Clock:
    now = 2_000_000

    def now_us(self) -> int:
        return self.now

    def pump(self, us: int) -> None:
        self.now += us


def test_a_long_transcript_says_that_it_is_cut() -> None:
    clock = Clock()
    transcript = Transcript(clock, 1_000_000)
    clock.pump(1_500_000)
    for number in range(LOG_MAX + 10):
        transcript.note(str(number))
    assert transcript.log[0] == "    1.500  0"
    assert transcript.log[LOG_MAX - 1].endswith(str(LOG_MAX - 1))
    assert [line.strip() for line in transcript.log[LOG_MAX:]] == ["…"]
    assert transcript.is_silent()
    transcript.begin()
    assert transcript.log == []
