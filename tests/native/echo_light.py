# SPDX-License-Identifier: Apache-2.0
"""echo_app as a process, its control socket, and the other ends of its wires."""

from __future__ import annotations

import json
import os
import select
import socket
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

# How long anything in real time may take before the test fails [s].
PATIENCE_S = 10.0


def wait_until(condition: Callable[[], bool], what: str) -> None:
    """For real time: polls until it holds."""
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, f"never came: {what}"
        select.select([], [], [], 0.005)


class Light:
    """echo_app as a process, and one client of its control socket."""

    def __init__(self, binary: Path, folder: Path, *options: str, virtual: bool = True) -> None:
        self.folder = folder
        self.path = folder / "control"
        self.command = [str(binary), "--control", str(self.path)]
        self.command += ["--time", "virtual" if virtual else "real", "--console", "none", *options]
        self.stderr = folder / "stderr"
        with self.stderr.open("ab") as stderr:
            self.process = subprocess.Popen(
                self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=stderr
            )
        self.control = self.connect()

    def connect(self) -> socket.socket:
        control = socket.socket(socket.AF_UNIX)
        control.settimeout(PATIENCE_S)

        def try_connect() -> bool:
            assert self.process.poll() is None, self.stderr.read_text()
            try:
                control.connect(str(self.path))
            except OSError:
                return False
            return True

        wait_until(try_connect, "control socket")
        return control

    def send_line(self, line: bytes) -> None:
        self.control.sendall(line + b"\n")

    def read_line(self) -> dict[str, Any]:
        line = b""
        while not line.endswith(b"\n"):
            byte = self.control.recv(1)
            assert byte, f"the light hung up: {self.stderr.read_text()}"
            line += byte
        return dict(json.loads(line))

    def ask(self, op: str, **fields: Any) -> dict[str, Any]:
        self.send_line(json.dumps({"op": op, **fields}).encode())
        return self.read_line()

    def do(self, op: str, **fields: Any) -> dict[str, Any]:
        reply = self.ask(op, **fields)
        assert reply["ok"], reply
        return reply

    def advance(self, us: int, **await_: int) -> dict[str, Any]:
        return self.do("advance", us=us, **({"await": await_} if await_ else {}))

    def wire(self, name: str) -> dict[str, Any]:
        return dict(self.do("wires")["wires"][name])

    def address(self, name: str) -> tuple[str, int]:
        host, port = self.wire(name)["address"].split(":", 1)[1].rsplit(":", 1)
        return host.strip("[]"), int(port)

    def quit(self) -> int:
        self.do("quit")
        return self.process.wait(PATIENCE_S)

    def close(self) -> None:
        self.control.close()
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                pipe.close()


class Peer:
    """The other end of a wire, whatever its kind."""

    def __init__(self, light: Light, name: str) -> None:
        kind = light.wire(name)["address"].split(":")[0]
        self.sock: socket.socket | None = None
        self.fd = -1
        if kind == "pty":
            self.fd = os.open(light.wire(name)["address"].split(":", 1)[1], os.O_RDWR | os.O_NOCTTY)
            return
        host, port = light.address(name)
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        udp = kind.startswith("udp")
        self.sock = socket.socket(family, socket.SOCK_DGRAM if udp else socket.SOCK_STREAM)
        self.sock.settimeout(PATIENCE_S)
        self.sock.connect((host, port))
        self.fd = self.sock.fileno()

    def send(self, data: bytes) -> None:
        assert os.write(self.fd, data) == len(data)

    def read(self, count: int) -> bytes:
        """Exactly so many bytes, or a failure."""
        data = b""
        while len(data) < count:
            ready, _, _ = select.select([self.fd], [], [], PATIENCE_S)
            assert ready, f"only {data!r}, not {count} bytes"
            data += os.read(self.fd, 65536)
        return data

    def is_silent(self) -> bool:
        return not select.select([self.fd], [], [], 0)[0]

    def close(self) -> None:
        if self.sock is not None:
            self.sock.close()
        else:
            os.close(self.fd)


Start = Callable[..., Light]
