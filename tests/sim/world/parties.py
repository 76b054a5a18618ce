# SPDX-License-Identifier: Apache-2.0
"""Who speaks MAVLink in a simulated world: each encodes for itself, all share the light's wire."""

from __future__ import annotations

from typing import Any

KEY = bytes(range(32))
# A timestamp counts 10 µs since 2015.
STAMP = 40_000_000_000_000
ON_OFF = 405
CONFIGURE = 406
REQUEST_MESSAGE = 512
STATUS = 440
MOUNT = 205  # MAV_CMD_DO_MOUNT_CONTROL
REBOOT = 246  # MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN
LIGHT = (1, 243)


class Party:
    """One sender. key: signs with it."""

    def __init__(
        self, dialect: Any, system: int, component: int, key: bytes | None = None, version: int = 2
    ) -> None:
        self.d = dialect
        self.address = (system, component)
        self.key = key
        self.version = version
        self.later_us = 0  # its clock is so far ahead of the world's
        self._codec = dialect.MAVLink(None, system, component)
        if key is not None:
            self._codec.signing.secret_key = key
            self._codec.signing.sign_outgoing = True
            self._codec.signing.link_id = 1

    def frame(self, message: Any, now_us: int) -> bytes:
        if self.key is not None:
            signing = self._codec.signing
            signing.timestamp = max(signing.timestamp, STAMP + (now_us + self.later_us) // 10)
        raw = bytes(message.pack(self._codec, force_mavlink1=self.version == 1))
        self._codec.seq = (self._codec.seq + 1) % 256
        return raw

    def command(self, number: int, *params: float, to: tuple[int, int] = LIGHT) -> Any:
        seven = (list(params) + [0.0] * 7)[:7]
        return self.d.MAVLink_command_long_message(*to, number, 0, *seven)

    def station(self) -> Any:
        """A ground station's HEARTBEAT."""
        return self.d.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)

    def autopilot(self) -> Any:
        """An ArduPilot's."""
        return self.d.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3)

    def setup_signing(self, key: bytes, timestamp: int) -> Any:
        return self.d.MAVLink_setup_signing_message(*LIGHT, list(key), timestamp)
