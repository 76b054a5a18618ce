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
from typing import Any

from pymavlink.dialects.v20 import common

from harness import BUILD
from pharos import find_dialect, load_dialect
from realtime import LIMIT_S

HEARTBEAT = 0
PARAM_REQUEST_LIST = 21
COMMAND_LONG = 76
COMMAND_ACK = 77
FILE_TRANSFER_PROTOCOL = 110
PROTOCOL_VERSION = 300
# The first byte of a frame
VERSIONS = {0xFE: 1, 0xFD: 2}
# MAV_AUTOPILOT
ARDUPILOT, PX4 = 3, 12


def _read(process: subprocess.Popen[bytes], end: float) -> str:
    """Some output; "" when there is none until then, or no more."""
    assert process.stdout is not None
    left = max(0.0, end - time.monotonic())
    ready = select.select([process.stdout], [], [], left)[0]
    return os.read(process.stdout.fileno(), 65536).decode(errors="replace") if ready else ""


def read_until(process: subprocess.Popen[bytes], pattern: str) -> str:
    """Reads output until `pattern` is seen; fails, showing it all, after LIMIT_S."""
    end = time.monotonic() + LIMIT_S
    text = ""
    while not re.search(pattern, text):
        more = _read(process, end)
        assert more, f"no '{pattern}' in the output:\n{text}"
        text += more
    return text


class Relay:
    """UDP between a program and the light at HOST:PORT. Counts what the program asks, and speaks
    for an autopilot of the light's system, if it shall. That one accepts every command to it or to
    all, but takes its time: until it beats again."""

    def __init__(self, light: str, autopilot: int | None = None) -> None:
        host, _, port = light.partition(":")
        self._near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._near.bind(("127.0.0.1", 0))
        self._far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._far.connect((host, int(port)))
        self.address = f"127.0.0.1:{self._near.getsockname()[1]}"
        self.asked: dict[int, int] = {}  # requests of the program by message id
        self.told: set[tuple[int, int]] = set()  # by the light: version and id of messages
        self._autopilot = autopilot
        self._told_more = threading.Condition()
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        self._is_over.set()
        self._thread.join()
        self._near.close()
        self._far.close()

    def until(self, version: int, message: int) -> None:
        """The light says such a message in that version of MAVLink, or has."""
        with self._told_more:
            assert self._told_more.wait_for(lambda: (version, message) in self.told, LIMIT_S)

    def _take(self, messages: list[Any]) -> None:
        with self._told_more:
            for message in messages:
                version = VERSIONS.get(message.get_msgbuf()[0], 0)
                self.told.add((version, message.get_msgId()))
            self._told_more.notify()

    def _run(self) -> None:
        vehicle = common.MAVLink(None, srcSystem=1, srcComponent=1)
        asking = common.MAVLink(None)
        telling = load_dialect(find_dialect(BUILD)).MAVLink(None)
        asking.robust_parsing = telling.robust_parsing = True
        program: tuple[str, int] | None = None
        commands: list[Any] = []  # that the autopilot owes an answer to
        beat_at = 0.0
        while not self._is_over.is_set():
            for ready in select.select([self._near, self._far], [], [], 0.1)[0]:
                if ready is self._far:
                    with contextlib.suppress(OSError):
                        data = self._far.recv(2048)
                        self._take(telling.parse_buffer(data) or [])
                        if program is not None:
                            self._near.sendto(data, program)
                    continue
                data, program = self._near.recvfrom(2048)
                self._far.send(data)
                for message in asking.parse_buffer(data) or []:
                    kind = message.get_msgId()
                    self.asked[kind] = self.asked.get(kind, 0) + 1
                    if kind == COMMAND_LONG and message.target_component in (0, 1):
                        commands.append(message)
            if self._autopilot and program is not None and time.monotonic() >= beat_at:
                beat_at = time.monotonic() + 1
                answers = [
                    vehicle.command_ack_encode(m.command, 0, 0, 0, m.get_srcSystem(), 0)
                    for m in commands
                ]
                commands.clear()
                beat = vehicle.heartbeat_encode(2, self._autopilot, 81, 0, 4)
                for message in (beat, *answers):
                    self._near.sendto(message.pack(vehicle), program)


@contextlib.contextmanager
def relay_to(light: str, autopilot: int | None = None) -> Iterator[Relay]:
    relay = Relay(light, autopilot)
    try:
        yield relay
    finally:
        relay.close()


class MavProxy:
    """MAVProxy in a folder of its own, with options as on its command line. `said`: its output."""

    def __init__(self, folder: Path, *options: str) -> None:
        program = Path(sys.executable).with_name("mavproxy.py")
        self.said = ""
        self._heard = 0  # of `said`
        self.process = subprocess.Popen(
            [sys.executable, str(program), *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env={**os.environ, "HOME": str(folder), "PYTHONUNBUFFERED": "1"},
        )

    def until(self, pattern: str) -> str:
        """The output since the last answer, up to this one."""
        end = time.monotonic() + LIMIT_S
        before = self._heard
        while (found := re.compile(pattern).search(self.said, before)) is None:
            more = _read(self.process, end)
            assert more, f"no '{pattern}' in the output:\n{self.said[before:]}"
            self.said += more
        self._heard = found.end()
        return self.said[before : self._heard]

    def type(self, line: str, answer: str) -> str:
        """Types a line; returns the output from then up to the answer."""
        assert self.process.stdin is not None
        self._heard = len(self.said)
        self.process.stdin.write(line.encode() + b"\n")
        self.process.stdin.flush()
        return self.until(answer)

    def pass_seconds(self, count: int) -> str:
        """What it says while it beats so often itself, once a second."""
        return self.type("watch HEARTBEAT", rf"(?s)(> HEARTBEAT.*?){{{count}}}")

    def close(self) -> None:
        self.process.kill()
        self.process.wait()


@contextlib.contextmanager
def mavproxy(
    address: str, folder: Path, *options: str, component: int | None = 243, link: str = "udpout"
) -> Iterator[MavProxy]:
    """Its target is that component of system 1, or what it chooses itself."""
    target = ["--target-system=1", f"--target-component={component}"] if component else []
    where = (f"--master={link}:{address}", f"--state-basedir={folder}")
    program = MavProxy(folder, *where, *target, *options)
    try:
        program.until(r"link 1 OK|Detected vehicle|online system 1|heartbeat")
        yield program
    finally:
        program.close()
