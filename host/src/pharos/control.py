# SPDX-License-Identifier: Apache-2.0
"""The native light's control socket: a JSON object per line each way (boards/native/CONTROL.md)."""

from __future__ import annotations

import json
import socket
from typing import Any

from .errors import RefusedError, SimulatorError

# A request that advances a simulated day takes seconds; one that takes longer than this hangs [s].
REPLY_TIMEOUT_S = 120.0


class ControlClient:
    """Requests one at a time, in order. `journal` keeps them, for replay."""

    def __init__(self, path: str) -> None:
        self.journal: list[str] = []
        self._next_id = 1
        self._buffer = b""
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(REPLY_TIMEOUT_S)
        try:
            self._socket.connect(path)
        except OSError:
            self._socket.close()
            raise

    def request(self, op: str, **fields: Any) -> dict[str, Any]:
        """The reply's fields. RefusedError if it says so; SimulatorError if none comes."""
        return self.requests((op, fields))[0]

    def requests(self, *requests: tuple[str, dict[str, Any]]) -> list[dict[str, Any]]:
        """Several ones that are sent ahead: one exchange with the light, whose replies are as
        request()'s. All of them are carried out, whichever is refused."""
        first = self._next_id
        self._next_id += len(requests)
        lines = [
            json.dumps({"op": op, "id": first + index, **fields}, separators=(",", ":"))
            for index, (op, fields) in enumerate(requests)
        ]
        self.journal += lines
        try:
            self._socket.sendall(("\n".join(lines) + "\n").encode())
            replies = [json.loads(self._line()) for _ in lines]
        except TimeoutError as error:
            raise SimulatorError(f"no reply to {lines} within {REPLY_TIMEOUT_S:g} s") from error
        except (OSError, ValueError) as error:
            raise SimulatorError(f"the light broke off at {lines}: {error}") from error
        for index, (line, reply) in enumerate(zip(lines, replies, strict=True)):
            if reply.get("id", first + index) != first + index:
                raise SimulatorError(f"reply to another request than {line}: {reply}")
            if not reply.get("ok"):
                raise RefusedError(str(reply.get("error", "refused without a reason")))
        return [dict(reply) for reply in replies]

    def _line(self) -> bytes:
        while b"\n" not in self._buffer:
            data = self._socket.recv(1 << 16)
            if not data:
                raise ConnectionError("connection closed")
            self._buffer += data
        line, _, self._buffer = self._buffer.partition(b"\n")
        return line

    def close(self) -> None:
        self._socket.close()
