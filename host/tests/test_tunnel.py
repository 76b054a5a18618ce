# SPDX-License-Identifier: Apache-2.0
"""The DroneCAN node and the tunnel link, in lock-step on a bus inside this process."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import can
import dronecan
import pytest
from dronecan import uavcan

from pharos import Light, MavlinkConnection, SilentError, Simulator, load_dialect
from pharos.can_node import BusDriver, CanPort, DronecanNode
from pharos.cli.can import find_nodes
from pharos.tunnel import KEEPALIVE_US, TunnelLink
from virtual_bus import TunnelServer, VirtualTime

LIGHT, PEER = 68, 10
SECOND = 1_000_000


@pytest.fixture
def time() -> Iterator[VirtualTime]:
    time = VirtualTime()
    yield time
    time.close()


@pytest.fixture(params=[False, True], ids=["classic", "fd"])
def fd(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


class Pair:
    """A tunnel and its other end."""

    def __init__(self, time: VirtualTime, fd: bool, serial_id: int = 0) -> None:
        self.time = time
        self.node = DronecanNode(time.port(), time.now_us, PEER, fd=fd)
        self.link = TunnelLink(self.node, LIGHT, serial_id=serial_id)
        light = DronecanNode(time.port(), time.now_us, LIGHT, name="org.pharos.light")
        self.server = TunnelServer(light)


@pytest.fixture
def pair(time: VirtualTime, fd: bool) -> Pair:
    return Pair(time, fd)


def test_idle_tunnel_is_kept_open_every_half_second(pair: Pair) -> None:
    pair.time.pump(5 * SECOND)
    assert len(pair.server.heard) == 11
    first = pair.server.heard[0]
    assert (first.header.source, first.header.priority, first.fd) == (PEER, 16, pair.node.fd)
    message = first.message
    assert (message.target_node, message.serial_id, message.options) == (LIGHT, 0, 1)
    assert (message.protocol.protocol, message.baudrate, len(message.buffer)) == (1, 57600, 0)


def test_bytes_that_are_sent_put_off_the_keepalive(pair: Pair) -> None:
    pair.time.pump(0)
    for _ in range(10):
        pair.time.pump(KEEPALIVE_US - 1)
        pair.link.send(b"x")
    pair.time.pump(0)
    assert [bytes(t.message.buffer.to_bytes()) for t in pair.server.heard] == [b""] + [b"x"] * 10


def test_long_writes_go_in_chunks_of_120(pair: Pair) -> None:
    data = bytes(index % 251 for index in range(500))
    pair.link.send(data)
    pair.time.pump(0)
    assert pair.server.received == data
    chunks = [len(t.message.buffer) for t in pair.server.heard if len(t.message.buffer)]
    assert chunks == [120, 120, 120, 120, 20]


def test_answers_arrive_in_order(pair: Pair) -> None:
    pair.time.pump(0)
    data = bytes(index % 253 for index in range(1000))
    pair.server.say(data)
    pair.time.pump(0)
    assert b"".join(pair.link.take()) == data
    assert pair.link.received == 1000


@pytest.mark.parametrize("protocol", [0, 1, 255])
def test_mavlink_of_either_version_or_of_no_name_is_taken(pair: Pair, protocol: int) -> None:
    """ArduPilot up to 4.5 always sends 255."""
    pair.time.pump(0)
    pair.server.say(b"frame", protocol=protocol)
    pair.time.pump(0)
    assert (pair.link.received, pair.link.foreign) == (5, 0)


def test_bytes_of_another_protocol_are_counted_and_not_taken(pair: Pair) -> None:
    pair.time.pump(0)
    pair.server.say(b"$GPGGA", protocol=2)
    pair.time.pump(0)
    assert (pair.link.received, pair.link.foreign) == (0, 1)


def test_answers_to_others_are_not_ours(pair: Pair) -> None:
    pair.time.pump(0)
    pair.server.say(b"another node's", target=PEER + 1)
    pair.server.say(b"another port's", serial_id=3)
    stranger = TunnelServer(DronecanNode(pair.time.port(), pair.time.now_us, 99))
    stranger.heard = pair.server.heard
    stranger.say(b"a stranger's")
    pair.time.pump(0)
    assert pair.link.take() == []


def test_two_ports_of_one_node_are_told_apart(time: VirtualTime) -> None:
    pair = Pair(time, False, serial_id=1)
    other = TunnelLink(pair.node, LIGHT, serial_id=2)
    time.pump(0)
    pair.server.say(b"one", serial_id=1)
    pair.server.say(b"two", serial_id=2)
    time.pump(0)
    assert (pair.link.take(), other.take()) == ([b"one"], [b"two"])


def test_closed_tunnel_says_nothing_more(pair: Pair) -> None:
    pair.time.pump(0)
    pair.link.close()
    heard = len(pair.server.heard)
    pair.time.pump(5 * SECOND)
    assert len(pair.server.heard) == heard


# --- the node -------------------------------------------------------------------------------------
def test_node_status_goes_out_at_1_hz(pair: Pair) -> None:
    heard: list[Any] = []
    pair.server.node.subscribe(uavcan.protocol.NodeStatus, heard.append)
    pair.time.pump(10 * SECOND)
    assert [t.message.uptime_sec for t in heard] == list(range(11))
    assert {(t.header.source, t.message.health, t.message.mode) for t in heard} == {(PEER, 0, 0)}


def test_node_info_is_asked_for_and_given(pair: Pair) -> None:
    info = pair.node.ask(uavcan.protocol.GetNodeInfo.Request(), LIGHT, pair.time)
    assert str(info.name) == "org.pharos.light"


def test_node_that_does_not_answer_is_silent(pair: Pair) -> None:
    with pytest.raises(SilentError, match="node 77 did not answer uavcan.protocol.GetNodeInfo"):
        pair.node.ask(uavcan.protocol.GetNodeInfo.Request(), 77, pair.time)


def test_nodes_are_found_with_their_names(pair: Pair) -> None:
    found = find_nodes(pair.node, pair.time, 2 * SECOND)
    assert [(seen.node, seen.as_fields()["name"]) for seen in found] == [(68, "org.pharos.light")]


def test_node_without_an_id_only_listens(time: VirtualTime) -> None:
    quiet = DronecanNode(time.port(), time.now_us, 0)
    time.pump(3 * SECOND)
    assert quiet.port.sent == 0


def test_remote_error_and_standard_frames_are_no_transfers(time: VirtualTime) -> None:
    node = DronecanNode(time.port(), time.now_us, PEER)
    other = time.port()
    for message in (
        can.Message(arbitration_id=0x123, is_extended_id=False, data=b"\xc0"),
        can.Message(arbitration_id=0x18015544, is_remote_frame=True),
        can.Message(arbitration_id=0x18015544, is_error_frame=True, data=bytes(8)),
    ):
        other.bus.send(message)
    time.pump(0)
    assert node.port.received == 3
    assert (node.assembler.errors, node.assembler.unknown) == (0, 0)


def test_an_independent_node_understands_ours_and_is_understood(time: VirtualTime) -> None:
    """PyPI's dronecan on the other side: its own framing, its own node."""
    port = time.port()
    theirs = dronecan.node.Node(
        BusDriver(port, time.now_us), node_id=LIGHT, catch_handler_exceptions=False
    )
    ours = DronecanNode(time.port(), time.now_us, PEER)
    link = TunnelLink(ours, LIGHT)
    theirs.node_info.name.encode("an.independent.node")
    heard: list[bytes] = []

    def echo(event: Any) -> None:
        heard.append(bytes(event.message.buffer.to_bytes()))
        answer = uavcan.tunnel.Targetted(target_node=PEER, serial_id=0, baudrate=57600)
        answer.buffer.from_bytes(heard[-1])
        theirs.broadcast(answer)

    theirs.add_handler(uavcan.tunnel.Targetted, echo)
    time.followers.append(lambda _us: theirs.spin(0))
    data = bytes(range(200))
    link.send(data)
    time.pump(SECOND)
    assert b"".join(heard) == data
    assert b"".join(link.take()) == data
    info = ours.ask(uavcan.protocol.GetNodeInfo.Request(), LIGHT, time)
    assert str(info.name) == "an.independent.node"
    answers: list[Any] = []
    theirs.request(uavcan.protocol.GetNodeInfo.Request(), PEER, answers.append)
    time.pump(0)
    assert str(answers[0].response.name) == "org.pharos.host"


# --- MAVLink through it ---------------------------------------------------------------------------
def test_light_is_commanded_through_the_tunnel(time: VirtualTime, binary: Path, fd: bool) -> None:
    """The whole way: client, tunnel, CAN frames, a tunnel's other end, and the light's UART."""
    pair = Pair(time, fd)
    with Simulator(binary, {"uart0": "udpin:127.0.0.1:0"}) as sim:
        uart = sim.open("uart0")
        carried = 0

        def carry(us: int) -> None:
            nonlocal carried
            if len(pair.server.received) > carried:
                uart.send(pair.server.received[carried:])
                carried = len(pair.server.received)
            sim.advance(us)
            for chunk in uart.take():
                pair.server.say(chunk)

        time.followers.append(carry)
        light = Light(MavlinkConnection(pair.link, time, load_dialect()))
        light.find()
        light.on()
        light.set_brightness(40)
        light.set_strobe(0.5, 20)
        status = light.fetch_status()
        assert (status.enable, status.brightness) == (True, 40)
        assert (status.strobe_period, status.strobe_duty_cycle) == (0.5, 20)
        assert sim.outputs()["brightness_ppm"] == 400_000


def test_light_on_the_bus_is_commanded_in_lock_step(binary: Path) -> None:
    with Simulator(binary, {"can0": "udp:127.255.255.255:{port}"}) as sim:
        light = Light(sim.connect("can0"))
        light.find()
        sim.advance(s=1)
        light.set_brightness(100)
        light.on()
        assert sim.outputs()["level_ppm"] == 1_000_000
        sim.advance(s=60)  # the tunnel is kept open
        assert light.fetch_status().uptime_ms > 60_000
        info = sim.node(11).ask(uavcan.protocol.GetNodeInfo.Request(), LIGHT, sim)
        assert str(info.name) == "org.pharos.light"
        light.off()
        assert sim.outputs()["level_ppm"] == 0


def test_simulators_bus_is_shared_and_counted(binary: Path) -> None:
    """Two nodes of this side on the light's own bus: in lock-step the light has been given every
    frame, and everything that it sent is here."""
    with Simulator(binary, {"can0": "udp:127.255.255.255:{port}"}) as sim:
        before = sim.request("buses")["buses"]["can0"]["tx_frames"]
        one, two = sim.node(10), sim.node(11)
        assert one.port is two.port
        assert isinstance(one.port, CanPort)
        sim.advance(s=10)
        bus = sim.request("buses")["buses"]["can0"]
        assert (bus["rx_frames"], bus["rx_malformed"]) == (one.port.sent, 0)
        assert one.port.sent >= 20
        assert one.port.received == bus["tx_frames"] - before
        assert one.port.received >= 10  # NodeStatus at 1 Hz
