# SPDX-License-Identifier: Apache-2.0
"""MAVLink FTP (mavlink.io/en/services/ftp.html): the payload, and a client that reads files and
writes firmware."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .errors import PharosError
from .light import Light

TERMINATE, RESET, LIST, OPEN, READ, CREATE, WRITE = 1, 2, 3, 4, 5, 6, 7
OPEN_WRITE, CRC32, BURST = 11, 14, 15
ACK, NAK = 128, 129
INVALID_SESSION, NO_SESSIONS, EOF, UNKNOWN_COMMAND, NOT_FOUND = 4, 5, 6, 7, 10
HEADER = struct.Struct("<HBBBBBxI")
PAYLOAD_BYTES = 251
DATA_MAX = 239
FILE_MAX = 16 << 20
# How long an answer is waited for, how soon the question is repeated at first, and at the latest.
PATIENCE_US = 3_000_000
TRY_MIN_US = 100_000
TRY_MAX_US = 500_000
# An upload that the light has forgotten (it restarted) is begun again so often.
RESTARTS = 3
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
        self.path = path
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
    with its number, so that nothing is done twice, for patience_us; then it is a SilentError."""

    def __init__(self, light: Light, patience_us: int = PATIENCE_US) -> None:
        self._light = light
        self._patience_us = patience_us
        self._sequence = 0
        self._round_us = TRY_MAX_US // 4  # how long answers take, smoothed

    def ask(
        self, opcode: int, data: bytes = b"", session: int = 0, offset: int = 0, size: int = -1
    ) -> Reply:
        connection = self._light.connection
        now_us = connection.pacer.now_us
        self._sequence = (self._sequence + 2) % 65536
        content = payload(self._sequence, session, opcode, offset, data, size)
        target = connection.target
        message = connection.dialect.MAVLink_file_transfer_protocol_message(
            0, target.system, target.component, content
        )
        end = now_us() + self._patience_us
        wait_us = min(max(4 * self._round_us, TRY_MIN_US), TRY_MAX_US)
        while (begun := now_us()) < end:
            connection.send(message)
            reply = self._wait(opcode, min(begun + wait_us, end))
            if reply is not None:
                self._round_us += (now_us() - begun - self._round_us) // 8
                return reply
            wait_us = min(2 * wait_us, TRY_MAX_US)
        raise connection.silence("the light has no files, or does not answer")

    def _wait(self, opcode: int, until_us: int) -> Reply | None:
        while (left := until_us - self._light.connection.pacer.now_us()) > 0:
            for message in self._light.poll_target(left):
                if message.get_type() != "FILE_TRANSFER_PROTOCOL":
                    continue
                reply = reply_of(message)
                if reply.sequence == (self._sequence + 1) % 65536 and reply.request == opcode:
                    return reply
        return None

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

    # --- writing ------------------------------------------------------------------------------
    def write(
        self,
        path: str,
        content: bytes,
        on_part: Callable[[int, int], None] = lambda _at, _of: None,
        on_whole: Callable[[], None] = lambda: None,
    ) -> None:
        """Writes the whole file. What the light has of it from before, this run's or another's, is
        not sent again. on_whole: all is there, and the light looks at it."""
        for _ in range(RESTARTS):
            session, at = self._open_to_write(path, content)
            at = self._write_parts(path, content, session, at, on_part)
            if at < len(content):
                continue
            on_whole()
            error = self.ask(TERMINATE, session=session).error
            if error != INVALID_SESSION:
                break
        else:
            raise PharosError(f"{path}: the light forgets what it was sent")
        if error:
            raise FileError(path, error)

    def _open_to_write(self, path: str, content: bytes) -> tuple[int, int]:
        """The session, and how much of the content is there."""
        opened = self._open_when_free(OPEN_WRITE, path)
        at = opened.number
        if at:
            found = self.ask(CRC32, path.encode())
            if found.error or at > len(content) or found.number != crc32(content[:at]):
                return self._open_when_free(CREATE, path).session, 0
        return opened.session, at

    def _open_when_free(self, opcode: int, path: str) -> Reply:
        """Another's update, or what is left of one, may be in the way for a while."""
        now_us = self._light.connection.pacer.now_us
        end = now_us() + self._patience_us
        while True:
            reply = self.ask(opcode, path.encode())
            if reply.error == 0:
                return reply
            if reply.error != NO_SESSIONS or now_us() >= end:
                raise FileError(path, reply.error)
            self._light.poll(TRY_MAX_US)

    def _write_parts(
        self,
        path: str,
        content: bytes,
        session: int,
        at: int,
        on_part: Callable[[int, int], None],
    ) -> int:
        """How much is there in the end: less than all if the light has forgotten it."""
        while at < len(content):
            part = content[at : at + DATA_MAX]
            reply = self.ask(WRITE, part, session=session, offset=at)
            if reply.error == INVALID_SESSION:
                return at
            if reply.error:
                raise FileError(path, reply.error)
            at += len(part)
            on_part(at, len(content))
        return at
