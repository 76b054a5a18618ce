# SPDX-License-Identifier: Apache-2.0
"""The files of a model light (model_light.py), over MAVLink FTP."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable

FTP = struct.Struct("<HBBBBBxI")
PARAMETERS = {"BRIGHT_MAX": 100.0, "STROBE_MIN": 0.05, "TEMP_LIMIT": 85.0, "LED_COUNT": 4.0}


def crc32(data: bytes) -> int:
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def files(faults: frozenset[str]) -> dict[str, bytes]:
    described = [{"name": name, "type": "Float"} for name in PARAMETERS]
    parameters = json.dumps({"version": 1, "parameters": described}).encode()
    uri = "mftp:///nowhere.json" if "metadata names no file" in faults else "mftp:///params.json"
    general = {
        "version": 1,
        "metadataTypes": [{"type": 1, "uri": uri, "fileCrc": crc32(parameters)}],
    }
    text = b"{" if "metadata is no JSON" in faults else json.dumps(general).encode()
    return {"/general.json": text, "/params.json": parameters}


class ModelFiles:
    """has: whether the light has a fault."""

    def __init__(self, faults: frozenset[str], has: Callable[[str], bool]) -> None:
        self.has = has
        self.files = files(faults)
        self.sessions: dict[int, str] = {}
        self.last: tuple[int, bytes] | None = None

    def __getitem__(self, path: str) -> bytes:
        return self.files[path]

    def answer(self, content: bytes, now_us: int) -> bytes:
        """The payload of the reply to a request's."""
        sequence, session, opcode, size, _, _, offset = FTP.unpack_from(content)
        if self.last and self.last[0] == sequence and not self.has("forgets its answers"):
            return self.last[1]
        data = content[12 : 12 + size]
        error, answer, session = self.request(opcode, data, session, offset, size)
        number = (sequence + (0 if self.has("answers with the same number") else 1)) % 65536
        if self.has("forgets its answers"):
            number = (number + now_us // 1000) % 65536 if opcode == 3 else number
        kind, body = (129, bytes([error])) if error else (128, answer)
        reply = FTP.pack(number, session, kind, len(body), opcode, 1, offset) + body
        self.last = (sequence, reply)
        return reply

    def request(
        self, opcode: int, data: bytes, session: int, offset: int, size: int
    ) -> tuple[int, bytes, int]:
        """Error, data, session."""
        path = data.rstrip(b"\0").decode()
        if opcode == 1:
            if not self.has("keeps sessions open"):
                self.sessions.pop(session, None)
            return 0, b"", session
        if opcode == 2:
            self.sessions.clear()
            return 0, b"", session
        if opcode == 3:
            entries = [f"F{n[1:]}\t{len(c)}".encode() for n, c in self.files.items()][offset:]
            return (0, b"\0".join(entries) + b"\0", session) if entries else (6, b"", session)
        if opcode in (4, 14):
            if path not in self.files:
                return (1 if self.has("fails without a reason") else 10), b"", session
            if opcode == 14:
                return 0, crc32(self.files[path]).to_bytes(4, "little"), session
            self.sessions[1] = path
            return 0, len(self.files[path]).to_bytes(4, "little"), 1
        if opcode in (5, 15):
            if session not in self.sessions:
                return 4, b"", session
            part = self.files[self.sessions[session]][offset : offset + size]
            if not part and not self.has("has no end of file"):
                return 6, b"", session
            return 0, part, session
        return (2 if self.has("fails at unknown opcodes") else 7), b"", session
