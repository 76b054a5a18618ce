# SPDX-License-Identifier: Apache-2.0
"""The profile of a light that is a DroneCAN node: what the specification and the DSDL say is right.
How a light is commanded is no standard there, but for a hardpoint: that is tried if it has one."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from dronecan import transport, uavcan

from ..can_node import DronecanNode, fields_of
from ..can_transfer import Transfer
from ..errors import SilentError
from ..link import Pacer
from ..text import json_line
from .run import Report, Result, run_one
from .spec import PROFILES, Level, NotOffered, Requirement, expect, group, requirement
from .transcript import Transcript

SPECIFICATION = "https://dronecan.github.io/Specification/"
DSDL = "https://dronecan.github.io/Specification/7._List_of_standard_data_types/#"
NODE_PAGE = SPECIFICATION + "6._Application_level_functions/"
TRANSPORT_PAGE = SPECIFICATION + "4._CAN_bus_transport_layer/"
ANSWER_US = 1_000_000
OBSERVATION_US = 5_500_000
SILENCE_US = 3_000_000  # NodeStatus.OFFLINE_TIMEOUT_MS
STEP_US = 10_000
PARAMETERS_MAX = 8192

protocol = uavcan.protocol
Status = protocol.NodeStatus


@dataclass(frozen=True)
class Heard:
    time_us: int
    transfer: Transfer

    @property
    def message(self) -> Any:
        return self.transfer.message


class DronecanBench(Transcript):
    """Talks to one node."""

    def __init__(self, node: DronecanNode, number: int, pacer: Pacer) -> None:
        super().__init__(pacer, SILENCE_US)
        self.node = node
        self.number = number
        self.parameters: dict[str, Any] | None = None
        self.repeated = ""  # a parameter that is listed twice
        self._observation: list[Heard] | None = None
        self._fresh: list[Heard] = []
        node.monitors.append(self._on_transfer)

    def close(self) -> None:
        self.node.monitors.remove(self._on_transfer)

    def _on_transfer(self, transfer: Transfer) -> None:
        if transfer.header.source != self.number:
            return
        self.heard_us = self.now()
        self._fresh.append(Heard(self.now(), transfer))
        if transfer.kind is not Status:
            self.note(f"← {_text(transfer.message)}")

    def listen(self, us: int, until: Callable[[Heard], bool] | None = None) -> list[Heard]:
        """What comes from the node within `us`, or up to the first for which `until` holds."""
        end = self.now() + us
        came: list[Heard] = []
        while True:
            self.pacer.pump(max(0, min(end - self.now(), STEP_US)))
            fresh, self._fresh = self._fresh, []
            came += fresh
            if self.now() >= end or (until is not None and any(map(until, fresh))):
                return came

    def observation(self) -> list[Heard]:
        """What the node says when nobody asks, over OBSERVATION_US."""
        if self._observation is None:
            self.note(f"  listens for {OBSERVATION_US / 1e6:g} s")
            self.listen(0)
            self._observation = self.listen(OBSERVATION_US)
        return self._observation

    def statuses(self) -> list[Heard]:
        found = [h for h in self.observation() if h.transfer.kind is Status]
        expect(bool(found), f"no NodeStatus within {OBSERVATION_US / 1e6:g} s")
        return found

    def status(self) -> Any:
        self.listen(0)
        came = self.listen(2_500_000, lambda h: h.transfer.kind is Status)
        found = [h.message for h in came if h.transfer.kind is Status]
        expect(bool(found), "no NodeStatus within 2.5 s")
        return found[-1]

    def ask(self, message: Any) -> Any:
        """The response; None: none came within a second."""
        self.note(f"→ {_text(message)}")
        try:
            return self.node.ask(message, self.number, self.pacer, ANSWER_US)
        except SilentError:
            self.note("  no answer within 1 s")
            return None

    def info(self) -> Any:
        answer = self.ask(protocol.GetNodeInfo.Request())
        expect(answer is not None, "no answer to GetNodeInfo within 1 s")
        return answer

    def get_set(self, *, index: int = 0, name: str = "", value: Any = None) -> Any:
        request = protocol.param.GetSet.Request(index=index)
        if name:
            request.name.encode(name)
        if value is not None:
            request.value = value
        return self.ask(request)

    def all_parameters(self) -> dict[str, Any]:
        """By name; NotOffered: it has none."""
        if self.parameters is None:
            found: dict[str, Any] = {}
            for index in range(PARAMETERS_MAX):
                answer = self.get_set(index=index)
                if answer is None and not found:
                    raise NotOffered("it does not answer param.GetSet")
                expect(answer is not None, f"no answer to param.GetSet({index}) within 1 s")
                name = str(answer.name)
                if not name:
                    break
                self.repeated = name if name in found else self.repeated
                found.setdefault(name, answer)
            self.parameters = found
        if not self.parameters:
            raise NotOffered("it has no parameters")
        return self.parameters


def _text(message: Any) -> str:
    return f"{type(message).__name__} {json_line(fields_of(message))}"[:300]


# --- the node ---------------------------------------------------------------------------------
group("DN", "A DroneCAN node")
STATUS_PAGE = DSDL + "nodestatus"


Check = Callable[[DronecanBench], None]


def node_requirement(
    id: str, level: Level, title: str, clause: str, page: str
) -> Callable[[Check], Check]:
    return requirement(id, level, title, clause, page, "dronecan")


@node_requirement("DN-1", Level.MUST, "says all the time that it is there",
                  "protocol.NodeStatus.MAX_BROADCASTING_PERIOD_MS", STATUS_PAGE)  # fmt: skip
def constant(bench: DronecanBench) -> None:
    """NodeStatus at least once a second; after three it counts as offline. Listens for 5.5 s: no
    gap of more than 1.2 s."""
    times = [h.time_us for h in bench.statuses()]
    gaps = [b - a for a, b in zip(times, times[1:], strict=False)]
    expect(len(times) >= 4, f"{len(times)} in {OBSERVATION_US / 1e6:g} s")
    expect(max(gaps) <= 1_200_000, f"a gap of {max(gaps) / 1e6:.2f} s")


@node_requirement("DN-2", Level.MUST, "counts the seconds since it started",
                  "protocol.NodeStatus.uptime_sec", STATUS_PAGE)  # fmt: skip
def uptime(bench: DronecanBench) -> None:
    """From the first to the last NodeStatus, uptime_sec has grown by as many seconds."""
    first, last = bench.statuses()[0], bench.statuses()[-1]
    grown = int(last.message.uptime_sec) - int(first.message.uptime_sec)
    passed = (last.time_us - first.time_us) / 1e6
    expect(abs(grown - passed) <= 1.1, f"{grown} more after {passed:.1f} s")


@node_requirement("DN-3", Level.MUST, "is in a mode that is defined",
                  "protocol.NodeStatus.mode", STATUS_PAGE)  # fmt: skip
def mode(bench: DronecanBench) -> None:
    """OPERATIONAL 0, INITIALIZATION 1, MAINTENANCE 2, SOFTWARE_UPDATE 3 or OFFLINE 7; 4 to 6 are
    reserved."""
    modes = {int(h.message.mode) for h in bench.statuses()}
    expect(modes <= {0, 1, 2, 3, 7}, f"mode {sorted(modes)}")


@node_requirement("DN-4", Level.SHOULD, "is ready for work", "protocol.NodeStatus", STATUS_PAGE)
def ready(bench: DronecanBench) -> None:
    """Health OK and mode OPERATIONAL: autopilots refuse to arm while a node has another."""
    last = bench.statuses()[-1].message
    expect((last.health, last.mode) == (0, 0), f"health {last.health}, mode {last.mode}")


@node_requirement("DN-5", Level.MUST, "counts its transfers", "Transfer ID", TRANSPORT_PAGE)
def transfer_ids(bench: DronecanBench) -> None:
    """Each NodeStatus has the transfer id after the last one's, 0 after 31: receivers drop what
    seems to be repeated."""
    ids = [h.transfer.transfer_id for h in bench.statuses()]
    wrong = [(a, b) for a, b in zip(ids, ids[1:], strict=False) if b != (a + 1) % 32]
    expect(not wrong, f"{wrong[:1]} follow each other")


@node_requirement("DN-6", Level.MUST, "tells who it is", "Node info", NODE_PAGE + "#node-info")
def tells_who(bench: DronecanBench) -> None:
    """Every node answers protocol.GetNodeInfo; within a second, which is the default time-out. It
    says the same of its state as its NodeStatus."""
    info, now = bench.info(), bench.status()
    expect(abs(int(info.status.uptime_sec) - int(now.uptime_sec)) <= 3,
           f"up {info.status.uptime_sec} s there, {now.uptime_sec} s in NodeStatus")  # fmt: skip
    expect(info.status.mode == now.mode, f"mode {info.status.mode}, {now.mode} in NodeStatus")


@node_requirement("DN-7", Level.MUST, "has a name", "protocol.GetNodeInfo.name",
                  DSDL + "getnodeinfo")  # fmt: skip
def name(bench: DronecanBench) -> None:
    """Not empty, of a-z, 0-9, '_', '-' and '.'."""
    text = str(bench.info().name)
    expect(re.fullmatch(r"[a-z0-9_\-.]+", text) is not None, f"its name is {text!r}")


@node_requirement("DN-8", Level.MUST, "has an id of its own",
                  "protocol.HardwareVersion.unique_id", DSDL + "hardwareversion")  # fmt: skip
def unique_id(bench: DronecanBench) -> None:
    """16 bytes that no other node has; all zeros is no valid one. Asked twice: the same."""
    first, again = (bytes(list(bench.info().hardware_version.unique_id)) for _ in range(2))
    expect(any(first), "all zeros")
    expect(first == again, f"{first.hex()}, then {again.hex()}")


@node_requirement("DN-9", Level.MUST, "leaves requests to others alone",
                  "Service: destination node ID", TRANSPORT_PAGE)  # fmt: skip
def others(bench: DronecanBench) -> None:
    """GetNodeInfo to another node's id: it is silent."""
    other = next(n for n in (33, 34, 35) if n not in (bench.number, bench.node.node_id))
    bench.note(f"→ GetNodeInfo to {other}")
    bench.listen(0)
    bench.node.request(protocol.GetNodeInfo.Request(), other, lambda _: None)
    came = bench.listen(ANSWER_US, lambda h: h.transfer.header.is_service)
    expect(not any(h.transfer.header.is_service for h in came), "it answered")


@node_requirement("DN-10", Level.MUST, "does not restart without the magic number",
                  "protocol.RestartNode.MAGIC_NUMBER", DSDL + "restartnode")  # fmt: skip
def no_restart(bench: DronecanBench) -> None:
    """RestartNode with 0: refused, or no answer, and uptime goes on."""
    before = int(bench.status().uptime_sec)
    answer = bench.ask(protocol.RestartNode.Request(magic_number=0))
    expect(answer is None or not answer.ok, "ok")
    after = int(bench.status().uptime_sec)
    expect(after >= before, f"up {before} s before, {after} s after")


@node_requirement("DN-11", Level.MUST, "is well after half a transfer",
                  "Transfer reception", TRANSPORT_PAGE)  # fmt: skip
def half_transfer(bench: DronecanBench) -> None:
    """The first frame of a long request, and nothing after it; then GetNodeInfo is answered."""
    port, own = bench.node.port, bench.node.node_id
    identifier = 20 << 24 | 11 << 16 | 0x8000 | bench.number << 8 | 0x80 | own
    bench.note("→ the first of several frames of param.GetSet")
    port.send(identifier, bytes([1, 2, 3, 4, 5, 6, 7, 0x80 | 9]), False)
    bench.info()


# --- its parameters -------------------------------------------------------------------------------
group("DP", "DroneCAN parameters, if it has any")
PARAM_PAGE = DSDL + "getset"


@node_requirement("DP-1", Level.MUST, "lists its parameters by index",
                  "protocol.param.GetSet", PARAM_PAGE)  # fmt: skip
def listed(bench: DronecanBench) -> None:
    """From 0 on, up to an answer without a name; no name comes twice, and each has a value."""
    for key, answer in bench.all_parameters().items():
        expect(_value(answer.value)[0] != "empty", f"{key} has no value")
    expect(not bench.repeated, f"{bench.repeated} is there twice")


@node_requirement("DP-2", Level.MUST, "tells a parameter by its name",
                  "protocol.param.GetSet.name", PARAM_PAGE)  # fmt: skip
def by_name(bench: DronecanBench) -> None:
    """The name is preferred over the index. The last one by its name, with index 0: it is that."""
    key, value = list(bench.all_parameters().items())[-1]
    answer = bench.get_set(name=key)
    expect(answer is not None, f"no answer about {key}")
    expect(str(answer.name) == key, f"asked for {key}, it tells {answer.name}")
    same = _value(answer.value) == _value(value.value)
    expect(same, f"{key} has another value than by index")


@node_requirement("DP-3", Level.MUST, "says what it does not know",
                  "protocol.param.GetSet: empty name", PARAM_PAGE)  # fmt: skip
def unknown(bench: DronecanBench) -> None:
    """A name that there is not: an answer without a name, and without a value."""
    bench.all_parameters()
    answer = bench.get_set(name="NO_SUCH_PARAM_X")
    expect(answer is not None, "no answer")
    expect(not str(answer.name), f"it tells {answer.name}")


@node_requirement("DP-4", Level.MUST, "has values within their limits",
                  "protocol.param.GetSet: min_value, max_value", PARAM_PAGE)  # fmt: skip
def limits(bench: DronecanBench) -> None:
    """Each number is between min_value and max_value, where there are such."""
    for key, answer in bench.all_parameters().items():
        value, low, high = (_number(getattr(answer, part)) for part in
                            ("value", "min_value", "max_value"))  # fmt: skip
        if value is not None:
            expect(low is None or low <= value, f"{key} is {value}, at least {low}")
            expect(high is None or value <= high, f"{key} is {value}, at most {high}")


@node_requirement("DP-5", Level.MUST, "answers what is set with what it then is",
                  "protocol.param.GetSet", PARAM_PAGE)  # fmt: skip
def written(bench: DronecanBench) -> None:
    """The first one, set to the value that it has: name and value come back."""
    key, before = next(iter(bench.all_parameters().items()))
    answer = bench.get_set(name=key, value=before.value)
    expect(answer is not None, f"no answer about {key}")
    expect(str(answer.name) == key, f"set {key}, it tells {answer.name!s}")
    expect(_value(answer.value) == _value(before.value), f"{key} is another value then")


def _value(union: Any) -> tuple[str, Any]:
    """Which kind of value it is, and the value."""
    kind = transport.get_active_union_field(union) or "empty"
    return kind, fields_of(union)[kind]


def _number(union: Any) -> float | None:
    found = _value(union)[1]
    return float(found) if isinstance(found, int | float) else None


# --- its hardpoint --------------------------------------------------------------------------------
group("DH", "A lamp that is a DroneCAN hardpoint, if it is one")
hardpoint = uavcan.equipment.hardpoint
HARDPOINT_PAGE = DSDL + "hardpoint"


def its_hardpoint(bench: DronecanBench) -> int:
    ids = [int(h.message.hardpoint_id) for h in bench.observation()
           if h.transfer.kind is hardpoint.Status]  # fmt: skip
    if not ids:
        raise NotOffered("it sends no hardpoint.Status")
    return ids[-1]


def commanded(bench: DronecanBench, number: int, command: int) -> Any:
    """The last hardpoint.Status within two seconds of the command."""
    message = hardpoint.Command(hardpoint_id=number, command=command)
    bench.note(f"→ {_text(message)}")
    bench.listen(0)
    bench.node.broadcast(message)
    came = [h for h in bench.listen(2_200_000) if h.transfer.kind is hardpoint.Status]
    expect(bool(came), "no hardpoint.Status within 2.2 s")
    return came[-1].message


@node_requirement("DH-1", Level.MUST, "is switched on and off, and says so",
                  "equipment.hardpoint.Command, Status", HARDPOINT_PAGE)  # fmt: skip
def switched(bench: DronecanBench) -> None:
    """Command 1, then 0: Status is 1, then 0."""
    number = its_hardpoint(bench)
    for command in (1, 0):
        status = int(commanded(bench, number, command).status)
        expect((status != 0) == (command != 0), f"command {command}: status {status}")


@node_requirement("DH-2", Level.MUST, "leaves others' hardpoints alone",
                  "equipment.hardpoint.Command.hardpoint_id", HARDPOINT_PAGE)  # fmt: skip
def others_hardpoint(bench: DronecanBench) -> None:
    """Off; then command 1 to another hardpoint_id: Status stays 0."""
    number = its_hardpoint(bench)
    commanded(bench, number, 0)
    expect(int(commanded(bench, (number + 7) % 255, 1).status) == 0, "it is on")


# --- running --------------------------------------------------------------------------------------
def check_node(
    node: DronecanNode,
    number: int,
    pacer: Pacer,
    requirements: Iterable[Requirement] = PROFILES["dronecan"],
    *,
    on_result: Callable[[Result], None] = lambda _: None,
) -> Report:
    """Runs them on that node; its hardpoint is then off. SilentError: it is not there."""
    bench = DronecanBench(node, number, pacer)
    try:
        if not bench.listen(SILENCE_US, lambda _: True):
            raise SilentError(f"node {number} was not heard within {SILENCE_US / 1e6:g} s")
        report = Report(str(node.port), device=f"node {number}")
        try:
            for chosen in requirements:
                result = run_one(bench, chosen, report)
                report.results.append(result)
                on_result(result)
            answer = bench.ask(protocol.GetNodeInfo.Request())
            report.maker = str(answer.name) if answer else ""
        finally:
            for heard in bench.observation():
                if heard.transfer.kind is hardpoint.Status:
                    number = int(heard.message.hardpoint_id)
                    node.broadcast(hardpoint.Command(hardpoint_id=number, command=0))
                    bench.listen(100_000)
                    break
    finally:
        bench.close()
    return report
