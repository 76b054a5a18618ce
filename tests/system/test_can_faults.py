# SPDX-License-Identifier: Apache-2.0
"""A CAN bus that loses, repeats and reorders frames, goes off or away, or is full: counted,
recovered, and what was acknowledged is in force."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

import pytest
from dronecan import transport, uavcan

from harness import (
    ACCEPTED,
    BUS,
    CONFIGURE,
    CONSOLE,
    HAS_OWN_CONTROLLER,
    INTERNAL,
    NODE,
    ON_OFF,
    TRANSPORTS,
    Light,
    Shell,
    light_on,
    of,
)
from pharos import SilentError, Simulator, Source, Tunnel
from pharos.can_node import CanPort
from pharos.can_transfer import Header, pack, split

Starts = Callable[..., Simulator]
pytestmark = pytest.mark.bus
# Frames take their time; those of a bus of the kernel's take the host's, which does not show here.
PACED = BUS if HAS_OWN_CONTROLLER else BUS + ",paced"
modelled_controller = pytest.mark.skipif(
    HAS_OWN_CONTROLLER, reason="goes bus-off by itself: tests/linux/test_can_light.py"
)


@pytest.fixture(params=["can", "canfd"])
def bus_light(start: Starts, request: pytest.FixtureRequest) -> Light:
    sim = start({"can0": BUS, "console": CONSOLE})
    return light_on(sim, transport=TRANSPORTS[request.param])


def with_retries(light: Light, command: int, *params: float, tries: int = 30) -> int:
    """How many tries it took until an acknowledgement came."""
    for attempt in range(1, tries + 1):
        try:
            ack = light.mav.command_long(command, *params, timeout_us=200_000)
        except SilentError:
            continue
        assert ack.result == ACCEPTED
        return attempt
    raise AssertionError(f"no answer to {tries} tries")


def faults(sim: Simulator) -> int:
    return int(sim.request("buses")["buses"]["can0"]["faults"])


@pytest.mark.parametrize("kind", ["lost", "doubled", "reordered", "flipped"])
def test_what_was_acknowledged_is_in_force_on_a_bad_bus(bus_light: Light, kind: str) -> None:
    sim = bus_light.sim
    # A command and its answer are about 12 classic frames, or 2 with FD.
    sim.fault("can0", kind, rate_ppm=50_000)
    tries = []
    # In turn, so that a late acknowledgement is not taken for that of the next command.
    for index in range(50):
        tries.append(with_retries(bus_light, ON_OFF, index % 2))
        assert sim.outputs()["enable"] == index % 2
        tries.append(with_retries(bus_light, CONFIGURE, INTERNAL, index, 0, 100))
        assert sim.outputs()["brightness_ppm"] == index * 10_000
    assert faults(sim) > 5, "the fault hit nothing"
    if kind == "lost":
        assert max(tries) > 1
    sim.fault("can0", "none")
    sim.advance(s=3)
    bus_light.mav.pass_time(0)
    assert bus_light.on() == ACCEPTED


def test_repeated_frames_alone_lose_nothing(bus_light: Light) -> None:
    bus_light.sim.fault("can0", "doubled", rate_ppm=1_000_000)
    for index in range(20):
        assert bus_light.mav.command_long(ON_OFF, index % 2).result == ACCEPTED
    assert bus_light.sim.outputs()["enable"] == 1


def test_interleaved_transfers_of_ten_askers_are_put_together(start: Starts) -> None:
    sim = start({"can0": BUS, "console": CONSOLE})
    sim.advance(s=1)
    dialect = sim.dialect
    askers = []
    for own in range(20, 30):
        codec = dialect.MAVLink(None, 255, own)
        frame = dialect.MAVLink_command_long_message(1, 243, ON_OFF, 0, 1, *[0] * 6).pack(codec)
        message = uavcan.tunnel.Targetted(target_node=NODE, serial_id=own % 8, baudrate=57600)
        message.buffer.from_bytes(frame)
        data = split(pack(message, False), _seed(message), 0, False)
        askers.append([(Header(3001, own, 16).identifier, part) for part in data])
    assert len(askers[0]) == 8  # 6 bytes of header, 44 of command, 2 of CRC, 7 in each frame
    for turn in zip(*askers, strict=True):
        for identifier, part in turn:
            sim.bus().send(identifier, part, False)
    sim.advance(s=1)
    assert sim.outputs()["enable"] == 1
    told = Shell(sim)("can")
    assert "transfers     rx 10, " in told
    assert "incomplete 0, CRC 0" in told
    assert "4 opened, 0 closed, 6 refused" in told


def _seed(message: object) -> int:
    return int(transport.get_dronecan_data_type(message).base_crc)


@modelled_controller
def test_bus_off_is_counted_and_recovered(bus_light: Light) -> None:
    sim = bus_light.sim
    shell = Shell(sim)
    assert bus_light.on() == ACCEPTED
    sim.fault("can0", "bus-off", hold_us=3_000_000)
    sim.advance(s=1)
    assert "bus-off, " in shell("can")
    assert sim.outputs()["enable"] == 1, "the lamp does as commanded meanwhile"
    sim.advance(s=10)
    bus_light.greet()
    assert bus_light.off() == ACCEPTED
    told = shell("can")
    assert "error-active" in told
    assert "bus-offs 1" in told


@modelled_controller
def test_ten_bus_offs_in_a_row(bus_light: Light) -> None:
    for index in range(10):
        bus_light.sim.fault("can0", "bus-off", hold_us=1000)
        bus_light.sim.advance(s=1)
        assert with_retries(bus_light, ON_OFF, index % 2) <= 5
    assert "bus-offs 10" in Shell(bus_light.sim)("can")


def test_interface_that_goes_and_comes(bus_light: Light) -> None:
    sim = bus_light.sim
    assert bus_light.on() == ACCEPTED
    sim.fault("can0", "gone")
    sim.advance(s=60)
    assert sim.outputs()["enable"] == 1
    assert sim.outputs()["resets"] in (0, 1)  # with FD the fixture's own
    sim.fault("can0", "none")
    sim.advance(s=5)
    bus_light.greet()
    assert bus_light.off() == ACCEPTED


def test_client_that_vanishes_amid_a_transfer_leaves_the_next_one_whole(start: Starts) -> None:
    sim = start({"can0": BUS})
    light = light_on(sim, transport=TRANSPORTS["can"])
    message = uavcan.tunnel.Targetted(target_node=NODE, serial_id=0, baudrate=57600)
    message.buffer.from_bytes(bytes(120))
    frames = list(split(pack(message, False), _seed(message), 31, False))
    for data in frames[:7]:
        sim.bus().send(Header(3001, 10, 16).identifier, data, False)
    assert light.on() == ACCEPTED


class Talkers:
    """Ten nodes that fill a 1 Mbit/s bus: messages and services, for others and for everybody."""

    SLICE_US = 10_000
    # 8 data bytes are at least 131 bits with the gap, about 136 with stuff bits.
    FRAMES = 70

    def __init__(self, port: CanPort) -> None:
        self._port = port
        self._random = random.Random(1)
        self._due_us = 0
        self._tid = 0
        port.nodes.append(self)  # type: ignore[arg-type]

    def receive(self, _identifier: int, _data: bytes, _fd: bool) -> None:
        pass

    def step(self, now_us: int) -> int:
        if now_us >= self._due_us:
            self._due_us = now_us + self.SLICE_US
            for index in range(self.FRAMES):
                self._frame(index)
        return self._due_us

    def _frame(self, index: int) -> None:
        source = 100 + index % 10
        header = self._random.choice(
            (
                Header(341, source, 24),  # NodeStatus
                Header(1034, source, 18),  # esc.Status
                Header(1010, source, 12),  # ArrayCommand
                Header(1081, source, 22),  # LightsCommand
                Header(3001, source, 20),  # Targetted
                Header(11, source, 25, 99, True),  # GetSet of somebody else
            )
        )
        self._tid = (self._tid + 1) % 32
        # Single frames: all of one light, one servo … that is not this light's.
        payload = bytes([0, 99 << 1, *self._random.randbytes(5), 0xC0 | self._tid])
        self._port.send(header.identifier, payload, False)


def test_commands_are_answered_on_a_full_bus_with_ten_other_nodes(start: Starts) -> None:
    sim = start({"can0": PACED, "console": CONSOLE})
    light = light_on(sim, transport=TRANSPORTS["can"])
    Talkers(sim.bus())
    begin_us, frames = sim.now_us(), sim.request("buses")["buses"]["can0"]["rx_frames"]
    for index in range(100):
        sim.advance(Talkers.SLICE_US)
        assert light.mav.command_long(ON_OFF, index % 2, timeout_us=500_000).result == ACCEPTED
        assert sim.outputs()["enable"] == index % 2
    frames = sim.request("buses")["buses"]["can0"]["rx_frames"] - frames
    load = frames * 131 / (sim.now_us() - begin_us)
    assert load > 0.9, "the bus was not full"
    told = Shell(sim)("can")
    assert "overruns 0" in told
    assert re.search(r"no room\s+rx 0, tx 0, late 0", told)
    assert "incomplete 0, CRC 0" in told
    assert of("HEARTBEAT", light.mav.history)


def test_full_bus_with_four_tunnels(start: Starts) -> None:
    sim = start({"can0": PACED})
    clients = [
        sim.connect("can0", Source(255, 190 + own), tunnel=Tunnel(own=own)) for own in range(20, 24)
    ]
    for client in clients:
        client.heartbeat()
    sim.advance(s=1)
    Talkers(sim.bus())
    for _ in range(10):
        for client in clients:
            client.send_command_long(ON_OFF, 1)
        sim.advance(500_000)
        for client in clients:
            assert [a.result for a in of("COMMAND_ACK", client.pass_time(0))] == [ACCEPTED]
