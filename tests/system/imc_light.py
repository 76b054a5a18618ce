# SPDX-License-Identifier: Apache-2.0
"""A light that speaks IMC, and peers that talk to it over each transport, in both byte orders.

Peers encode with the host's own codec, or with PyPI's independent `imcpy`, where it installs. What
the light sends is decoded by both, and must come to the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from pharos import Simulator
from pharos.imc import ImcPeer, Message, Packet, encode

try:
    import imcpy
except ImportError:
    imcpy = None

# Entities, as docs/imc.md lists them.
SYSTEM, LAMP, THERMAL = 0, 1, 2

# How a peer reaches the light: the wire, its option, and what follows it.
IMC_WIRES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "tcp": ("uart1", "tcpin:127.0.0.1:0", ("--protocol", "imc")),
    "pty": ("uart1", "pty:{folder}/uart1", ("--protocol", "imc")),
    "udp": ("imc", "udp:127.0.0.1:0,discovery={port}", ()),
}


def _imcpy_message(message: Message) -> Any:
    made = getattr(imcpy, message.name)()
    for field in message.kind.fields:
        value = message[field.name]
        if field.kind == "list":
            for item in value:
                getattr(made, field.name).append(_imcpy_message(item))
            continue
        kind = type(getattr(made, field.name))
        setattr(made, field.name, value if kind in (str, int, float) else kind(value))
    return made


def by_imcpy(packet: Packet) -> bytes:
    """The packet as imcpy encodes it, in this host's byte order."""
    made = _imcpy_message(packet.message)
    made.src, made.src_ent = packet.src, packet.src_ent
    made.dst, made.dst_ent = packet.dst, packet.dst_ent
    made.timestamp = packet.timestamp
    return bytes(made.serialize())


ENCODERS: dict[str, Callable[[Packet], bytes]] = {
    "little": encode,
    "big": partial(encode, big_endian=True),
}
if imcpy is not None:
    ENCODERS["imcpy"] = by_imcpy


class CheckedPeer(ImcPeer):
    """Everything that comes is what imcpy makes of it as well."""

    def _sort_in(self) -> None:
        seen = len(self.inbox)
        super()._sort_in()
        for packet in self.inbox[seen:] if imcpy is not None else []:
            theirs = imcpy.Packet.deserialize(packet.raw)
            assert theirs.msg_name == packet.name
            assert bytes(theirs.serialize()) == packet.raw == encode(packet)


@dataclass
class ImcLight:
    """A running light, and a peer that it knows."""

    sim: Simulator
    peer: ImcPeer
    wire: str


def join(sim: Simulator, wire: str, encoder: str = "little", id: int = 0x4001) -> ImcPeer:
    """A peer at that wire, that has announced itself or sent a heartbeat; the light is up."""
    plain = sim.imc(wire, id=id)
    peer = CheckedPeer(plain.link, sim, id=id)
    peer.encode = ENCODERS[encoder]
    sim.advance(s=1)
    if wire == "imc":
        peer.announce()
    peer.send("Heartbeat")
    sim.advance(0)
    peer.take()
    return peer
