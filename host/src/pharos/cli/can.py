# SPDX-License-Identifier: Apache-2.0
"""`pharos can`: what goes over a CAN bus, who is on it, and a light without MAVLink."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import can
from dronecan import transport, uavcan

from ..can_node import CanPort, DronecanNode, fields_of, open_bus
from ..can_transfer import Transfer
from ..connection import MavlinkConnection
from ..dialect import load_dialect
from ..errors import PharosError, SilentError, UsageError
from ..light import Light
from ..link import Pacer, RealPacer
from ..text import json_line
from ..tunnel import TunnelLink
from .shell import Printer

HEALTH = {0: "ok", 1: "warning", 2: "error", 3: "critical"}
MODE = {0: "operational", 1: "initialization", 2: "maintenance", 3: "software update", 7: "offline"}
# A command without an acknowledgement is repeated, as autopilots do.
REPEAT_US = 200_000
# hardpoint.Status comes at once when the lamp is switched, else each second.
CONFIRM_US = 2_500_000


def open_port(text: str, fd: bool) -> CanPort:
    """BUS of the command line: INTERFACE or INTERFACE/CHANNEL."""
    interface, _, channel = text.partition("/")
    return CanPort(open_bus(interface, channel, fd=fd))


# --- monitor --------------------------------------------------------------------------------------
class Monitor:
    """Prints transfers, and frames if asked for. Sends nothing."""

    def __init__(self, node: DronecanNode, printer: Printer, frames: bool, only: str = "") -> None:
        self._node = node
        self._printer = printer
        self._only = only.lower()
        self._start_us = node.clock()
        self.shown = 0
        node.monitors.append(self._on_transfer)
        if frames:
            node.port.listeners.append(self._on_frame)

    def _now_s(self) -> float:
        return (self._node.clock() - self._start_us) / 1e6

    def _on_frame(self, message: can.Message) -> None:
        identifier = (
            f"{message.arbitration_id:08X}"
            if message.is_extended_id
            else (f"{message.arbitration_id:03X}")
        )
        kind = "FD" if message.is_fd else "  "
        text = f"{self._now_s():10.6f}  {identifier:>8} {kind} {bytes(message.data).hex(' ')}"
        self._printer.fields(
            text,
            time=round(self._now_s(), 6),
            id=message.arbitration_id,
            extended=message.is_extended_id,
            fd=message.is_fd,
            data=bytes(message.data).hex(),
        )

    def _on_transfer(self, transfer: Transfer) -> None:
        header = transfer.header
        name = transfer.kind.full_name.removeprefix("uavcan.")
        if self._only not in name.lower():
            return
        self.shown += 1
        fields = fields_of(transfer.message)
        to, suffix = "all", ""
        if header.destination is not None:
            to, suffix = str(header.destination), "?" if header.is_request else "!"
        text = (
            f"{self._now_s():10.6f}  {header.source or 'anonymous'} → {to}  {name}{suffix}  "
            f"{json_line(fields)}"
        )
        self._printer.fields(
            text,
            time=round(self._now_s(), 6),
            type=transfer.kind.full_name,
            source=header.source,
            destination=header.destination,
            request=header.is_request if header.is_service else None,
            priority=header.priority,
            transfer_id=transfer.transfer_id,
            fd=transfer.fd,
            fields=fields,
        )


def run_monitor(args: argparse.Namespace, printer: Printer) -> None:
    port = open_port(args.bus, True if args.fd is None else args.fd)
    pacer = RealPacer([port])
    node = DronecanNode(port, pacer.now_us, 0)
    monitor = Monitor(node, printer, args.frames, args.only)
    end = None if args.seconds is None else time.monotonic() + args.seconds
    while args.count is None or monitor.shown < args.count:
        left = 1.0 if end is None else end - time.monotonic()
        if left <= 0:
            break
        pacer.pump(round(min(left, 1.0) * 1e6))
    port.close()


# --- nodes ----------------------------------------------------------------------------------------
@dataclass
class Seen:
    """One node, and what it says about itself."""

    node: int
    status: Any
    info: Any = None
    heard_us: int = 0
    is_clash: bool = False  # another node has the same id

    def unique_id(self) -> bytes | None:
        return None if self.info is None else bytes(list(self.info.hardware_version.unique_id))

    def may_say(self, uptime_s: int, now_us: int) -> bool:
        """Whether its next NodeStatus could have that uptime."""
        expected_s = int(self.status.uptime_sec) + (now_us - self.heard_us) / 1e6
        return abs(uptime_s - expected_s) < 2

    def as_fields(self) -> dict[str, Any]:
        status, info = self.status, self.info
        fields = {
            "node": self.node,
            "health": HEALTH.get(int(status.health), str(status.health)),
            "mode": MODE.get(int(status.mode), str(status.mode)),
            "uptime_s": int(status.uptime_sec),
            "vendor_code": int(status.vendor_specific_status_code),
            "clash": self.is_clash,
        }
        if info is None:
            return fields | {"name": None}
        software, hardware = info.software_version, info.hardware_version
        has_commit = software.optional_field_flags & software.OPTIONAL_FIELD_FLAG_VCS_COMMIT
        return fields | {
            "name": str(info.name),
            "software": f"{software.major}.{software.minor}",
            "commit": f"{software.vcs_commit:08x}" if has_commit else None,
            "hardware": f"{hardware.major}.{hardware.minor}",
            "unique_id": (self.unique_id() or b"").hex(),
        }

    def __str__(self) -> str:
        fields = self.as_fields()
        versions = "no answer to GetNodeInfo"
        if self.info is not None:
            commit = f" ({fields['commit']})" if fields["commit"] else ""
            versions = f"software {fields['software']}{commit}, hardware {fields['hardware']}"
        code = f", code {fields['vendor_code']}" if fields["vendor_code"] else ""
        clash = f"; node id {self.node} is used twice" if self.is_clash else ""
        if self.is_clash and self.info is not None:
            clash += f", here by {fields['unique_id']}"
        return (
            f"{self.node:>3}  {fields['name'] or '?':<28} {fields['health']}, {fields['mode']}"
            f"{code}, up {fields['uptime_s']} s, {versions}{clash}"
        )


class Census:
    """Every node heard, with its answer to GetNodeInfo. Two that have one id are told apart by
    their uptimes, and by their unique ids."""

    def __init__(self, node: DronecanNode) -> None:
        self._node = node
        self._seen: dict[int, list[Seen]] = {}
        node.monitors.append(self._on_transfer)

    def found(self) -> list[Seen]:
        return [entry for number in sorted(self._seen) for entry in self._seen[number]]

    def _on_transfer(self, transfer: Transfer) -> None:
        source = transfer.header.source
        if transfer.kind is uavcan.protocol.NodeStatus and source:
            self._on_status(source, transfer.message)
        elif transfer.kind is uavcan.protocol.GetNodeInfo and not transfer.header.is_request:
            self._on_info(source, transfer.message)

    def _add(self, entry: Seen) -> None:
        entries = self._seen.setdefault(entry.node, [])
        entries.append(entry)
        for each in entries:
            each.is_clash = len(entries) > 1

    def _on_status(self, source: int, status: Any) -> None:
        now_us = self._node.clock()
        uptime_s = int(status.uptime_sec)
        for entry in self._seen.get(source, []):
            if entry.may_say(uptime_s, now_us):
                entry.status, entry.heard_us = status, now_us
                break
        else:
            self._add(Seen(source, status, heard_us=now_us))
        # NodeStatus comes at 1 Hz: a lost question is asked again, and who has the same id may
        # answer the next one.
        if self._node.node_id:
            request = uavcan.protocol.GetNodeInfo.Request()
            self._node.request(request, source, lambda _info: None)

    def _on_info(self, source: int, info: Any) -> None:
        """An answer carries its node's status, hence its uptime."""
        entry = Seen(source, info.status, info, self._node.clock())
        entries = self._seen.get(source, [])
        uptime_s = int(info.status.uptime_sec)
        unnamed = next(
            (e for e in entries if e.info is None and e.may_say(uptime_s, entry.heard_us)), None
        )
        known = next((e for e in entries if e.unique_id() == entry.unique_id()), None)
        if unnamed is None:
            if known is None:
                self._add(entry)
        elif known is None:
            unnamed.info = info
        else:  # it was reset meanwhile
            entries.remove(unnamed)
            known.status, known.heard_us = info.status, entry.heard_us
            known.is_clash = len(entries) > 1


def find_nodes(node: DronecanNode, pacer: Pacer, timeout_us: int) -> list[Seen]:
    """Every node heard within the time."""
    census = Census(node)
    end = node.clock() + timeout_us
    while (left := end - node.clock()) > 0:
        pacer.pump(min(left, 100_000))
    return census.found()


def run_nodes(args: argparse.Namespace, printer: Printer) -> None:
    port = open_port(args.bus, bool(args.fd))
    pacer = RealPacer([port])
    found = find_nodes(DronecanNode(port, pacer.now_us, args.own), pacer, round(args.seconds * 1e6))
    port.close()
    if not found:
        raise SilentError(f"{port}: no node was heard within {args.seconds:g} s")
    for entry in found:
        printer.fields(str(entry), **entry.as_fields())


# --- light ----------------------------------------------------------------------------------------
def lights_command(light_id: int, ratio: float) -> Any:
    """White of that brightness, 0 … 1, in RGB565."""
    light = uavcan.equipment.indication.SingleLightCommand(light_id=light_id)
    light.color.red = round(ratio * 31)
    light.color.green = round(ratio * 63)
    light.color.blue = round(ratio * 31)
    return uavcan.equipment.indication.LightsCommand(commands=[light])


def hardpoint_command(hardpoint_id: int, on: bool) -> Any:
    return uavcan.equipment.hardpoint.Command(hardpoint_id=hardpoint_id, command=int(on))


def actuator_command(actuator_id: int, ratio: float) -> Any:
    """Brightness 0 … 1 as a servo's unitless position, −1 … 1."""
    command = uavcan.equipment.actuator.Command(
        actuator_id=actuator_id, command_type=0, command_value=2 * ratio - 1
    )
    return uavcan.equipment.actuator.ArrayCommand(commands=[command])


def light_message(args: argparse.Namespace) -> Any:
    """What to broadcast for `pharos can light`. UsageError: that way can't say that."""
    ratio = {"on": 1.0, "off": 0.0}.get(args.action)
    if ratio is None:
        ratio = args.percent / 100
    if args.via == "hardpoint":
        if args.action == "brightness":
            raise UsageError("a hardpoint is on or off; use --via lights, actuator or tunnel")
        return hardpoint_command(args.id if args.id is not None else 0, ratio > 0)
    if args.via == "actuator":
        return actuator_command(args.id if args.id is not None else 9, ratio)
    return lights_command(args.id if args.id is not None else 254, ratio)


def run_light(args: argparse.Namespace, printer: Printer) -> None:
    if (args.action == "brightness") != (args.percent is not None):
        raise UsageError("can light: usage: on, off, or brightness PERCENT")
    if args.percent is not None and not 0 <= args.percent <= 100:
        raise UsageError(f"brightness {args.percent:g} is not within 0 … 100 %")
    if args.via == "tunnel" and args.node is None:
        raise UsageError("--via tunnel needs --node N; `pharos can nodes` lists the nodes")
    message = None if args.via == "tunnel" else light_message(args)
    port = open_port(args.bus, bool(args.fd))
    pacer = RealPacer([port])
    node = DronecanNode(port, pacer.now_us, args.own, fd=bool(args.fd))
    try:
        if message is None:
            through_tunnel(args, node, pacer, printer)
        else:
            broadcast(args, node, pacer, message, printer)
    finally:
        port.close()


def through_tunnel(
    args: argparse.Namespace, node: DronecanNode, pacer: Pacer, printer: Printer
) -> None:
    link = TunnelLink(node, args.node)
    light = Light(MavlinkConnection(link, pacer, load_dialect()))
    light.find()
    act: dict[str, Callable[[], None]] = {
        "on": light.on,
        "off": light.off,
        "brightness": lambda: light.set_brightness(args.percent),
    }
    act[args.action]()
    printer.fields("ok", command=args.action, ok=True, node=args.node)


def broadcast(
    args: argparse.Namespace, node: DronecanNode, pacer: Pacer, message: Any, printer: Printer
) -> None:
    """Sends, repeats, and waits for the light's hardpoint.Status that agrees."""
    wanted_on = args.action == "on" or bool(args.percent)
    answers: dict[int, bool] = {}

    def on_status(transfer: Transfer) -> None:
        if args.node is None or transfer.header.source == args.node:
            answers[transfer.header.source] = bool(transfer.message.status)

    node.subscribe(uavcan.equipment.hardpoint.Status, on_status)
    end = node.clock() + CONFIRM_US
    while wanted_on not in answers.values():
        left = end - node.clock()
        if left <= 0:
            break
        node.broadcast(message)
        again = min(node.clock() + REPEAT_US, end)
        while wanted_on not in answers.values() and (left := again - node.clock()) > 0:
            pacer.pump(left)
    if not answers:
        raise SilentError(f"{node.port}: sent, but no light says hardpoint.Status")
    agreeing = [number for number, on in sorted(answers.items()) if on == wanted_on]
    if not agreeing:
        state = "off" if wanted_on else "on"
        who = ", ".join(map(str, sorted(answers)))
        raise PharosError(f"node {who} stays {state}")
    state = "on" if wanted_on else "off"
    name = transport.get_dronecan_data_type(message).full_name
    text = [f"node {number} is {state}" for number in agreeing]
    printer.fields(text, command=args.action, ok=True, type=name, nodes=agreeing, on=wanted_on)
