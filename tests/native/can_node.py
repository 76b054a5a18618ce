# SPDX-License-Identifier: Apache-2.0
"""can_app on a bus of its own. The peer is python-can with the bus class `pharos-udp`, which shares
nothing with the light but the wire."""

from __future__ import annotations

import re
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import can

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "host" / "src"))

from echo_light import PATIENCE_S, Peer, Start
from pharos.can_udp import PharosUdpBus

# Zephyr's numbers of modes and of frame flags.
FD, ONE_SHOT, MANUAL = 4, 8, 32
IDE, FDF, BRS = 1, 4, 8
ACTIVE, WARNING, PASSIVE, BUS_OFF = range(4)
EAGAIN, EBUSY, ENETDOWN, ENETUNREACH = 11, 16, 100, 101


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.255.255.255", 0))
        return int(sock.getsockname()[1])


class Node:
    """can_app, and how to talk to it in lock-step."""

    def __init__(self, start: Start, *options: str, bus: str = "", virtual: bool = True) -> None:
        channel = f"127.255.255.255:{free_port()}"
        url = bus.replace("CHANNEL", channel) if bus else f"udp:{channel}"
        options += ("--can0", url, "--uart0", "udpin:127.0.0.1:0")
        self.light = start(*options, virtual=virtual, app="can_app")
        self.peer = Peer(self.light, "uart0")
        self.address = self.light.do("buses")["buses"]["can0"]["address"]
        channel = re.sub(r"^udp:|,paced$", "", self.address)
        self.bus = PharosUdpBus(channel=channel, fd=True)
        self.sent = self.told = self.read = self.frames = 0

    def command(self, text: str) -> None:
        line = text.encode() + b"\n"
        self.peer.send(line)
        self.told += len(line)

    def send(self, *messages: can.Message) -> None:
        for message in messages:
            self.bus.send(message)
        self.sent += len(messages)

    def advance(self, us: int = 0) -> tuple[list[list[str]], list[can.Message]]:
        """What the device said and what it sent."""
        reply = self.light.advance(us, uart0=self.told, can0=self.sent)
        assert reply["buses"]["can0"]["rx_frames"] == self.sent
        text = self.peer.read(reply["wires"]["uart0"]["tx_bytes"] - self.read)
        self.read += len(text)
        count = reply["buses"]["can0"]["tx_frames"] - self.frames
        self.frames += count
        return [line.split() for line in text.decode().splitlines()], self.receive(count)

    def receive(self, count: int) -> list[can.Message]:
        frames = [self.bus.recv(PATIENCE_S) for _ in range(count)]
        assert None not in frames
        return [frame for frame in frames if frame is not None]

    def start(
        self, mode: int = FD, bitrate: int = 1_000_000, data_bitrate: int = 4_000_000
    ) -> None:
        self.command(f"start {mode} {bitrate} {data_bitrate}")
        assert self.advance()[0][-1][1:] == ["done", "0"]

    def count(self, name: str) -> int:
        return int(self.light.do("buses")["buses"]["can0"][name])

    def close(self) -> None:
        self.bus.shutdown()
        self.peer.close()


NewNode = Callable[..., Node]


def message(
    identifier: int, data: bytes = b"", *, extended: bool = True, fd: bool = False
) -> can.Message:
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=extended, is_fd=fd)


def only(said: list[list[str]], kind: str) -> list[list[str]]:
    return [line[2:] for line in said if line[1] == kind]
