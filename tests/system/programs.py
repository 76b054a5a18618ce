# SPDX-License-Identifier: Apache-2.0
"""Programs of others as a user runs them, and what stands between them and the light."""

from __future__ import annotations

import contextlib
import os
import re
import select
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from pymavlink.dialects.v20 import common

from realtime import LIMIT_S

PARAM_REQUEST_LIST = 21
# MAV_AUTOPILOT
ARDUPILOT, PX4 = 3, 12


def read_until(process: subprocess.Popen[bytes], pattern: str) -> str:
    """Reads output until `pattern` is seen; fails, showing it all, after LIMIT_S."""
    assert process.stdout is not None
    end = time.monotonic() + LIMIT_S
    text = ""
    while not re.search(pattern, text):
        left = end - time.monotonic()
        ready = select.select([process.stdout], [], [], max(0.0, left))[0]
        data = os.read(process.stdout.fileno(), 65536) if ready else b""
        assert data, f"no '{pattern}' in the output:\n{text}"
        text += data.decode(errors="replace")
    return text


class Relay:
    """UDP between a program and the light at HOST:PORT. Counts what the program asks, and speaks
    for an autopilot of the light's system, if it shall."""

    def __init__(self, light: str, autopilot: int | None = None) -> None:
        host, _, port = light.partition(":")
        self._near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._near.bind(("127.0.0.1", 0))
        self._far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._far.connect((host, int(port)))
        self.address = f"127.0.0.1:{self._near.getsockname()[1]}"
        self.asked: dict[int, int] = {}  # requests of the program by message id
        self._autopilot = autopilot
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        self._is_over.set()
        self._thread.join()
        self._near.close()
        self._far.close()

    def _run(self) -> None:
        vehicle = common.MAVLink(None, srcSystem=1, srcComponent=1)
        reader = common.MAVLink(None)
        reader.robust_parsing = True
        program: tuple[str, int] | None = None
        beat_at = 0.0
        while not self._is_over.is_set():
            for ready in select.select([self._near, self._far], [], [], 0.1)[0]:
                if ready is self._far:
                    with contextlib.suppress(OSError):
                        data = self._far.recv(2048)
                        if program is not None:
                            self._near.sendto(data, program)
                    continue
                data, program = self._near.recvfrom(2048)
                self._far.send(data)
                for message in reader.parse_buffer(data) or []:
                    kind = message.get_msgId()
                    self.asked[kind] = self.asked.get(kind, 0) + 1
            if self._autopilot and program is not None and time.monotonic() >= beat_at:
                beat_at = time.monotonic() + 1
                beat = vehicle.heartbeat_encode(2, self._autopilot, 81, 0, 4)
                self._near.sendto(beat.pack(vehicle), program)


@contextlib.contextmanager
def relay_to(light: str, autopilot: int | None = None) -> Iterator[Relay]:
    relay = Relay(light, autopilot)
    try:
        yield relay
    finally:
        relay.close()


class MavProxy:
    """MAVProxy in a folder of its own, with a light as its target."""

    def __init__(self, address: str, folder: Path, *options: str) -> None:
        program = Path(sys.executable).with_name("mavproxy.py")
        self.process = subprocess.Popen(
            [sys.executable, str(program), f"--master=udpout:{address}", "--target-system=1",
             "--target-component=243", f"--state-basedir={folder}", *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env={**os.environ, "HOME": str(folder), "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip

    def until(self, pattern: str) -> str:
        return read_until(self.process, pattern)

    def type(self, line: str, answer: str) -> str:
        """Types a line; returns the output up to the answer."""
        assert self.process.stdin is not None
        self.process.stdin.write(line.encode() + b"\n")
        self.process.stdin.flush()
        return self.until(answer)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()


@contextlib.contextmanager
def mavproxy(address: str, folder: Path, *options: str) -> Iterator[MavProxy]:
    program = MavProxy(address, folder, *options)
    try:
        program.until(r"link 1 OK|Detected vehicle|online system 1|heartbeat")
        yield program
    finally:
        program.close()
