# SPDX-License-Identifier: Apache-2.0
"""`pharos check --profile dronecan` on right nodes and on nodes with one fault each."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from dronecan import transport, uavcan

from checking import failing
from pharos import SilentError, Simulator
from pharos.can_node import DronecanNode
from pharos.check import Level, Report
from pharos.check.dronecan import check_node
from pharos.check.spec import PROFILES
from virtual_bus import VirtualTime

NODE = 42
protocol = uavcan.protocol
hardpoint = uavcan.equipment.hardpoint

# What each fault breaks.
FAULTS: dict[str, tuple[str, ...]] = {
    "NodeStatus every 2 s": ("DN-1",),
    "uptime in ms": ("DN-2", "DN-6"),
    "uptime stands still": ("DN-2",),
    "mode 5": ("DN-3",),
    "transfer ids stay": ("DN-5",),
    "does not say who it is": ("DN-6", "DN-7", "DN-8", "DN-11"),
    "another uptime in GetNodeInfo": ("DN-6",),
    "has no name": ("DN-7",),
    "a name with spaces": ("DN-7",),
    "unique id of zeros": ("DN-8",),
    "unique id by chance": ("DN-8",),
    "answers for others": ("DN-9",),
    "restarts whatever the number": ("DN-10",),
    "is deaf after half a transfer": ("DN-11",),
    "lists one parameter twice": ("DP-1",),
    "a parameter without a value": ("DP-1",),
    "looks at the index first": ("DP-2", "DP-3"),
    "knows any name": ("DP-3",),
    "a value above its limit": ("DP-4",),
    "answers a set with nothing": ("DP-5",),
    "is no longer switched off": ("DH-1", "DH-2"),
    "does not say that it is on": ("DH-1",),
    "is everybody's hardpoint": ("DH-2",),
}
PARAMETERS = [("BRIGHT", 40, 0, 100), ("COLOUR", 3, 0, 7), ("LIGHT_ID", 1, 0, 255)]


class ModelNode:
    """A light that is a DroneCAN node, by the specification, with faults to be switched on."""

    def __init__(self, time: VirtualTime, faults: set[str] | None = None) -> None:
        self.time = time
        self.faults = faults or set()
        self.lit = 0
        self.asked = 0
        self.node = DronecanNode(time.port(), time.now_us, NODE)
        self.started_us = time.now_us()
        self.status_us = time.now_us()
        self.node._status_us = 1 << 60  # it says it itself, below
        self.node.steppers.append(self.step)
        if "does not say who it is" in self.faults:
            self.node._servers.clear()
        else:
            self.node.serve(protocol.GetNodeInfo, self.info)
        self.node.serve(protocol.RestartNode, self.restart)
        self.node.serve(protocol.param.GetSet, self.get_set)
        self.node.subscribe(hardpoint.Command, self.switch)
        if "answers for others" in self.faults:
            self.node.monitors.append(self.answer_for_others)
        self.node.port.listeners.append(self.hear)

    def hear(self, frame: Any) -> None:
        if "is deaf after half a transfer" in self.faults and frame.data[-1] == 0x80 | 9:
            self.node._servers.clear()

    # --- status -------------------------------------------------------------------------------
    def step(self, now_us: int) -> int:
        if now_us >= self.status_us:
            self.status_us += 2_000_000 if "NodeStatus every 2 s" in self.faults else 1_000_000
            if "transfer ids stay" in self.faults:
                self.node._transfer_ids.clear()
                self.node.assembler = type(self.node.assembler)()
            self.node.broadcast(self.status())
            self.say_hardpoint()
        return self.status_us

    def status(self) -> Any:
        us = self.time.now_us() - self.started_us
        uptime = us // (1_000 if "uptime in ms" in self.faults else 1_000_000)
        if "uptime stands still" in self.faults:
            uptime = 7
        return protocol.NodeStatus(uptime_sec=uptime, mode=5 if "mode 5" in self.faults else 0)

    def info(self, _request: Any) -> Any:
        answer = protocol.GetNodeInfo.Response()
        answer.status = self.status()
        if "another uptime in GetNodeInfo" in self.faults:
            answer.status.uptime_sec += 100
        name = "com.lumen.torch"
        if "has no name" in self.faults:
            name = ""
        if "a name with spaces" in self.faults:
            name = "My Torch"
        answer.name.encode(name)
        self.asked += 1
        unique = bytes([7] * 16)
        if "unique id of zeros" in self.faults:
            unique = bytes(16)
        if "unique id by chance" in self.faults:
            unique = bytes([self.asked % 256] * 16)
        answer.hardware_version.unique_id = list(unique)
        return answer

    def answer_for_others(self, transfer: Any) -> None:
        header = transfer.header
        if header.is_request and header.destination != NODE:
            self.node._respond(transfer)

    def restart(self, request: Any) -> Any:
        right = request.message.magic_number == request.message.MAGIC_NUMBER
        if right or "restarts whatever the number" in self.faults:
            self.started_us = self.time.now_us()
            right = True
        return protocol.RestartNode.Response(ok=right)

    # --- parameters ---------------------------------------------------------------------------
    def get_set(self, request: Any) -> Any:
        answer = protocol.param.GetSet.Response()
        name, index = str(request.message.name), int(request.message.index)
        names = [row[0] for row in PARAMETERS]
        if "lists one parameter twice" in self.faults and index == 2 and not name:
            index = 1
        if name and "looks at the index first" not in self.faults:
            if name not in names and "knows any name" not in self.faults:
                return answer
            index = names.index(name) if name in names else 0
        if index >= len(PARAMETERS):
            return answer
        key, value, low, high = PARAMETERS[index]
        if "answers a set with nothing" in self.faults and _is_set(request.message):
            return answer
        if "a value above its limit" in self.faults:
            value = high + 1
        answer.name.encode(key)
        if not ("a parameter without a value" in self.faults and index == 1):
            answer.value.integer_value = value
        answer.default_value.integer_value = low
        answer.min_value.integer_value, answer.max_value.integer_value = low, high
        return answer

    # --- hardpoint ----------------------------------------------------------------------------
    def switch(self, transfer: Any) -> None:
        if transfer.message.hardpoint_id == 3 or "is everybody's hardpoint" in self.faults:
            self.lit = int(transfer.message.command != 0)
            if "is no longer switched off" in self.faults:
                self.lit = 1
            self.say_hardpoint()

    def say_hardpoint(self) -> None:
        status = 0 if "does not say that it is on" in self.faults else self.lit
        self.node.broadcast(hardpoint.Status(hardpoint_id=3, status=status))


def _is_set(message: Any) -> bool:
    return transport.get_active_union_field(message.value) not in (None, "empty")


@pytest.fixture
def time() -> Iterator[VirtualTime]:
    virtual = VirtualTime()
    yield virtual
    virtual.close()


def report_of(time: VirtualTime, *faults: str) -> Report:
    ModelNode(time, set(faults))
    return check_node(DronecanNode(time.port(), time.now_us, 100), NODE, time)


def test_a_right_node_passes(time: VirtualTime) -> None:
    report = report_of(time)
    assert [(r.requirement.id, r.seen) for r in report.results if r.outcome != "passed"] == []
    assert report.maker == "com.lumen.torch"


def test_our_light_passes(binary: Path) -> None:
    with Simulator(binary, {"can0": "udp:127.255.255.255:{port}"}) as sim:
        sim.advance(s=2)
        report = check_node(sim.node(100), 68, sim)
        assert sim.outputs()["enable"] == 0
    assert [(r.requirement.id, r.seen) for r in report.results if r.outcome != "passed"] == []


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_found_by_the_must_that_it_breaks(time: VirtualTime, fault: str) -> None:
    assert failing(report_of(time, fault), Level.MUST) == list(FAULTS[fault])


def test_each_must_has_a_fault() -> None:
    musts = {r.id for r in PROFILES["dronecan"] if r.level == Level.MUST}
    assert musts == {must for broken in FAULTS.values() for must in broken}


def test_who_is_not_there_is_said(time: VirtualTime) -> None:
    with pytest.raises(SilentError, match="node 9 was not heard"):
        check_node(DronecanNode(time.port(), time.now_us, 100), 9, time)
