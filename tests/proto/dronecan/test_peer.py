# SPDX-License-Identifier: Apache-2.0
"""PyPI's dronecan as an independent peer of our endpoint, classic and FD, time by hand."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import dronecan
import pytest
from dronecan import uavcan
from dronecan.app.dynamic_node_id import CentralizedServer
from dronecan.app.node_monitor import NodeMonitor

TOP = Path(__file__).resolve().parents[3]
APP = TOP / "app"
NODE, PEER = 68, 10
MS = 1000
SECOND = 1_000_000
RESTART, SAVE, ERASE, ID_ALLOCATED = range(4)


class Frame(ctypes.Structure):
    _fields_ = (
        ("id", ctypes.c_uint32),
        ("fd", ctypes.c_bool),
        ("size", ctypes.c_uint8),
        ("data", ctypes.c_uint8 * 64),
    )


def run(*command: object) -> None:
    subprocess.run([str(word) for word in command], check=True)


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """Our sources, built as the host's shared library."""
    out = tmp_path_factory.mktemp("dronecan")
    native = TOP / "boards" / "native"
    run(
        *(sys.executable, native / "scripts" / "kconfig.py", "--kconfig", TOP / "Kconfig"),
        *("--srctree", native / "kconfig", "--out", out, "--sources", out / "sources.txt"),
        *(TOP / "prj.conf", native / "native.conf"),
    )
    dsdl = out / "proto" / "dronecan"
    run(sys.executable, APP / "proto" / "dronecan" / "generate.py", dsdl)
    sources = [*(APP / "core").glob("*.c"), *(APP / "proto" / "dronecan").glob("*.c")]
    compiler = shutil.which("cc")
    assert compiler is not None, "a C compiler is needed"
    flags = ["-std=gnu11", "-O1", "-g", "-shared", "-fPIC", "-Wall", "-Werror", f"-I{APP}"]
    sources += [dsdl / "dsdl.c", Path(__file__).parent / "shared_device.c"]
    run(
        *(compiler, *flags, f"-I{out}", "-imacros", out / "autoconf.h"),
        *(*sources, "-o", out / "device.so"),
    )
    device = ctypes.CDLL(str(out / "device.so"))
    device.device_receive.argtypes = (
        ctypes.c_int64,
        ctypes.c_uint32,
        ctypes.c_bool,
        ctypes.c_char_p,
        ctypes.c_uint8,
    )
    device.device_step.argtypes = (ctypes.c_int64,)
    device.device_next.argtypes = (ctypes.c_int64, ctypes.POINTER(Frame))
    device.device_next.restype = ctypes.c_bool
    device.device_rx_errors.restype = ctypes.c_uint64
    return device


class Bus:
    """A CAN driver for the peer's node; on the other end, the device."""

    def __init__(self, device: ctypes.CDLL, fd: bool, node_id: int) -> None:
        self.device = device
        self.fd = fd
        self.now_us = 0
        self.to_peer: deque[Any] = deque()
        device.device_start(node_id, fd, 42)
        self.node = dronecan.node.Node(
            self, node_id=PEER, send_canfd=fd, catch_handler_exceptions=False
        )

    # What dronecan.node.Node calls.
    def send(self, message_id: int, message: bytes, extended: bool, canfd: bool = False) -> None:
        assert extended
        data = bytes(message)
        self.device.device_receive(self.now_us, message_id, canfd, data, len(data))

    def receive(self, timeout: float) -> Any:
        return self.to_peer.popleft() if self.to_peer else None

    def run(self, duration_us: int) -> None:
        """Both sides, every 10 ms."""
        frame = Frame()
        for _ in range(0, duration_us, 10 * MS):
            self.now_us += 10 * MS
            self.device.device_step(self.now_us)
            while self.device.device_next(self.now_us, ctypes.byref(frame)):
                self.to_peer.append(
                    SimpleNamespace(
                        id=frame.id,
                        data=bytes(frame.data[: frame.size]),
                        extended=True,
                        canfd=frame.fd,
                        ts_monotonic=time.monotonic(),  # the peer's clock, not ours
                        ts_real=time.time(),
                    )
                )
            self.node.spin(0)

    def ask(self, request: Any) -> Any:
        """The response's payload; None: there was none."""
        answers: list[Any] = []
        self.node.request(request, NODE, answers.append, priority=20)
        self.run(50 * MS)
        assert len(answers) == 1, "no answer"
        return answers[0].response

    def heard(self, kind: Any) -> list[Any]:
        """Messages of a type from now on."""
        messages: list[Any] = []
        self.node.add_handler(kind, lambda event: messages.append(event.message))
        return messages


@pytest.fixture(params=[False, True], ids=["classic", "fd"])
def bus(library: ctypes.CDLL, request: pytest.FixtureRequest) -> Iterator[Bus]:
    bus = Bus(library, request.param, NODE)
    yield bus
    assert bus.device.device_rx_errors() == 0


def test_node_status_each_second(bus: Bus) -> None:
    heard = bus.heard(uavcan.protocol.NodeStatus)
    bus.run(10 * SECOND)
    assert [m.uptime_sec for m in heard] == list(range(10))
    assert {m.mode for m in heard} == {heard[0].MODE_OPERATIONAL}


def test_get_node_info(bus: Bus) -> None:
    info = bus.ask(uavcan.protocol.GetNodeInfo.Request())
    assert str(info.name) == "org.pharos.light"
    assert (info.software_version.major, info.software_version.minor) == (1, 2)
    assert (info.hardware_version.major, info.hardware_version.minor) == (3, 4)
    assert bytes(info.hardware_version.unique_id) == bytes([0xA0, *range(1, 16)])


def number_of(value: Any) -> float | int:
    kind = dronecan.get_active_union_field(value)
    assert kind in ("real_value", "integer_value")
    return getattr(value, kind)  # type: ignore[no-any-return]


def test_every_parameter_is_read_and_one_is_set(bus: Bus) -> None:
    names: list[str] = []
    while True:
        answer = bus.ask(uavcan.protocol.param.GetSet.Request(index=len(names)))
        if len(answer.name) == 0:
            break
        assert number_of(answer.min_value) <= number_of(answer.value)
        assert number_of(answer.value) <= number_of(answer.max_value)
        names.append(str(answer.name))
    assert "LGT_LOSS" in names
    assert len(set(names)) == len(names)

    request = uavcan.protocol.param.GetSet.Request(name="LGT_LOSS")
    request.value.real_value = 4.3206
    assert bus.ask(request).value.real_value == pytest.approx(4.321, rel=1e-6)
    assert bus.device.device_param(b"LGT_LOSS") == 4321
    assert bus.device.device_params_changed() == 1


def test_save_and_restart(bus: Bus) -> None:
    assert bus.ask(uavcan.protocol.param.ExecuteOpcode.Request(opcode=0)).ok
    assert bus.device.device_action_count(SAVE) == 1
    request = uavcan.protocol.RestartNode.Request()
    request.magic_number = request.MAGIC_NUMBER
    assert bus.ask(request).ok
    bus.run(100 * MS)
    assert bus.device.device_action_count(RESTART) == 1


def test_transport_stats(bus: Bus) -> None:
    bus.run(3 * SECOND)
    stats = bus.ask(uavcan.protocol.GetTransportStats.Request())
    assert stats.transfers_tx >= 6
    assert stats.transfers_rx == 1
    assert stats.transfer_errors == 0
    assert len(stats.can_iface_stats) == 1
    assert stats.can_iface_stats[0].frames_rx == 1


def test_the_tunnel_both_ways(bus: Bus) -> None:
    heard = bus.heard(uavcan.tunnel.Targetted)
    sent = bytes(index * 7 % 256 for index in range(1000))
    for at in range(0, len(sent), 120):
        message = uavcan.tunnel.Targetted(target_node=NODE, serial_id=3, options=1, baudrate=57600)
        message.protocol.protocol = message.protocol.MAVLINK2
        message.buffer.from_bytes(sent[at : at + 120])
        bus.node.broadcast(message, priority=16)
        bus.run(20 * MS)
    assert b"".join(bytes(m.buffer) for m in heard) == bytes(byte ^ 0xFF for byte in sent)
    assert {(m.target_node, m.serial_id, m.protocol.protocol) for m in heard} == {(PEER, 3, 1)}


def test_lights_hardpoint_and_actuator(bus: Bus) -> None:
    light = uavcan.equipment.indication.SingleLightCommand(light_id=254)
    light.color.green = 21
    bus.node.broadcast(uavcan.equipment.indication.LightsCommand(commands=[light]))
    assert bus.device.device_brightness_ppm() == 333333  # 21/63
    bus.node.broadcast(uavcan.equipment.hardpoint.Command(hardpoint_id=0, command=0))
    assert bus.device.device_brightness_ppm() == 0
    actuator = uavcan.equipment.actuator.Command(actuator_id=9, command_type=4, command_value=1750)
    bus.node.broadcast(uavcan.equipment.actuator.ArrayCommand(commands=[actuator]))
    assert bus.device.device_brightness_ppm() == 750000


def test_hardpoint_status_follows(bus: Bus) -> None:
    heard = bus.heard(uavcan.equipment.hardpoint.Status)
    bus.run(50 * MS)
    bus.node.broadcast(uavcan.equipment.hardpoint.Command(hardpoint_id=0, command=1))
    bus.run(50 * MS)
    assert [m.status for m in heard] == [0, 1]


def test_the_allocator_gives_an_id(library: ctypes.CDLL) -> None:
    bus = Bus(library, fd=False, node_id=0)
    monitor = NodeMonitor(bus.node)
    server = CentralizedServer(bus.node, monitor)
    # The peer's own clock hardly moves meanwhile, so nothing of its own times out.
    bus.run(6 * SECOND)
    assert bus.device.device_action_count(ID_ALLOCATED) == 1
    table: Callable[[], Any] = server.get_allocation_table
    assert (bytes([0xA0, *range(1, 16)]), 125) in [(bytes(u or b""), i) for u, i in table()]
    assert 125 in [entry.node_id for entry in monitor.find_all(lambda _: True)]
