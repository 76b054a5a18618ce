# SPDX-License-Identifier: Apache-2.0
"""A CAN bus inside this process (python-can's `virtual`), time by hand, and a node that has a
tunnel as a light has: the protocol's other side, written from the definition."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import can
from dronecan import uavcan

from pharos.can_node import CanPort, DronecanNode
from pharos.can_transfer import Transfer

_channels = itertools.count()


class VirtualTime:
    """Pacer of ports that share a bus. Time stands still unless pumped."""

    def __init__(self) -> None:
        self.ports: list[CanPort] = []
        self._now_us = 1_000_000
        self._channel = f"pharos-test-{next(_channels)}"
        # What else passes time, such as a simulator; called with µs.
        self.followers: list[Callable[[int], None]] = []

    def now_us(self) -> int:
        return self._now_us

    def port(self) -> CanPort:
        bus = can.Bus(interface="virtual", channel=self._channel, protocol=can.CanProtocol.CAN_FD)
        self.ports.append(CanPort(bus))
        return self.ports[-1]

    def pump(self, us: int) -> None:
        end = self._now_us + us
        while True:
            dues = [due for port in self.ports if (due := port.step(self._now_us)) is not None]
            self._settle()
            for follow in self.followers:
                follow(0)
            self._settle()
            if self._now_us >= end:
                return
            until = min([end, *(max(due, self._now_us + 1) for due in dues)])
            for follow in self.followers:
                follow(until - self._now_us)
            self._now_us = until

    def _settle(self) -> None:
        """Until nothing is under way: what arrives may cause more."""
        while sum(port.poll(0) for port in self.ports):
            pass

    def close(self) -> None:
        for port in self.ports:
            port.close()


class TunnelServer:
    """The light's end: opened by the first Targetted, answers its asker, 120 bytes at a time."""

    def __init__(self, node: DronecanNode) -> None:
        self.node = node
        self.heard: list[Transfer] = []
        self.received = b""
        node.subscribe(uavcan.tunnel.Targetted, self._on_targetted)

    def _on_targetted(self, transfer: Transfer) -> None:
        if transfer.message.target_node == self.node.node_id:
            self.heard.append(transfer)
            self.received += bytes(transfer.message.buffer.to_bytes())

    def say(
        self,
        data: bytes,
        *,
        target: int | None = None,
        serial_id: int | None = None,
        protocol: int | None = None,
    ) -> None:
        asker = self.heard[-1]
        self.node.fd = asker.fd
        for at in range(0, len(data), 120):
            message = uavcan.tunnel.Targetted(
                target_node=asker.header.source if target is None else target,
                serial_id=asker.message.serial_id if serial_id is None else serial_id,
                baudrate=asker.message.baudrate,
            )
            own = asker.message.protocol.protocol
            message.protocol.protocol = own if protocol is None else protocol
            message.buffer.from_bytes(data[at : at + 120])
            self.node.broadcast(message, 16)
