# SPDX-License-Identifier: Apache-2.0
"""What a DroneCAN hardpoint.Command may do. Vehicles repeat it many times a second: "a repetition
does not take the light back from whoever commanded it since" (app/proto/dronecan/lights.h). After a
reset, a fallback or a refusal the next one counts as new."""

from __future__ import annotations


class HardpointOracle:
    def __init__(self) -> None:
        self._value: int | None = None  # the last one's, if it surely arrived
        self._ours_us = 0  # when one last may have had an effect
        self._theirs_us: int | None = None  # when a command of another source last surely had one

    def taken(self, now_us: int) -> None:
        """Another source's command was ACCEPTED."""
        self._theirs_us = now_us

    def forget(self) -> None:
        """The light was reset or may have fallen back: nobody is in command for sure."""
        self._value = None
        self._theirs_us = None

    def sent(self, now_us: int, value: int, sure: bool) -> bool:
        """sure: it arrives, and nothing lets it be refused. Whether it may have an effect."""
        kept = (
            self._value == value and self._theirs_us is not None and self._theirs_us > self._ours_us
        )
        self._value = value if sure else None
        if not kept:
            self._ours_us = now_us
        return not kept
