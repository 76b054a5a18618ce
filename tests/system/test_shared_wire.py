# SPDX-License-Identifier: Apache-2.0
"""Several peers at one wire: each is heard, in whatever pieces it speaks and whoever speaks beside
it; and no stranger takes the place of one that is heard."""

from __future__ import annotations

import random
import socket
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from harness import BUILD, ON_OFF, SECOND_US, WIRES
from imc_light import IMC_WIRES
from pharos import Simulator, Source, find_dialect, load_dialect
from pharos.imc import Message, Packet, encode

Starts = Callable[..., Simulator]

# A COMMAND_LONG to switch on of 255/190, and a HEARTBEAT of 255/191.
COMMAND = bytes.fromhex(
    "fd21000001ffbe4c00000000803f000000000000000000000000000000000000000000000000950101f30010fe"
)
HEARTBEAT = bytes.fromhex("fd09000001ffbf000000000000000608000403c7b8")
PLACES = 8


class Party:
    """A light, and any number of peers at its first UART."""

    def __init__(self, sim: Simulator, wire: str = "uart0") -> None:
        self.sim = sim
        self.wire = wire
        state = sim.request("wires")["wires"][wire]
        kind, host, port = state["address"].split(":")
        self.kind = socket.SOCK_STREAM if kind == "tcpin" else socket.SOCK_DGRAM
        self.address = (host, int(port))
        self.said = int(state["rx_bytes"])
        self.peers: list[Peer] = []
        self.advance(SECOND_US)  # it is up

    def join(self) -> Peer:
        self.peers.append(Peer(self))
        return self.peers[-1]

    def advance(self, us: int) -> None:
        """Time goes on once all that was said has arrived."""
        self.sim.request("advance", us=us, **{"await": {self.wire: self.said}})

    def close(self) -> None:
        for peer in self.peers:
            peer.socket.close()


class Peer:
    def __init__(self, party: Party) -> None:
        self.party = party
        self.socket = socket.socket(socket.AF_INET, party.kind)
        self.socket.connect(party.address)
        if party.kind == socket.SOCK_STREAM:
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.setblocking(False)
        self.parser = load_dialect(find_dialect(BUILD)).MAVLink(None)
        self.parser.robust_parsing = True

    def say(self, data: bytes) -> None:
        self.socket.sendall(data)
        self.party.said += len(data)

    def bytes(self) -> bytes:
        data = b""
        while True:
            try:
                more = self.socket.recv(65536)
            except BlockingIOError:
                return data
            if not more:
                return data
            data += more

    def hears(self, kind: str) -> list[Any]:
        """Messages of the light, by now."""
        messages = self.parser.parse_buffer(self.bytes()) or []
        return [m for m in messages if m.get_type() == kind and m.get_srcComponent() == 243]


@pytest.fixture
def party(start: Starts) -> Iterator[Callable[[str], Party]]:
    parties = []

    def make(wire: str) -> Party:
        parties.append(Party(start({"uart0": WIRES[wire]})))
        return parties[-1]

    yield make
    for each in parties:
        each.close()


@pytest.mark.parametrize("wire", ["tcp", "udp"])
@pytest.mark.parametrize("gap_ms", [0, 5, 20, 40, 90])
def test_a_frame_in_pieces_is_whole_whoever_speaks_between(
    party: Callable[[str], Party], wire: str, gap_ms: int
) -> None:
    here = party(wire)
    one, other = here.join(), here.join()
    for peer in (one, other):
        peer.say(HEARTBEAT)
    here.advance(SECOND_US)
    one.say(COMMAND[:20])
    here.advance(gap_ms * 1000)
    other.say(HEARTBEAT)
    here.advance(gap_ms * 1000)
    one.say(COMMAND[20:])
    here.advance(50_000)
    assert [m.command for m in one.hears("COMMAND_ACK")] == [ON_OFF]


@pytest.mark.parametrize("wire", ["tcp", "udp"])
def test_a_second_peer_waits_for_a_frame_that_has_begun(
    party: Callable[[str], Party], wire: str
) -> None:
    """The first was alone when it began, so the light has the beginning already."""
    here = party(wire)
    one = here.join()
    one.say(HEARTBEAT)
    here.advance(SECOND_US)
    one.say(COMMAND[:20])
    here.advance(1000)
    other = here.join()
    other.say(HEARTBEAT)
    here.advance(1000)
    one.say(COMMAND[20:] + COMMAND[:7])
    here.advance(1000)
    one.say(COMMAND[7:])
    here.advance(50_000)
    assert len(one.hears("COMMAND_ACK")) == 2


@pytest.mark.parametrize("wire", ["tcp", "udp"])
def test_a_message_that_is_not_finished_keeps_nobody_waiting(
    party: Callable[[str], Party], wire: str
) -> None:
    """Nor, for long, what its own sender says next: within 200 ms and the framer's 60."""
    here = party(wire)
    one, other = here.join(), here.join()
    one.say(HEARTBEAT)
    other.say(HEARTBEAT)
    here.advance(SECOND_US)
    one.say(COMMAND[:20])
    other.say(COMMAND)
    here.advance(10_000)
    assert len(other.hears("COMMAND_ACK")) == 1
    one.say(COMMAND)
    here.advance(300_000)
    assert len(one.hears("COMMAND_ACK")) == 2


def test_whoever_hangs_up_takes_the_beginning_along(party: Callable[[str], Party]) -> None:
    here = party("tcp")
    one, other = here.join(), here.join()
    one.say(HEARTBEAT)
    other.say(HEARTBEAT + COMMAND[:20])
    here.advance(SECOND_US)
    other.socket.close()
    here.advance(1000)
    one.say(COMMAND)
    here.advance(10_000)
    assert len(one.hears("COMMAND_ACK")) == 1


def pieces(rng: random.Random, data: bytes) -> Iterator[bytes]:
    """1 … 40 bytes at a time."""
    at = 0
    while at < len(data):
        size = rng.randint(1, 40)
        yield data[at : at + size]
        at += size


def commands_in_pieces(rng: random.Random, source: Source, count: int) -> Iterator[bytes]:
    d = load_dialect(find_dialect(BUILD))
    encoder = d.MAVLink(None, srcSystem=source.system, srcComponent=source.component)
    for number in range(count):
        message = d.MAVLink_command_long_message(1, 243, ON_OFF, 0, number % 2, 0, 0, 0, 0, 0, 0)
        yield from pieces(rng, message.pack(encoder))
        encoder.seq = (encoder.seq + 1) % 256


@pytest.mark.parametrize("wire", ["tcp", "udp"])
def test_two_clients_in_pieces_beside_a_talker_lose_nothing(
    party: Callable[[str], Party], wire: str
) -> None:
    """10,000 commands of two clients, each piece at another time, beside one that says 50 frames a
    second: each is answered."""
    count, rng = 10_000, random.Random(15)
    here = party(wire)
    clients = [here.join(), here.join()]
    talker = here.join()
    for peer in here.peers:
        peer.say(HEARTBEAT)
    here.advance(SECOND_US)
    sources = (Source(255, 190), Source(254, 190))
    streams = [commands_in_pieces(rng, source, count // 2) for source in sources]
    answered = turn = 0
    open_streams = True
    while open_streams:
        open_streams = False
        for client, stream in zip(clients, streams, strict=True):
            piece = next(stream, b"")
            if piece:
                open_streams = True
                client.say(piece)
        if turn % 10 == 0:
            talker.say(HEARTBEAT)
        here.advance(2000)
        answered += len(clients[0].hears("COMMAND_ACK"))
        clients[1].bytes()
        talker.bytes()
        turn += 1
    here.advance(SECOND_US)
    answered += len(clients[0].hears("COMMAND_ACK"))
    assert answered == count


def test_imc_packets_in_pieces_are_whole_as_well(start: Starts) -> None:
    wire, address, options = IMC_WIRES["tcp"]
    here = Party(start({wire: address}, options=options), wire)
    here.advance(2 * SECOND_US)
    try:
        peers, rng = [here.join() for _ in range(3)], random.Random(15)
        query = Packet(Message("QueryEntityState"), src=0x4001, dst=0xFFFF, dst_ent=1)
        for peer in peers:
            peer.say(encode(Packet(Message("Heartbeat"), src=0x4001)))
        here.advance(SECOND_US)
        for peer in peers:
            peer.bytes()
        streams = [pieces(rng, encode(query) * 100) for _ in peers]
        told = b""
        said = True
        while said:
            said = False
            for peer, stream in zip(peers, streams, strict=True):
                piece = next(stream, b"")
                if piece:
                    said = True
                    peer.say(piece)
            here.advance(2000)
            told += peers[0].bytes()
        here.advance(100_000)
        told += peers[0].bytes()
        # EntityState is message 1; the light also tells its Heartbeat (150) each second.
        assert told.count(b"\x54\xfe\x01\x00") == 3 * 100
    finally:
        here.close()


# --- places ---------------------------------------------------------------------------------------
def heartbeats(party: Party, peer: Peer, seconds: int) -> int:
    """What it hears without saying anything."""
    peer.bytes()
    party.advance(seconds * SECOND_US)
    return len(peer.hears("HEARTBEAT"))


def test_strangers_take_no_stations_place(party: Callable[[str], Party]) -> None:
    """8 datagrams of one byte from 8 ports, then many more; the station has commanded once."""
    here = party("udp")
    station = here.join()
    station.say(COMMAND)
    here.advance(1000)
    for _ in range(10):
        for _ in range(PLACES):
            here.join().say(b"x")
        here.advance(100_000)
        assert heartbeats(here, station, 3) == 3


def test_a_new_station_gets_the_place_of_a_stranger_or_of_one_that_is_silent(
    party: Callable[[str], Party],
) -> None:
    here = party("udp")
    stations = [here.join() for _ in range(PLACES)]
    for station in stations[1:]:
        station.say(HEARTBEAT)
    here.join().say(b"x")
    here.advance(100_000)
    stations[0].say(HEARTBEAT)
    here.advance(SECOND_US)
    assert all(station.hears("HEARTBEAT") for station in stations)
    for station in stations[1:]:
        station.say(HEARTBEAT)
    late = here.join()
    late.say(HEARTBEAT)
    assert heartbeats(here, late, 1) == 0, "eight are heard: there is no place for a ninth"
    for station in stations[1:]:
        station.say(HEARTBEAT)
    here.advance(SECOND_US)
    late.say(HEARTBEAT)
    assert heartbeats(here, late, 1) == 1, "the first has been silent"


def test_silent_tcp_clients_shut_nobody_out(party: Callable[[str], Party]) -> None:
    here = party("tcp")
    station = here.join()
    station.say(HEARTBEAT)
    here.advance(SECOND_US)
    for _ in range(3 * PLACES):  # each takes the place of a silent one, never the station's
        here.join()
        here.advance(SECOND_US)
        station.say(HEARTBEAT)
    assert heartbeats(here, station, 3) == 3
    here.advance(3 * SECOND_US)
    late = here.join()
    here.advance(1000)
    late.say(COMMAND)
    here.advance(10_000)
    assert len(late.hears("COMMAND_ACK")) == 1
