# SPDX-License-Identifier: Apache-2.0
"""`pharos check --profile imc` on right nodes and on nodes with one fault each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from checking import failing
from pharos import SilentError, Simulator
from pharos.check import Level, Report
from pharos.check.imc import check_imc
from pharos.check.spec import PROFILES
from pharos.imc import EVERYONE, ImcPeer, Packet, Stream, encode, message
from pharos.imc.codec import SYNC, checksum
from pharos.link import Link

NODE = 0x1234
ENTITIES = {"Daemon": 1, "Torch": 9}

FAULTS: dict[str, tuple[str, ...]] = {
    "two Heartbeats, then none": ("IN-1",),
    "calls itself 0": ("IN-2",),
    "timestamps go back": ("IN-3",),
    "answers everybody": ("IN-4",),
    "reads little endian only": ("IN-5",),
    "does not look at the CRC": ("IN-6",),
    "is deaf after an unknown id": ("IN-7", "IE-1", "IE-2", "IE-3"),
    "two entities of one id": ("IE-1", "IE-2"),
    "describes only one": ("IE-2",),
    "state 9": ("IE-3",),
    "has no state": ("IE-3",),
    "tells another name": ("IL-1",),
    "takes brightness without a word": ("IL-2", "IL-5"),
    "brightness in percent": ("IL-2", "IL-5"),
    "takes what is for others": ("IL-3",),
    "has any LED": ("IL-4",),
    "toggles": ("IL-5",),
}


class ModelNode(Link):
    """An IMC node with an LED, by the definitions; the link to it, and the clock of both."""

    def __init__(self, *faults: str) -> None:
        super().__init__()
        self.faults = set(faults)
        self.time_us = self.beat_us = self.beats = 0
        self.stream = Stream()
        self.deaf = False
        self.value = 0
        self.id = 0 if "calls itself 0" in faults else NODE
        self.asker = Packet(message("Heartbeat"))

    # --- the link and the clock ---------------------------------------------------------------
    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        pass

    def _read(self) -> bytes:
        return b""

    def _write(self, data: bytes) -> None:
        if "reads little endian only" in self.faults and data[:1] == b"\xfe":
            return
        if data[2:4] == b"\xe8\xfd" and "is deaf after an unknown id" in self.faults:
            self.deaf = True
        if "does not look at the CRC" in self.faults and len(data) > 20:
            order = "little" if data[0] == SYNC & 0xFF else "big"
            data = data[:-2] + checksum(data[:-2]).to_bytes(2, order)  # type: ignore[arg-type]
        for packet in self.stream.feed(data):
            if not self.deaf:
                self.obey(packet)

    def now_us(self) -> int:
        return self.time_us

    def pump(self, us: int) -> None:
        end = self.time_us + us
        while self.beat_us <= end:
            self.time_us = max(self.time_us, self.beat_us)
            self.beat_us += 1_000_000
            self.beats += 1
            if self.beats < 3 or "two Heartbeats, then none" not in self.faults:
                self.say("Heartbeat", to_all=True)
            else:
                self.say("Announce", to_all=True, sys_name="torch", services="")
        self.time_us = end

    def say(self, name: str, /, *, to_all: bool = False, **fields: Any) -> None:
        asker = self.asker
        stamp = self.time_us / 1e6
        if "timestamps go back" in self.faults:
            stamp = 1000 - stamp
        to_all = to_all or "answers everybody" in self.faults
        dst, entity = (EVERYONE, 255) if to_all else (asker.src, asker.src_ent)
        data = encode(Packet(message(name, **fields), self.id, 9, dst, entity, stamp))
        self.inbox.append(data)
        self.received += len(data)

    def __str__(self) -> str:
        return "model"

    # --- what it does -------------------------------------------------------------------------
    def obey(self, packet: Packet) -> None:
        is_for_us = packet.dst in (self.id, EVERYONE)
        if not is_for_us and "takes what is for others" not in self.faults:
            return
        self.asker = packet
        fields = packet.message.fields
        numbers = dict(ENTITIES)
        if "two entities of one id" in self.faults:
            numbers["Torch"] = 1
        if packet.name == "EntityList" and fields["op"] == 1:
            names = ";".join(f"{name}={number}" for name, number in numbers.items())
            self.say("EntityList", op=0, list=names)
        elif packet.name == "QueryEntityInfo":
            found = next((n for n, number in ENTITIES.items() if number == packet.dst_ent), None)
            if found and not (found == "Torch" and "describes only one" in self.faults):
                self.say("EntityInfo", id=packet.dst_ent, label=found)
        elif packet.name == "QueryEntityState" and "has no state" not in self.faults:
            self.say("EntityState", state=9 if "state 9" in self.faults else 1)
        elif packet.name in ("QueryLedBrightness", "SetLedBrightness"):
            self.led(packet.name, fields["name"].decode(), fields.get("value", 0))

    def led(self, name: str, led: str, value: int) -> None:
        if led != "lamp" and "has any LED" not in self.faults:
            return
        if name == "SetLedBrightness":
            if "brightness in percent" in self.faults:
                value = min(value, 100) * 100 // 255
            if "toggles" in self.faults and value == self.value:
                value = 0
            self.value = value
            if "takes brightness without a word" in self.faults:
                return
        told = "light" if "tells another name" in self.faults else led
        self.say("LedBrightness", name=told, value=self.value)


def report_of(*faults: str) -> Report:
    node = ModelNode(*faults)
    return check_imc(ImcPeer(node, node), node)


def test_a_right_node_passes() -> None:
    report = report_of()
    assert [(r.requirement.id, r.seen) for r in report.results if r.outcome != "passed"] == []
    assert report.device == "node 0x1234"


def test_our_light_passes(binary: Path) -> None:
    wires = {"uart1": "tcpin:127.0.0.1:0"}
    with Simulator(binary, wires, options=("--protocol", "imc")) as sim:
        sim.advance(s=2)
        report = check_imc(sim.imc("uart1"), sim)
        assert sim.outputs()["level_ppm"] == 0
    assert [(r.requirement.id, r.seen) for r in report.results if r.outcome != "passed"] == []


def test_an_led_of_another_name_is_not_asked_for() -> None:
    node = ModelNode()
    report = check_imc(ImcPeer(node, node), node, led="beacon")
    skipped = {r.requirement.group for r in report.results if r.outcome == "not offered"}
    assert (skipped, report.passed) == ({"IL"}, True)


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_found_by_the_must_that_it_breaks(fault: str) -> None:
    assert failing(report_of(fault), Level.MUST) == list(FAULTS[fault])


def test_each_must_has_a_fault() -> None:
    musts = {r.id for r in PROFILES["imc"] if r.level == Level.MUST}
    assert musts == {must for broken in FAULTS.values() for must in broken}


def test_who_is_not_there_is_said() -> None:
    node = ModelNode()
    node.beat_us = 1 << 60
    with pytest.raises(SilentError, match="no IMC node was heard"):
        check_imc(ImcPeer(node, node), node)
