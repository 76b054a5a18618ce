# SPDX-License-Identifier: Apache-2.0
"""A node that talks IMC with a light, over a stream (TCP, a pty, a serial line) or datagrams."""

from __future__ import annotations

import select
import socket
from collections.abc import Callable
from typing import Any

from ..errors import LinkError, SilentError
from ..link import DATAGRAM_MAX, Link, Pacer
from .codec import ALL_ENTITIES, Packet, Stream, decode, encode, message

DISCOVERY_PORTS = 5
VEHICLE = 0x4001
LIGHT = 0x8442


class DatagramLink(Link):
    """UDP on loopback as IMC uses it: a fixed port for packets, and a free one of the five that
    announcements go to. `sent` counts datagrams to the light."""

    unit = "datagrams"

    def __init__(self, light: tuple[str, int], discovery_first: int, heard_on: int) -> None:
        super().__init__()
        self.light = light
        self._heard_on = heard_on
        self._packets = _bound(0)
        self._announcements = _first_free(discovery_first)

    @property
    def address(self) -> tuple[str, int]:
        host, port = self._packets.getsockname()[:2]
        return str(host), int(port)

    @property
    def services(self) -> str:
        """What an Announce says of where packets are welcome."""
        return "imc+info://0.0.0.0/version/5.4.31;imc+udp://{}:{}/".format(*self.address)

    def fileno(self) -> int:
        return self._packets.fileno()

    def send(self, data: bytes) -> None:
        self._write(data)
        self.sent += 1

    def announce(self, data: bytes) -> None:
        """Sends `data` to where the light hears announcements."""
        self._packets.sendto(data, (self.light[0], self._heard_on))
        self.sent += 1

    def _write(self, data: bytes) -> None:
        try:
            self._packets.sendto(data, self.light)
        except ConnectionRefusedError:
            pass  # the fate of an earlier datagram
        except OSError as error:
            raise LinkError(f"{self}: {error.strerror}") from error

    def poll(self, timeout_s: float) -> bool:
        """All that is at hand: on loopback, all that was sent."""
        both = [self._packets, self._announcements]
        ready = select.select(both, [], [], timeout_s)[0]
        for source in ready:
            self.inbox.append(source.recv(DATAGRAM_MAX))
            self.received += 1
        return bool(ready)

    def fetch(self, count: int, timeout_s: float | None = None) -> None:
        """The light counts what it sends to others as well: takes what has come."""
        del count, timeout_s
        while self.poll(0.0):
            pass

    def _read(self) -> bytes:
        return self._packets.recv(DATAGRAM_MAX)

    def close(self) -> None:
        self._packets.close()
        self._announcements.close()

    def __str__(self) -> str:
        return "imc udp {}:{}".format(*self.light)


def _bound(port: int) -> socket.socket:
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    udp.bind(("127.0.0.1", port))
    return udp


def _first_free(first: int) -> socket.socket:
    for port in range(first, first + DISCOVERY_PORTS):
        try:
            return _bound(port)
        except OSError:
            continue
    raise LinkError(f"none of the ports {first}…{first + DISCOVERY_PORTS - 1} is free")


class ImcPeer:
    """One end of a link. Packets that came lie in `inbox`, in order, until they are taken."""

    def __init__(self, link: Link, pacer: Pacer, id: int = VEHICLE, entity: int = 7) -> None:
        self.link = link
        self.id = id
        self.entity = entity
        self.light = LIGHT
        self.encode: Callable[[Packet], bytes] = encode
        self.inbox: list[Packet] = []
        self._pacer = pacer
        self._stream = Stream()

    def packet(
        self, name: str, /, *, dst: int | None = None, dst_ent: int = ALL_ENTITIES, **fields: Any
    ) -> Packet:
        """A packet of this peer, for the light unless told otherwise."""
        return Packet(
            message(name, **fields),
            src=self.id,
            src_ent=self.entity,
            dst=self.light if dst is None else dst,
            dst_ent=dst_ent,
        )

    def send(
        self, name: str, /, *, dst: int | None = None, dst_ent: int = ALL_ENTITIES, **fields: Any
    ) -> None:
        self.link.send(self.encode(self.packet(name, dst=dst, dst_ent=dst_ent, **fields)))

    def announce(self, services: str | None = None) -> None:
        """Says where this peer is. Datagrams only."""
        assert isinstance(self.link, DatagramLink)
        packet = self.packet(
            "Announce", dst=0, sys_name="peer", owner=0xFFFF,
            services=self.link.services if services is None else services,
        )  # fmt: skip
        self.link.announce(self.encode(packet))

    def pass_time(self, us: int) -> list[Packet]:
        """Lets `us` pass; all packets that came since the last call."""
        self._pacer.pump(us)
        return self.take()

    def take(self) -> list[Packet]:
        """All packets at hand, in order."""
        self._sort_in()
        taken, self.inbox = self.inbox, []
        return taken

    def _sort_in(self) -> None:
        for chunk in self.link.take():
            if isinstance(self.link, DatagramLink):
                self.inbox.append(decode(chunk))
            else:
                self.inbox += self._stream.feed(chunk)

    def recv(self, name: str, timeout_us: int = 1_000_000) -> Packet:
        """The oldest packet of that name; what came before it is dropped."""
        waited = 0
        while True:
            self._sort_in()
            while self.inbox:
                packet = self.inbox.pop(0)
                if packet.name == name:
                    return packet
            if waited > timeout_us:
                raise SilentError(f"no {name} within {timeout_us / 1e6:g} s")
            step = 0 if waited == 0 else min(100_000, timeout_us)
            self._pacer.pump(step)
            waited += max(step, 1)

    def ask(self, name: str, answer: str, /, **fields: Any) -> Packet:
        """Sends a message and waits for the answer to it."""
        self.take()
        self.send(name, **fields)
        return self.recv(answer)
