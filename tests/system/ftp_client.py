# SPDX-License-Identifier: Apache-2.0
"""MAVLink FTP from the client's side, one request at a time, for tests.

Written from mavlink.io/en/services/ftp.html: opcodes, offsets and errors are the page's numbers."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import Any

from pharos import MavlinkConnection, Target

NONE = 0
TERMINATE = 1
RESET = 2
LIST = 3
OPEN = 4
READ = 5
WRITES = {"create": 6, "write": 7, "remove": 8, "mkdir": 9, "rmdir": 10, "open for writing": 11,
          "truncate": 12, "rename": 13}  # fmt: skip
CRC32 = 14
BURST = 15
ACK = 128
NAK = 129

INVALID_DATA_SIZE = 3
INVALID_SESSION = 4
NO_SESSIONS = 5
EOF = 6
UNKNOWN_COMMAND = 7
FILE_PROTECTED = 9
FILE_NOT_FOUND = 10

HEADER = "<HBBBBBxI"
PAYLOAD_BYTES = 251
DATA_MAX = 239


def crc32(data: bytes) -> int:
    """From 0 and not inverted at the end, as mavlink.io/en/guide/crc.html has it."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


@dataclass(frozen=True)
class Reply:
    """A FILE_TRANSFER_PROTOCOL payload."""

    sequence: int
    session: int
    opcode: int
    size: int
    request: int
    burst_complete: int
    offset: int
    data: bytes

    @property
    def error(self) -> int:
        """MAV_FTP_ERR; 0: acknowledged."""
        if self.opcode == ACK:
            return 0
        assert self.opcode == NAK
        assert self.size == 1
        return self.data[0]

    @property
    def number(self) -> int:
        assert self.size == 4
        return int.from_bytes(self.data, "little")


def payload(sequence: int, session: int, opcode: int, size: int, offset: int, data: bytes) -> bytes:
    head = struct.pack(HEADER, sequence, session, opcode, size, 0, 0, offset)
    return (head + data).ljust(PAYLOAD_BYTES, b"\0")


class FtpClient:
    """Requests count the sequence number on, as the page asks of every new one."""

    def __init__(self, mav: MavlinkConnection, target: Target | None = None) -> None:
        self.mav = mav
        self.target = target or mav.target
        self.sequence = 0

    def send(
        self,
        opcode: int,
        data: bytes = b"",
        *,
        session: int = 0,
        size: int | None = None,
        offset: int = 0,
        sequence: int | None = None,
    ) -> None:
        """size: of data if not given; sequence: the next if not given."""
        if sequence is None:
            self.sequence = (self.sequence + 2) % 65536
            sequence = self.sequence
        content = payload(
            sequence, session, opcode, len(data) if size is None else size, offset, data
        )
        d: Any = self.mav.dialect
        self.mav.send(
            d.MAVLink_file_transfer_protocol_message(
                0, self.target.system, self.target.component, content
            )
        )

    def reply(self, timeout_us: int = 2_000_000) -> Reply:
        message = self.mav.recv("FILE_TRANSFER_PROTOCOL", timeout_us=timeout_us)
        source = self.mav.source
        assert (message.target_system, message.target_component) == (
            source.system,
            source.component,
        )
        content = bytes(message.payload)
        sequence, session, opcode, size, request, complete, at = struct.unpack_from(HEADER, content)
        assert size <= DATA_MAX
        data = content[12 : 12 + size]
        return Reply(sequence, session, opcode, size, request, complete, at, data)

    def silent(self, us: int = 1_000_000) -> bool:
        """Nothing of FTP comes for so long."""
        return self.mav.poll("FILE_TRANSFER_PROTOCOL", timeout_us=us) is None

    def ask(self, opcode: int, data: bytes = b"", **fields: Any) -> Reply:
        """A request and its answer, which has its sequence number plus one."""
        self.send(opcode, data, **fields)
        reply = self.reply()
        assert reply.request == opcode
        assert reply.sequence == (fields.get("sequence", self.sequence) + 1) % 65536
        return reply

    def open(self, path: str) -> tuple[int, int]:
        """Session and length of the file."""
        reply = self.ask(OPEN, path.encode())
        assert reply.error == 0
        return reply.session, reply.number

    def read(self, path: str, part: int = DATA_MAX) -> bytes:
        """The file, part by part until EOF."""
        session, length = self.open(path)
        content = b""
        while True:
            reply = self.ask(READ, session=session, size=part, offset=len(content))
            if reply.error == EOF:
                break
            assert reply.error == 0
            assert reply.offset == len(content)
            content += reply.data
        assert len(content) == length
        assert self.ask(TERMINATE, session=session).error == 0
        return content

    def burst(self, session: int, offset: int = 0, size: int = DATA_MAX) -> list[Reply]:
        """The parts of a burst, up to the one that completes it."""
        self.send(BURST, session=session, size=size, offset=offset)
        parts = [self.reply()]
        while not parts[-1].burst_complete:
            assert parts[-1].error == 0
            parts.append(self.reply())
        return parts

    def listing(self, path: str = "/") -> dict[str, int]:
        """Files and their sizes."""
        found: dict[str, int] = {}
        while True:
            reply = self.ask(LIST, path.encode(), offset=len(found))
            if reply.error == EOF:
                return found
            assert reply.error == 0
            assert reply.data.endswith(b"\0")
            for entry in reply.data[:-1].split(b"\0"):
                assert entry[:1] == b"F"
                name, size = entry[1:].decode().split("\t")
                found[name] = int(size)
