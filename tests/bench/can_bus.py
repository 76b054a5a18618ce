# SPDX-License-Identifier: Apache-2.0
"""The CAN part of the table: the tunnel on the user-space bus in real time, and what one light
costs on a 1 Mbit/s bus."""

from __future__ import annotations

import os
import socket
import statistics
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import can
from dronecan import transport, uavcan

from pharos import Simulator
from pharos.can_transfer import Header, pack, parse_identifier, split
from pharos.can_udp import PharosUdpBus, decode, encode
from pharos.control import ControlClient

LIGHT, CLIENT, SERIAL = 68, 10, 0
TARGETTED = 3001
END = 0x40
COMMAND_ACK = 77
BITRATE = 1_000_000
COUNT_S = 60
# Nodes that an autopilot, a tool and an allocator leave of the 125 ids.
NODES_MAX = 122
START_TIMEOUT_S = 20.0
NAMES = {341: "NodeStatus", 1071: "hardpoint.Status", 1110: "Temperature", TARGETTED: "Targetted"}

Figure = tuple[str, float, str]


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


# --- real time ------------------------------------------------------------------------------------
@dataclass
class Bus:
    """The light's process, and this side's place on its bus."""

    pid: int
    control: ControlClient
    bus: PharosUdpBus

    def frames(self) -> int:
        counts = self.control.request("buses")["buses"]["can0"]
        return int(counts["rx_frames"]) + int(counts["tx_frames"])

    def cpu_s(self) -> float:
        fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def light_on_bus(binary: Path) -> Iterator[Bus]:
    channel = f"127.255.255.255:{free_port()}"
    bus = PharosUdpBus(channel)
    with tempfile.TemporaryDirectory(prefix="pharos-") as folder:
        control = Path(folder) / "control"
        process = subprocess.Popen(
            [str(binary), "--control", str(control), "--can0", f"udp:{channel}",
             "--console", "none"],
            stdin=subprocess.DEVNULL,
            cwd=folder,
        )  # fmt: skip
        try:
            yield Bus(process.pid, _connect(control), bus)
        finally:
            process.kill()
            process.wait()
            bus.shutdown()


def _connect(control: Path) -> ControlClient:
    end = time.monotonic() + START_TIMEOUT_S
    while True:
        try:
            return ControlClient(str(control))
        except OSError:
            if time.monotonic() > end:
                raise SystemExit("bench: the light opened no control socket") from None
            time.sleep(0.01)


def command_datagrams(dialect: Any, transfer_id: int) -> list[bytes]:
    """A COMMAND_LONG in a Targetted, as the datagrams of its frames."""
    codec = dialect.MAVLink(None, 255, 190)
    frame = dialect.MAVLink_command_long_message(1, 243, 405, 0, 1, 0, 0, 0, 0, 0, 0).pack(codec)
    message = uavcan.tunnel.Targetted(target_node=LIGHT, serial_id=SERIAL, baudrate=57600)
    message.buffer.from_bytes(frame)
    seed = int(transport.get_dronecan_data_type(message).base_crc)
    identifier = Header(TARGETTED, CLIENT, 16).identifier
    return [
        encode(can.Message(arbitration_id=identifier, data=data))
        for data in split(pack(message, False), seed, transfer_id, False)
    ]


class Acks:
    """Counts acknowledgements among the frames of the light's Targetted transfers."""

    def __init__(self) -> None:
        self.count = 0
        self._transfer = b""

    def take(self, datagram: bytes) -> None:
        frame = decode(datagram)
        if frame is None:
            return
        header = parse_identifier(frame.arbitration_id)
        if header.is_service or (header.type_id, header.source) != (TARGETTED, LIGHT):
            return
        self._transfer += bytes(frame.data[:-1])
        if frame.data[-1] & END:
            # 2 bytes of CRC and 6 of Targetted come before the MAVLink frame.
            self.count += int.from_bytes(self._transfer[15:18], "little") == COMMAND_ACK
            self._transfer = b""


def measure_tunnel(binary: Path, dialect: Any, pings: int, commands: int) -> list[Figure]:
    transfers = [command_datagrams(dialect, transfer_id) for transfer_id in range(32)]
    acks = Acks()
    with light_on_bus(binary) as light:
        receiver, sender, target = light.bus._receiver, light.bus._sender, light.bus._target
        receiver.settimeout(2.0)

        def send(index: int) -> None:
            for datagram in transfers[index % 32]:
                sender.sendto(datagram, target)

        def wait(total: int) -> None:
            while acks.count < total:
                datagram, source = receiver.recvfrom(128)
                if source[1] != light.bus._own_port:
                    acks.take(datagram)

        send(0)
        wait(1)
        took_us = []
        for index in range(1, pings + 1):
            begin = time.perf_counter_ns()
            send(index)
            wait(index + 1)
            took_us.append((time.perf_counter_ns() - begin) / 1e3)
        frames, cpu_s, begin_s = light.frames(), light.cpu_s(), time.monotonic()
        window = 8
        for index in range(pings + 1, pings + 1 + commands):
            send(index)
            wait(index + 1 - window)
        wait(pings + 1 + commands)
        spent_s = time.monotonic() - begin_s
        frames, cpu_s = light.frames() - frames, light.cpu_s() - cpu_s
    cuts = statistics.quantiles(took_us, n=100)
    return [
        ("CAN tunnel: command→ACK p50, 8 + 5 frames", statistics.median(took_us), "µs"),
        ("CAN tunnel: command→ACK p99", cuts[98], "µs"),
        (f"CAN tunnel: ACKs per second, {window} in flight", commands / spent_s, "/s"),
        ("CAN frames per second, both ways", frames / spent_s, "/s"),
        ("CAN: CPU of the light per frame", cpu_s / frames * 1e6, "µs"),
    ]


# --- bus load -------------------------------------------------------------------------------------
def frame_bits(size: int) -> int:
    """The longest that a classic frame with a 29-bit id can be: SOF 1, arbitration 32, control 6,
    CRC 15 + 1, ACK 2, EOF 7, gap 3; and a stuff bit for every 4 of the first 54 + 8 n - 1."""
    return 67 + 8 * size + (54 + 8 * size - 1) // 4


def count_frames(binary: Path, dialect: Any, tunnel: bool) -> tuple[Counter[str], float]:
    """Frames of the light and of its client by type, and their bits, in COUNT_S."""
    frames: Counter[str] = Counter()
    bits = 0

    def take(frame: can.Message) -> None:
        nonlocal bits
        frames[NAMES[parse_identifier(frame.arbitration_id).type_id]] += 1
        bits += frame_bits(len(frame.data))

    with Simulator(binary, {"can0": "udp:127.255.255.255:{port}"}, dialect=dialect) as sim:
        port = sim.bus()
        client = sim.connect("can0") if tunnel else None
        if client is not None:
            client.heartbeat()
        sim.advance(s=5)
        port.listeners.append(take)
        sent = port.sent
        sim.advance(s=COUNT_S)
        if client is not None:
            # The client's keepalives and heartbeats are the tunnel's price too; its own NodeStatus
            # is not. A frame of 8 bytes is the longest.
            ours = port.sent - sent - COUNT_S
            frames["Targetted to it"] = ours
            bits += ours * frame_bits(8)
    return frames, bits


def load_figures(binary: Path, dialect: Any) -> list[Figure]:
    """At most NODES_MAX lights have an id, however much of the bus is left."""
    figures: list[Figure] = []
    for name, tunnel in (("no tunnel", False), ("a tunnel", True)):
        frames, bits = count_frames(binary, dialect, tunnel)
        load = bits / COUNT_S / BITRATE
        figures += [
            (f"CAN, {name}: frames of {kind}", count / COUNT_S, "/s")
            for kind, count in frames.items()
        ]
        figures += [
            (f"CAN, {name}: their bits, all stuffed", bits / COUNT_S, "bit/s"),
            (f"CAN, {name}: load of one light", load * 100, "%"),
            (f"CAN, {name}: lights on half of a bus", min(int(0.5 / load), NODES_MAX), ""),
        ]
    return figures


def measure(binary: Path, dialect: Any, pings: int = 3000, commands: int = 5000) -> list[Figure]:
    return [*measure_tunnel(binary, dialect, pings, commands), *load_figures(binary, dialect)]
