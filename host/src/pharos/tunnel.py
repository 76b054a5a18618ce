# SPDX-License-Identifier: Apache-2.0
"""MAVLink through DroneCAN's serial tunnel (uavcan.tunnel.Targetted), as an autopilot does it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from urllib.parse import parse_qsl

from dronecan import uavcan

from .can_node import OWN_NODE, CanPort, DronecanNode, open_bus
from .can_transfer import Transfer
from .errors import UrlError
from .link import Link, RealPacer

CHUNK = 120
PRIORITY = 16
# An idle tunnel is kept open by an empty Targetted after this; the light closes it after 3 s [µs].
KEEPALIVE_US = 500_000
# How a Targetted says that its bytes are to be read: MAVLink, of either version, or nothing at all.
PROTOCOL_MAVLINK2 = 1
PROTOCOLS = (0, PROTOCOL_MAVLINK2, 255)
OPTION_LOCK = 1
BAUD = 57600
NODE_MAX = 125


class TunnelLink(Link):
    """A link to node `peer` through the tunnel. `sent` and `received` count tunnelled bytes,
    `foreign` messages whose bytes are of another protocol than MAVLink."""

    def __init__(
        self, node: DronecanNode, peer: int, *, serial_id: int = 0, owns_port: bool = False
    ) -> None:
        super().__init__()
        self.node = node
        self.peer = peer
        self.serial_id = serial_id
        self.foreign = 0
        self._owns_port = owns_port
        self._keepalive_us = 0
        node.subscribe(uavcan.tunnel.Targetted, self._on_targetted)
        node.steppers.append(self._keep_open)

    def fileno(self) -> int:
        return self.node.port.fileno()

    def poll(self, timeout_s: float) -> bool:
        return self.node.port.poll(timeout_s)

    def step(self, now_us: int) -> int | None:
        return self.node.port.step(now_us)

    def _write(self, data: bytes) -> None:
        for at in range(0, len(data), CHUNK):
            self._tell(data[at : at + CHUNK])

    def _read(self) -> bytes:
        return b""  # what comes goes into the inbox by itself

    def _keep_open(self, now_us: int) -> int:
        if now_us >= self._keepalive_us:
            self._tell(b"")
        return self._keepalive_us

    def _tell(self, data: bytes) -> None:
        message = uavcan.tunnel.Targetted(
            target_node=self.peer, serial_id=self.serial_id, options=OPTION_LOCK, baudrate=BAUD
        )
        message.protocol.protocol = PROTOCOL_MAVLINK2
        message.buffer.from_bytes(data)
        self.node.broadcast(message, PRIORITY)
        self._keepalive_us = self.node.clock() + KEEPALIVE_US

    def _on_targetted(self, transfer: Transfer) -> None:
        message = transfer.message
        if (
            transfer.header.source != self.peer
            or message.target_node != self.node.node_id
            or message.serial_id != self.serial_id
        ):
            return
        if message.protocol.protocol not in PROTOCOLS:
            self.foreign += 1
            return
        data = bytes(message.buffer.to_bytes())
        if data:
            self.received += len(data)
            self.inbox.append(data)

    def close(self) -> None:
        self.node.close()
        if self._owns_port:
            self.node.port.close()

    def __str__(self) -> str:
        return f"node {self.peer} on {self.node.port}{' (CAN FD)' if self.node.fd else ''}"


@dataclass(frozen=True)
class TunnelUrl:
    """dronecan:INTERFACE/CHANNEL?node=N[&own=M][&serial=S][&fd=1][&bitrate=B]"""

    interface: str
    channel: str
    node: int
    own: int = OWN_NODE
    serial: int = 0
    fd: bool = False
    bitrate: int | None = None


FORM = "dronecan:INTERFACE/CHANNEL?node=N"
_RANGES = {
    "node": (1, NODE_MAX),
    "own": (1, 127),
    "serial": (-1, 15),
    "fd": (0, 1),
    "bitrate": (1, 1_000_000),
}


def parse_tunnel_url(url: str) -> TunnelUrl:
    """UrlError says what is wrong in one line."""
    where, _, query = url.removeprefix("dronecan:").partition("?")
    interface, _, channel = where.partition("/")
    if not interface:
        raise UrlError(f"'{url}' names no CAN interface; expected {FORM}")
    values: dict[str, int] = {}
    for name, text in parse_qsl(query, keep_blank_values=True):
        if name not in _RANGES:
            raise UrlError(f"'{name}' in '{url}' is not one of {', '.join(_RANGES)}")
        low, high = _RANGES[name]
        try:
            values[name] = int(text)
        except ValueError:
            raise UrlError(f"{name}='{text}' in '{url}' is no number") from None
        if not low <= values[name] <= high:
            raise UrlError(f"{name}={text} in '{url}' is not within {low} … {high}")
    if "node" not in values:
        raise UrlError(f"'{url}' lacks ?node=N; `pharos can nodes {where}` lists the nodes")
    if values["node"] == values.get("own", OWN_NODE):
        raise UrlError(f"node and own are both {values['node']} in '{url}'")
    return TunnelUrl(
        interface,
        channel,
        values["node"],
        values.get("own", OWN_NODE),
        values.get("serial", 0),
        bool(values.get("fd", 0)),
        values.get("bitrate"),
    )


def open_tunnel(url: str, clock: Callable[[], int] | None = None) -> TunnelLink:
    """The link that a dronecan: URL names, on a bus of its own. clock: the host's if none."""
    parsed = parse_tunnel_url(url)
    options = {} if parsed.bitrate is None else {"bitrate": parsed.bitrate}
    bus = open_bus(parsed.interface, parsed.channel, fd=parsed.fd, **options)
    node = DronecanNode(CanPort(bus), clock or RealPacer(()).now_us, parsed.own, fd=parsed.fd)
    return TunnelLink(node, parsed.node, serial_id=parsed.serial, owns_port=True)
