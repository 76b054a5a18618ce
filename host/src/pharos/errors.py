# SPDX-License-Identifier: Apache-2.0
"""Everything this package raises on purpose is a PharosError; its text is one clear line first."""

from __future__ import annotations

from .text import printable


class PharosError(Exception):
    """Root of the package's errors."""


class _OneLineError(PharosError):
    """Its text names what somebody else wrote, and stays one line all the same."""

    def __init__(self, text: str) -> None:
        super().__init__(printable(text))


class UrlError(_OneLineError):
    """A link's URL is malformed or names something that does not exist."""


class LinkError(_OneLineError):
    """A link failed, or did not carry the bytes that were due."""


class SilentError(PharosError):
    """The device did not say what was waited for, within the time given."""


class DialectError(PharosError):
    """The generated MAVLink dialect cannot be found or lacks a message."""


class SimulatorError(PharosError):
    """The native light could not be started, or ended unasked. Carries how to replay it."""


class RefusedError(SimulatorError):
    """The control socket refused a request; `reason` is its one line."""

    def __init__(self, reason: str, where: str = "") -> None:
        super().__init__(f"{reason}{where}")
        self.reason = reason


class CommandError(PharosError):
    """The light answered a command, but did not accept it. `result`: MAV_RESULT."""

    def __init__(self, reason: str, result: int) -> None:
        super().__init__(reason)
        self.result = result


class UsageError(PharosError):
    """What a person typed is not understood; nothing was sent."""
