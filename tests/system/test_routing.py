# SPDX-License-Identifier: Apache-2.0
"""Routing between links, over UDP, a pty, TCP and the CAN tunnel: what others say to each other
goes on unchanged, whether the light knows it or not."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations
from typing import Any

import pytest

from harness import (
    ACCEPTED,
    BUS,
    CONSOLE,
    ON_OFF,
    REQUEST_MESSAGE,
    STATUS,
    WIRES,
    Shell,
    of,
)
from pharos import MavlinkConnection, Simulator, Source, Target

# Who is at which wire: a ground station, an autopilot, and another station beyond each.
PEERS = {
    "uart0": Source(255, 190),
    "uart1": Source(7, 1),
    "uart2": Source(8, 1),
    "can0": Source(9, 1),
}
ADDRESSES = {
    "uart0": WIRES["udp"],
    "uart1": "pty:{folder}/uart1",
    "uart2": WIRES["tcp"],
    "can0": BUS,
}
UNKNOWN = bytes.fromhex("fd 05 00 00 2a 09 01 ef cd ab 01 02 03 04 05 77 66".replace(" ", ""))
UNKNOWN_SIGNED = bytes.fromhex(
    "fd 05 01 00 2b 09 01 ef cd ab 01 02 03 04 05 77 66".replace(" ", "")
    + "00112233445566778899aabbcc"
)
UNKNOWN_HEAD = bytes.fromhex("34127f")  # message 0x7F1234
UNKNOWN_LONG = bytes.fromhex("fdff00002c0901efcdab") + bytes(range(255)) + b"\x12\x34"


class Network:
    """A light with four neighbours, who have all been heard."""

    def __init__(self, sim: Simulator, route: bool = True) -> None:
        self.sim = sim
        self.shell = Shell(sim)
        self.peers = {name: sim.connect(name, source) for name, source in PEERS.items()}
        if route:
            self.shell("param set MAV_ROUTE 1")
        self.hear_all()

    def hear_all(self) -> None:
        """Everyone says hello, and everything that came by then is forgotten."""
        for peer in self.peers.values():
            peer.heartbeat()
        self.sim.advance(s=1)
        for peer in self.peers.values():
            peer.link.take()

    def raw(self, seconds: float = 1) -> dict[str, bytes]:
        """The bytes that each neighbour gets within the next seconds."""
        self.sim.advance(s=seconds)
        return {name: b"".join(peer.link.take()) for name, peer in self.peers.items()}

    def reach(self, frame: bytes, source: str) -> set[str]:
        """Whom a frame reaches, as it is, that the neighbour sends."""
        self.peers[source].link.send(frame)
        return {name for name, data in self.raw().items() if frame in data}


@pytest.fixture
def network(start: Callable[..., Simulator]) -> Network:
    return Network(start({**ADDRESSES, "console": CONSOLE}))


def others(name: str) -> set[str]:
    return PEERS.keys() - {name}


def command(peer: MavlinkConnection, target: Source) -> bytes:
    message = peer.dialect.MAVLink_command_long_message(
        target.system, target.component, ON_OFF, 0, 1, 0, 0, 0, 0, 0, 0
    )
    return peer.encode(message)


def setup(peer: MavlinkConnection, target: Target) -> bytes:
    message = peer.dialect.MAVLink_setup_signing_message(
        target.system, target.component, bytes(range(32)), 1
    )
    return peer.encode(message)


def heartbeat(peer: MavlinkConnection) -> bytes:
    return peer.encode(peer.dialect.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3))


def test_nothing_is_forwarded_by_default(start: Callable[..., Simulator]) -> None:
    network = Network(start({**ADDRESSES, "console": CONSOLE}), route=False)
    for name, peer in network.peers.items():
        assert network.reach(heartbeat(peer), name) == set()
    assert network.reach(UNKNOWN, "can0") == set()


def test_it_can_be_turned_off_again(network: Network) -> None:
    network.shell("param set MAV_ROUTE 0")
    assert network.reach(heartbeat(network.peers["uart0"]), "uart0") == set()


@pytest.mark.parametrize("name", PEERS)
def test_a_broadcast_reaches_every_other_link_unchanged(network: Network, name: str) -> None:
    assert network.reach(heartbeat(network.peers[name]), name) == others(name)


@pytest.mark.parametrize(("source", "target"), list(permutations(PEERS, 2)))
def test_an_addressed_frame_reaches_its_target_alone(
    network: Network, source: str, target: str
) -> None:
    assert network.reach(command(network.peers[source], PEERS[target]), source) == {target}


def test_an_addressed_frame_for_nobody_known_reaches_nobody(network: Network) -> None:
    peer = network.peers["uart0"]
    assert network.reach(command(peer, Source(77, 1)), "uart0") == set()
    assert network.reach(command(peer, Source(7, 2)), "uart0") == set()
    assert network.reach(command(peer, Source(7, 0)), "uart0") == {"uart1"}


@pytest.mark.parametrize("frame", [UNKNOWN, UNKNOWN_SIGNED, UNKNOWN_LONG],
                         ids=["short", "signed", "long"])  # fmt: skip
@pytest.mark.parametrize("name", PEERS)
def test_an_unknown_message_reaches_every_other_link_unchanged(
    network: Network, name: str, frame: bytes
) -> None:
    mine = frame[:5] + bytes([PEERS[name].system, PEERS[name].component]) + frame[7:]
    assert network.reach(mine, name) == others(name)


def test_unknown_messages_amid_known_ones_cost_none(network: Network) -> None:
    peer = network.peers["uart1"]
    sent = b""
    for number in range(3):
        for frame in (UNKNOWN, UNKNOWN_LONG, UNKNOWN_SIGNED):
            unknown = frame[:4] + bytes([number, 7, 1]) + frame[7:]
            sent += unknown + heartbeat(peer)
    peer.link.send(sent)
    got = network.raw()
    for name in others("uart1"):
        assert got[name].count(b"\xef\xcd\xab") == 9
        assert all(frame in got[name] for frame in sent.split(b"\xef\xcd\xab")[1:-1])


def test_mavlink_1_goes_on_in_mavlink_1(network: Network) -> None:
    peer = network.peers["uart1"]
    peer.version = 1
    frame = heartbeat(peer)
    assert frame[0] == 0xFE
    assert network.reach(frame, "uart1") == others("uart1")
    assert network.reach(command(peer, PEERS["can0"]), "uart1") == {"can0"}


@pytest.mark.parametrize("target", [Target(0, 0), Target(7, 1), Target(8, 0), Target(1, 243)])
def test_setup_signing_is_never_forwarded(network: Network, target: Target) -> None:
    assert network.reach(setup(network.peers["uart0"], target), "uart0") == set()


def test_what_is_for_the_light_is_answered_and_not_forwarded(network: Network) -> None:
    peer = network.peers["uart0"]
    frame = command(peer, Source(1, 243))
    assert network.reach(frame, "uart0") == set()
    assert int(network.sim.outputs()["level_ppm"]) > 0


def test_what_is_for_everyone_is_answered_and_forwarded(network: Network) -> None:
    peer = network.peers["uart0"]
    frame = command(peer, Source(0, 0))
    peer.link.send(frame)
    network.sim.advance(s=1)
    assert [m.result for m in of("COMMAND_ACK", peer.drain())] == [ACCEPTED]
    for name in others("uart0"):
        assert frame in b"".join(network.peers[name].link.take())


def test_an_answer_finds_its_way_back(network: Network) -> None:
    station, autopilot = network.peers["uart0"], network.peers["can0"]
    station.link.send(command(station, PEERS["can0"]))
    network.sim.advance(s=1)
    asked = of("COMMAND_LONG", autopilot.drain())
    assert [(m.get_srcSystem(), m.command) for m in asked] == [(255, ON_OFF)]
    d = autopilot.dialect
    autopilot.send(d.MAVLink_command_ack_message(ON_OFF, ACCEPTED, 0, 0, 255, 190))
    got = network.raw()
    assert [name for name in PEERS if b"\x4d\x00\x00\x95\x01" in got[name]] == ["uart0"]


def test_an_echo_goes_round_no_further(network: Network) -> None:
    """A neighbour sends all that it hears back, and so does another."""
    seen: dict[str, int] = {}
    station = network.peers["uart0"]
    frame = heartbeat(station)
    station.link.send(frame)
    for _ in range(20):
        for name, data in network.raw(0.05).items():
            seen[name] = seen.get(name, 0) + data.count(frame)
            if data and name != "uart0":
                network.peers[name].link.send(data)
    assert seen == {"uart0": 0, "uart1": 1, "uart2": 1, "can0": 1}
    assert "gone in a circle 3" in network.shell("route")


def test_two_lights_joined_by_two_uarts_fall_silent_after_a_round(
    start: Callable[..., Simulator],
) -> None:
    """33 unverifiable frames of 33 senders, once, into a ring: they end, and so does all else."""
    wires = {name: f"pty:{{folder}}/{name}" for name in ("uart0", "uart1", "uart2")}
    lights = [start({**wires, "console": CONSOLE}) for _ in range(2)]
    ends = [[sim.connect(name, Source(1, 1)).link for name in wires] for sim in lights]
    for number, sim in enumerate(lights):
        Shell(sim)("param set MAV_ROUTE 1")
        Shell(sim)(f"param set MAV_SYSID {101 + number}")

    def carry(seconds: float) -> int:
        """What either says on the UARTs that join them reaches the other; the bytes of it that
        are not its own."""
        carried = 0
        for _ in range(round(seconds / 0.01)):
            said = [[b"".join(end.take()) for end in ends[i][1:]] for i in range(2)]
            for i in range(2):
                for data, end in zip(said[i], ends[1 - i][1:], strict=True):
                    carried += data.count(UNKNOWN_HEAD) * 13
                    if data:
                        end.send(data)
            for sim in lights:
                sim.advance(10_000)
        return carried

    carry(2)
    for system in range(1, 34):
        head = bytes([0xFD, 1, 0, 0, 0, system, 1])
        ends[0][0].send(head + UNKNOWN_HEAD + bytes([7, 0x55, 0xAA]))
    assert 0 < carry(1) <= 3 * 33 * 13
    assert carry(5) == 0


def test_a_neighbour_that_moves_is_found_again(network: Network) -> None:
    moved = MavlinkConnection(
        network.peers["uart2"].link, network.sim, network.sim.dialect, PEERS["uart1"]
    )
    network.sim.advance(s=6)
    moved.heartbeat()
    network.sim.advance(s=1)
    frame = command(network.peers["uart0"], PEERS["uart1"])
    assert network.reach(frame, "uart0") == {"uart2"}


def test_who_is_where_is_shown(network: Network) -> None:
    shown = network.shell("route")
    assert "routing         on" in shown
    assert "255/190        uart0" in shown
    assert "  9/1          tunnel0" in shown


@pytest.mark.parametrize("keyed", [False, True])
def test_others_signed_frames_go_on_whatever_the_lights_key(network: Network, keyed: bool) -> None:
    if keyed:
        network.shell("signing key")
        network.shell("11" * 32)
    station = network.peers["uart0"]
    station.sign(bytes(range(32)), 10**12)
    assert network.reach(command(station, PEERS["can0"]), "uart0") == {"can0"}


# --- a slow link ----------------------------------------------------------------------------------
BAUD = 57600


@pytest.fixture
def slow(start: Callable[..., Simulator]) -> Network:
    wires = {**ADDRESSES, "uart1": f"pty:{{folder}}/uart1,baud={BAUD},paced", "console": CONSOLE}
    return Network(start(wires))


def flood(network: Network, count: int) -> None:
    """Much more than the slow link carries: count frames of 280 bytes from the ground station."""
    for number in range(count):
        frame = UNKNOWN_LONG[:4] + bytes([number % 256, 255, 190]) + UNKNOWN_LONG[7:]
        network.peers["uart0"].link.send(frame)


def test_forwarding_never_delays_our_own_answers(slow: Network) -> None:
    autopilot = slow.peers["uart1"]
    flood(slow, 40)
    begin = slow.sim.now_us()
    assert autopilot.command_long(REQUEST_MESSAGE, STATUS).result == ACCEPTED
    autopilot.recv("ILLUMINATOR_STATUS", timeout_us=100_000)
    # At most one forwarded frame is on the wire already: 267 bytes of 10 bits. Then come the
    # answers, 71 bytes, and whatever of the light's streams was due before, 120 bytes at most;
    # the question took 45 bytes.
    longest_us = (267 + 71 + 120 + 45) * 10 * 1_000_000 / BAUD
    assert slow.sim.now_us() - begin <= longest_us + 5_000


def test_what_has_no_room_is_dropped_whole_and_counted(slow: Network) -> None:
    flood(slow, 40)
    data = slow.raw(2)
    got = data["uart1"].count(b"\xef\xcd\xab")
    assert 2 <= got <= 10
    assert data["uart1"].count(bytes(range(255))) == got, "each is whole"
    assert data["uart2"].count(b"\xef\xcd\xab") == 40, "the fast link had room for all"
    found = [line for line in slow.shell("link stats").splitlines() if "forwarded" in line]
    assert f"dropped {40 - got}" in found[1]


def test_streams_go_on_beside_a_flood(slow: Network) -> None:
    autopilot = slow.peers["uart1"]
    autopilot.drain()
    autopilot.inbox.clear()
    came: list[Any] = []
    for _ in range(50):
        flood(slow, 3)
        came += autopilot.pass_time(100_000)
    assert len([m for m in of("HEARTBEAT", came) if m.get_srcComponent() == 243]) == 5
    assert len(of("ILLUMINATOR_STATUS", came)) == 5
