# SPDX-License-Identifier: Apache-2.0
"""MAVLink FTP (mavlink.io/en/services/ftp.html): the payload, and a client that reads files."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .errors import PharosError
from .light import Light

TERMINATE, RESET, LIST, OPEN, READ, CRC32, BURST = 1, 2, 3, 4, 5, 14, 15
ACK, NAK = 128, 129
INVALID_SESSION, EOF, UNKNOWN_COMMAND, NOT_FOUND = 4, 6, 7, 10
HEADER = struct.Struct("<HBBBBBxI")
PAYLOAD_BYTES = 251
DATA_MAX = 239
FILE_MAX = 16 << 20
TRIES = 6
TRY_US = 500_000
ERRORS = {
    1: "failed",
    2: "failed",
    3: "wrong size of data",
    4: "no such session",
    5: "too many files are open",
    6: "end of file",
    7: "the light does not have that operation",
    8: "it exists already",
    9: "write protected",
    10: "no such file",
}


class FileError(PharosError):
    """The component refused a file; `error`: MAV_FTP_ERR."""

    def __init__(self, path: str, error: int) -> None:
        super().__init__(f"{path}: {ERRORS.get(error, f'error {error}')}")
        self.error = error


@dataclass(frozen=True)
class Reply:
    """A FILE_TRANSFER_PROTOCOL payload that answers."""

    sequence: int
    session: int
    opcode: int
    request: int
    offset: int
    is_last: bool
    data: bytes

    @property
    def error(self) -> int:
        """MAV_FTP_ERR; 0: acknowledged."""
        return 0 if self.opcode == ACK else self.data[0] if self.data else 1

    @property
    def number(self) -> int:
        return int.from_bytes(self.data[:4], "little")


def payload(
    sequence: int, session: int, opcode: int, offset: int, data: bytes, size: int = -1
) -> bytes:
    """size: of what is asked for; −1: of data."""
    head = HEADER.pack(sequence, session, opcode, len(data) if size < 0 else size, 0, 0, offset)
    return (head + data).ljust(PAYLOAD_BYTES, b"\0")


def reply_of(message: Any) -> Reply:
    content = bytes(message.payload).ljust(PAYLOAD_BYTES, b"\0")
    sequence, session, opcode, size, request, last, offset = HEADER.unpack_from(content)
    data = content[HEADER.size : HEADER.size + min(size, DATA_MAX)]
    return Reply(sequence, session, opcode, request, offset, bool(last), data)


def crc32(data: bytes) -> int:
    """As mavlink.io/en/guide/crc.html has it: from 0, and not inverted at the end."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


class FileClient:
    """Files of the component that `light` addresses. A request that nobody answers is sent again
    with its number, so that nothing is done twice."""

    def __init__(self, light: Light) -> None:
        self._light = light
        self._sequence = 0

    def ask(
        self, opcode: int, data: bytes = b"", session: int = 0, offset: int = 0, size: int = -1
    ) -> Reply:
        connection = self._light.connection
        self._sequence = (self._sequence + 2) % 65536
        content = payload(self._sequence, session, opcode, offset, data, size)
        target = connection.target
        for _ in range(TRIES):
            connection.send(
                connection.dialect.MAVLink_file_transfer_protocol_message(
                    0, target.system, target.component, content
                )
            )
            end = connection.pacer.now_us() + TRY_US
            while (left := end - connection.pacer.now_us()) > 0:
                for message in self._light.poll_target(left):
                    if message.get_type() != "FILE_TRANSFER_PROTOCOL":
                        continue
                    reply = reply_of(message)
                    if reply.sequence == (self._sequence + 1) % 65536 and reply.request == opcode:
                        return reply
        raise connection.silence("the light has no files, or does not answer")

    def list_files(self, folder: str = "/") -> dict[str, int]:
        """Names and sizes; a folder's name ends with a slash, and its size is 0."""
        found: dict[str, int] = {}
        offset = 0
        while True:
            reply = self.ask(LIST, folder.encode(), offset=offset)
            if reply.error == EOF:
                return found
            if reply.error:
                raise FileError(folder, reply.error)
            entries = [entry for entry in reply.data.split(b"\0") if entry]
            if not entries:
                return found
            offset += len(entries)
            for entry in entries:
                name, _, size = entry[1:].decode("utf-8", "backslashreplace").partition("\t")
                if entry[:1] == b"F":
                    found[name] = int(size) if size.isdecimal() else 0
                elif entry[:1] == b"D":
                    found[f"{name}/"] = 0

    def read(self, path: str, on_part: Callable[[int, int], None] = lambda _at, _of: None) -> bytes:
        """The whole file. on_part: how much is there, and of how much."""
        opened = self.ask(OPEN, path.encode())
        if opened.error:
            raise FileError(path, opened.error)
        size, content = opened.number, bytearray()
        if size > FILE_MAX:
            raise PharosError(f"{path}: {size} bytes is too much")
        try:
            while len(content) < size:
                part = self.ask(READ, session=opened.session, offset=len(content), size=DATA_MAX)
                if part.error:
                    raise FileError(path, part.error)
                if not part.data:
                    raise PharosError(f"{path}: ends at {len(content)} of {size} bytes")
                content += part.data
                on_part(len(content), size)
        finally:
            self.ask(TERMINATE, session=opened.session)
        return bytes(content)
