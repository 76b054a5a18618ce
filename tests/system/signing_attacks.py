# SPDX-License-Identifier: Apache-2.0
"""What a frame gets that somebody without the key, or with an old recording, sends to a light that
has a key: the one table behind the system test, the vectors of the C test, and docs/signing.md.

Frames are signed by pymavlink's own signer, which shares no code with the light.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

SECOND = 100_000  # a timestamp counts 10 µs
DAY = 86_400 * SECOND
KEY = bytes(range(32))
OTHER_KEY = bytes(range(1, 33))
GROUND = (255, 190)
LINK_ID = 1
OTHER_LINK_ID = 2

# Offsets from the end of a signed frame: link id, 6 bytes of timestamp, 6 of hash.
AT_LINK_ID = -13
AT_TIMESTAMP = -12
AT_HASH = -6


class Forge:
    """Makes frames of a ground station. `recorded` is the last one that the light has carried out,
    signed at `last`, which has therefore become the light's own time."""

    def __init__(self, dialect: Any, last: int) -> None:
        self.dialect = dialect
        self.last = last
        self.recorded = self.command(last)

    def sign(
        self, message: Any, timestamp: int | None, key: bytes = KEY, link_id: int = LINK_ID
    ) -> bytes:
        """The frame of a message; timestamp None: unsigned."""
        codec = self.dialect.MAVLink(None, *GROUND)
        if timestamp is not None:
            codec.signing.secret_key = key
            codec.signing.link_id = link_id
            codec.signing.timestamp = timestamp
            codec.signing.sign_outgoing = True
        return bytes(message.pack(codec))

    def command(self, timestamp: int | None, key: bytes = KEY, link_id: int = LINK_ID) -> bytes:
        """ILLUMINATOR_ON_OFF: on."""
        message = self.dialect.MAVLink_command_long_message(1, 243, 405, 0, 1, 0, 0, 0, 0, 0, 0)
        return self.sign(message, timestamp, key, link_id)

    def version_1(self) -> bytes:
        message = self.dialect.MAVLink_command_long_message(1, 243, 405, 0, 1, 0, 0, 0, 0, 0, 0)
        return bytes(message.pack(self.dialect.MAVLink(None, *GROUND), force_mavlink1=True))

    def heartbeat(self, timestamp: int | None = None, key: bytes = KEY) -> bytes:
        message = self.dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
        return self.sign(message, timestamp, key)

    def radio_status(self) -> bytes:
        return self.sign(
            self.dialect.MAVLink_radio_status_message(200, 190, 90, 40, 50, 0, 0), None
        )

    def with_checksum(self, frame: bytes, crc_extra: int = 152) -> bytes:
        """The frame with a checksum that fits what was changed. 152: COMMAND_LONG's CRC_EXTRA."""
        from pymavlink.generator.mavcrc import x25crc

        body = 10 + frame[1]
        crc = x25crc(frame[1:body])
        crc.accumulate(bytes([crc_extra]))
        return frame[:body] + int(crc.crc).to_bytes(2, "little") + frame[body + 2 :]

    def recorded_with(self, at: int, value: int) -> bytes:
        """The recorded frame with another byte there, and a checksum that fits."""
        frame = bytearray(self.recorded)
        frame[at] = value
        return self.with_checksum(bytes(frame))

    def restamped(self, timestamp: int) -> bytes:
        """The recorded frame with another timestamp, but the signature that it had."""
        stamp = timestamp.to_bytes(6, "little")
        return self.recorded[:AT_TIMESTAMP] + stamp + self.recorded[AT_HASH:]

    def stripped(self) -> bytes:
        """The recorded frame as an unsigned one: flag and signature gone."""
        frame = bytearray(self.recorded[:AT_LINK_ID])
        frame[2] = 0
        return self.with_checksum(bytes(frame))


@dataclass(frozen=True)
class Attack:
    """A row. `counter`: of `signing status`; "": no whole frame, so none counts it. `acted`: the
    command is carried out; a message without an answer is heard."""

    name: str
    make: Callable[[Forge], bytes]
    counter: str
    acted: bool = False


ATTACKS = (
    Attack("signed, a moment later", lambda f: f.command(f.last + 1), "accepted", True),
    Attack("signed, from the day after tomorrow", lambda f: f.command(f.last + 2 * DAY),
           "accepted", True),
    Attack("signed with another link id, so of another stream, 30 s behind",
           lambda f: f.command(f.last - 30 * SECOND, link_id=OTHER_LINK_ID), "accepted", True),
    Attack("unsigned", lambda f: f.command(None), "unsigned"),
    Attack("unsigned, in MAVLink 1", lambda f: f.version_1(), "unsigned"),
    Attack("a recording, its signature taken off", lambda f: f.stripped(), "unsigned"),
    Attack("an unsigned HEARTBEAT", lambda f: f.heartbeat(), "unsigned"),
    Attack("an unsigned RADIO_STATUS", lambda f: f.radio_status(), "unsigned"),
    Attack("a recording, sent again", lambda f: f.recorded, "replayed"),
    Attack("signed 10 µs before the last one", lambda f: f.command(f.last - 1), "replayed"),
    Attack("signed 61 s behind, of another stream",
           lambda f: f.command(f.last - 61 * SECOND, link_id=OTHER_LINK_ID), "old"),
    Attack("a recording, its timestamp raised", lambda f: f.restamped(f.last + SECOND),
           "bad signature"),
    Attack("a recording, its link id changed", lambda f: (
           f.recorded[:AT_LINK_ID] + bytes([OTHER_LINK_ID]) + f.recorded[AT_TIMESTAMP:]),
           "bad signature"),
    Attack("a recording, its sequence number raised",
           lambda f: f.recorded_with(4, f.recorded[4] + 1), "bad signature"),
    Attack("a recording, said to be from system 254", lambda f: f.recorded_with(5, 254),
           "bad signature"),
    Attack("a recording, said to be from component 191", lambda f: f.recorded_with(6, 191),
           "bad signature"),
    Attack("a recording, one bit of its payload flipped",
           lambda f: f.recorded_with(12, f.recorded[12] ^ 0x01), "bad signature"),
    Attack("signed with another key", lambda f: f.command(f.last + SECOND, key=OTHER_KEY),
           "bad signature"),
    Attack("signed with the key of zeros", lambda f: f.command(f.last + SECOND, key=bytes(32)),
           "bad signature"),
    Attack("a HEARTBEAT signed with another key",
           lambda f: f.heartbeat(f.last + SECOND, key=OTHER_KEY), "bad signature"),
    Attack("a signature of zeros", lambda f: f.command(f.last + SECOND)[:AT_LINK_ID] + bytes(13),
           "bad signature"),
    Attack("a recording, its last byte missing", lambda f: f.recorded[:-1], ""),
    Attack("a recording, its signature missing", lambda f: f.recorded[:AT_LINK_ID], ""),
    Attack("a recording, one bit flipped and the checksum as it was",
           lambda f: f.recorded[:12] + bytes([f.recorded[12] ^ 0x01]) + f.recorded[13:], ""),
)  # fmt: skip
