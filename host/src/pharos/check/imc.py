# SPDX-License-Identifier: Apache-2.0
"""The profile of a light that is an IMC node: what IMC's definitions say is right of packets, of a
node with entities, and of an LED that has a name."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from ..errors import SilentError
from ..imc import EVERYONE, ImcPeer, Packet, encode
from ..imc.codec import checksum
from ..link import Pacer
from .run import Report, Result, run_one
from .spec import PROFILES, Level, NotOffered, Requirement, expect, group, requirement
from .transcript import Transcript

IMC = "https://www.lsts.pt/docs/imc/"
HEADER_PAGE, CORE_PAGE, ACTUATION_PAGE = IMC + "#header", IMC + "#core", IMC + "#actuation"
ANSWER_US = 1_000_000
OBSERVATION_US = 5_500_000
SILENCE_US = 6_000_000
STEP_US = 10_000
DIM = 13  # of 255: 5 %
QUERY, REPORT = 1, 0  # EntityList.op
STATES = range(5)  # EntityState.state
OTHER_NODE = 0x4321


@dataclass(frozen=True)
class Heard:
    time_us: int
    packet: Packet


class ImcBench(Transcript):
    """Talks to one node. led: what its LED is called."""

    def __init__(self, peer: ImcPeer, pacer: Pacer, led: str) -> None:
        super().__init__(pacer, SILENCE_US)
        self.peer = peer
        self.led = led
        self._observation: list[Heard] | None = None
        self._beat_us = -1

    def note(self, text: str) -> None:
        super().note(text[:300])

    def send_raw(self, data: bytes, what: str) -> None:
        self.note(f"→ {what}")
        self.peer.link.send(data)

    def send(self, name: str, /, **fields: Any) -> None:
        packet = self.peer.packet(name, **fields)
        self.send_raw(self.peer.encode(packet), _text(packet))

    def listen(self, us: int, until: Callable[[Heard], bool] | None = None) -> list[Heard]:
        """What comes from the node within `us`, or up to the first for which `until` holds."""
        end = self.now() + us
        came: list[Heard] = []
        while True:
            self._beat()
            fresh = []
            for packet in self.peer.pass_time(max(0, min(end - self.now(), STEP_US))):
                if packet.src == self.peer.light:
                    self.heard_us = self.now()
                    fresh.append(Heard(self.now(), packet))
                    if packet.name not in ("Heartbeat", "Announce"):
                        self.note(f"← {_text(packet)}")
            came += fresh
            if self.now() >= end or (until is not None and any(map(until, fresh))):
                return came

    def _beat(self) -> None:
        """A node sends to those that it has heard."""
        if self.peer.link.can_send() and self.now() - self._beat_us >= 1_000_000:
            self._beat_us = self.now()
            self.peer.send("Heartbeat", dst=EVERYONE)

    def observation(self) -> list[Heard]:
        if self._observation is None:
            self.note(f"  listens for {OBSERVATION_US / 1e6:g} s")
            self.listen(0)
            self._observation = self.listen(OBSERVATION_US)
        return self._observation

    def ask(self, name: str, answer: str, /, **fields: Any) -> Packet | None:
        """The first packet of that name within a second; None: none came."""
        self.listen(0)
        self.send(name, **fields)
        came = self.listen(ANSWER_US, lambda h: h.packet.name == answer)
        return next((h.packet for h in came if h.packet.name == answer), None)

    def brightness(self) -> Packet:
        """NotOffered: there is no LED of that name."""
        answer = self.ask("QueryLedBrightness", "LedBrightness", name=self.led)
        if answer is None:
            raise NotOffered(f"it has no LED of the name '{self.led}': --led NAME")
        return answer

    def value(self) -> int:
        return int(self.brightness().message["value"])

    def entities(self) -> dict[str, int]:
        """Their numbers by name."""
        answer = self.ask("EntityList", "EntityList", op=QUERY)
        expect(answer is not None, "no EntityList within 1 s")
        assert answer is not None
        found: dict[str, int] = {}
        for item in _string(answer.message["list"]).split(";"):
            name, equals, number = item.partition("=")
            if item:
                expect(bool(equals) and number.isdecimal(), f"'{item}' is no NAME=ID")
                found[name] = int(number)
        expect(bool(found), "no entity")
        return found


def _string(value: Any) -> str:
    return value.decode(errors="backslashreplace") if isinstance(value, bytes) else str(value)


def _text(packet: Packet) -> str:
    fields = " ".join(f"{key}={value!r}" for key, value in packet.message.fields.items())
    return f"{packet.name} {fields}"


Check = Callable[[ImcBench], None]


def imc_requirement(
    id: str, level: Level, title: str, clause: str, page: str
) -> Callable[[Check], Check]:
    return requirement(id, level, title, clause, page, "imc")


# --- packets and presence -------------------------------------------------------------------------
group("IN", "An IMC node")


@imc_requirement("IN-1", Level.MUST, "says all the time that it is there", "Heartbeat", CORE_PAGE)
def constant(bench: ImcBench) -> None:
    """A Heartbeat a second, to whom it has heard. Listens for 5.5 s: at least 4, and no gap of more
    than 2.5 s."""
    times = [h.time_us for h in bench.observation() if h.packet.name == "Heartbeat"]
    expect(len(times) >= 4, f"{len(times)} Heartbeats in {OBSERVATION_US / 1e6:g} s")
    longest = max(b - a for a, b in zip(times, times[1:], strict=False))
    expect(longest <= 2_500_000, f"a gap of {longest / 1e6:.1f} s")


@imc_requirement("IN-2", Level.MUST, "has an address of its own", "Header: src", HEADER_PAGE)
def address(bench: ImcBench) -> None:
    """src is not 0xFFFF, which is everybody, nor 0, nor that of who asks."""
    expect(bench.peer.light not in (0, EVERYONE, bench.peer.id), f"src {bench.peer.light:#06x}")


@imc_requirement("IN-3", Level.MUST, "says when it said it", "Header: timestamp", HEADER_PAGE)
def timestamps(bench: ImcBench) -> None:
    """Seconds as a number, not negative, and never going back."""
    stamps = [h.packet.timestamp for h in bench.observation()]
    expect(all(map(math.isfinite, stamps)), "a timestamp that is no number")
    expect(min(stamps, default=0) >= 0, "a timestamp before 1970")
    expect(stamps == sorted(stamps), "timestamps go back")


@imc_requirement("IN-4", Level.MUST, "answers who asks", "Header: dst, dst_ent", HEADER_PAGE)
def answers_who_asks(bench: ImcBench) -> None:
    """EntityList: the answer's dst and dst_ent are the question's src and src_ent."""
    answer = bench.ask("EntityList", "EntityList", op=QUERY)
    expect(answer is not None, "no EntityList within 1 s")
    assert answer is not None
    seen, wanted = (answer.dst, answer.dst_ent), (bench.peer.id, bench.peer.entity)
    expect(seen == wanted, f"to {seen[0]:#06x}/{seen[1]}, asked by {wanted[0]:#06x}/{wanted[1]}")


@imc_requirement("IN-5", Level.MUST, "reads either byte order", "Header: sync", HEADER_PAGE)
def byte_order(bench: ImcBench) -> None:
    """The sync number tells the sender's byte order: EntityList in big endian is answered."""
    bench.listen(0)
    packet = bench.peer.packet("EntityList", op=QUERY)
    bench.send_raw(encode(packet, big_endian=True), f"{_text(packet)}, big endian")
    came = bench.listen(ANSWER_US, lambda h: h.packet.name == "EntityList")
    expect(any(h.packet.name == "EntityList" for h in came), "no answer within 1 s")


@imc_requirement("IN-6", Level.MUST, "does not believe damaged packets", "Footer: CRC", HEADER_PAGE)
def damaged(bench: ImcBench) -> None:
    """EntityList with a bit of its checksum wrong: silence."""
    bench.listen(0)
    data = bytearray(bench.peer.encode(bench.peer.packet("EntityList", op=QUERY)))
    data[-1] ^= 1
    bench.send_raw(bytes(data), "EntityList, its CRC wrong")
    came = bench.listen(ANSWER_US)
    expect(not any(h.packet.name == "EntityList" for h in came), "it answered")


@imc_requirement("IN-7", Level.MUST, "is well after what it does not know", "Header: mgid",
                 HEADER_PAGE)  # fmt: skip
def unknown(bench: ImcBench) -> None:
    """A packet of id 65000, which no message has, and half a packet; EntityList is answered."""
    data = bytearray(bench.peer.encode(bench.peer.packet("Heartbeat")))
    struct.pack_into("<H", data, 2, 65000)
    struct.pack_into("<H", data, len(data) - 2, checksum(bytes(data[:-2])))
    bench.send_raw(bytes(data), "a packet of id 65000")
    bench.send_raw(bytes(data[:11]), "half a packet")
    bench.entities()


# --- entities -------------------------------------------------------------------------------------
group("IE", "Its entities")


@imc_requirement("IE-1", Level.MUST, "lists its entities", "EntityList", CORE_PAGE)
def listed(bench: ImcBench) -> None:
    """Asked with op QUERY: a report, NAME=ID with ; between them, no id twice."""
    numbers = list(bench.entities().values())
    expect(len(set(numbers)) == len(numbers), f"ids {numbers}")


@imc_requirement("IE-2", Level.MUST, "describes each entity", "EntityInfo", CORE_PAGE)
def described(bench: ImcBench) -> None:
    """QueryEntityInfo to each entity of the list: EntityInfo with its id and its name."""
    for name, number in bench.entities().items():
        answer = bench.ask("QueryEntityInfo", "EntityInfo", dst_ent=number, id=number)
        expect(answer is not None, f"no EntityInfo of {name} within 1 s")
        assert answer is not None
        seen = (int(answer.message["id"]), _string(answer.message["label"]))
        expect(seen == (number, name), f"{seen[1]}={seen[0]}, listed as {name}={number}")


@imc_requirement("IE-3", Level.MUST, "says how its entities are", "EntityState", CORE_PAGE)
def states(bench: ImcBench) -> None:
    """QueryEntityState: EntityState, its state one of the five that are defined."""
    answer = bench.ask("QueryEntityState", "EntityState")
    expect(answer is not None, "no EntityState within 1 s")
    assert answer is not None
    expect(int(answer.message["state"]) in STATES, f"state {answer.message['state']}")


# --- the LED --------------------------------------------------------------------------------------
group("IL", "Its LED, if it has one of that name")


@imc_requirement("IL-1", Level.MUST, "says how bright it is", "QueryLedBrightness", ACTUATION_PAGE)
def says(bench: ImcBench) -> None:
    """LedBrightness with the name that was asked for."""
    name = _string(bench.brightness().message["name"])
    expect(name == bench.led, f"asked for '{bench.led}', it tells '{name}'")


@imc_requirement("IL-2", Level.MUST, "takes a brightness, and says so", "SetLedBrightness",
                 ACTUATION_PAGE)  # fmt: skip
def takes(bench: ImcBench) -> None:
    """13 (5 %), then 0: LedBrightness with that value follows, and is what a query then tells."""
    bench.brightness()
    for value in (DIM, 0):
        answer = bench.ask("SetLedBrightness", "LedBrightness", name=bench.led, value=value)
        expect(answer is not None, f"no LedBrightness after {value} was set")
        assert answer is not None
        expect(int(answer.message["value"]) == value, f"set {value}: {answer.message['value']}")
        expect(bench.value() == value, f"set {value}: asked, it tells {bench.value()}")


@imc_requirement("IL-3", Level.MUST, "leaves what is for others alone", "Header: dst", HEADER_PAGE)
def for_others(bench: ImcBench) -> None:
    """13, to another node: its own brightness stays 0."""
    bench.brightness()
    bench.send("SetLedBrightness", name=bench.led, value=0)
    bench.listen(ANSWER_US // 2)
    bench.send("SetLedBrightness", dst=OTHER_NODE, name=bench.led, value=DIM)
    bench.listen(ANSWER_US // 2)
    expect(bench.value() == 0, f"it is {bench.value()}")


@imc_requirement("IL-4", Level.MUST, "leaves other LEDs' names alone", "SetLedBrightness: name",
                 ACTUATION_PAGE)  # fmt: skip
def other_name(bench: ImcBench) -> None:
    """13 to "no such led": its own brightness stays 0, and nothing tells of such a one."""
    bench.brightness()
    bench.send("SetLedBrightness", name=bench.led, value=0)
    bench.listen(ANSWER_US // 2)
    answer = bench.ask("SetLedBrightness", "LedBrightness", name="no such led", value=DIM)
    told = answer is not None and _string(answer.message["name"]) == "no such led"
    expect(not told, "it says that it has it")
    expect(bench.value() == 0, f"it is {bench.value()}")


@imc_requirement("IL-5", Level.MUST, "does the same again", "SetLedBrightness", ACTUATION_PAGE)
def again(bench: ImcBench) -> None:
    """A packet may be lost, so it is sent again: 13 twice, each answered, and it is 13."""
    bench.brightness()
    for _ in range(2):
        answer = bench.ask("SetLedBrightness", "LedBrightness", name=bench.led, value=DIM)
        expect(answer is not None and int(answer.message["value"]) == DIM, "no answer of 13")
    expect(bench.value() == DIM, f"it is {bench.value()}")


# --- running --------------------------------------------------------------------------------------
def check_imc(
    peer: ImcPeer,
    pacer: Pacer,
    requirements: Iterable[Requirement] = PROFILES["imc"],
    *,
    led: str = "lamp",
    on_result: Callable[[Result], None] = lambda _: None,
) -> Report:
    """Runs them on the node at the other end of the peer's link; its LED is then as dark as it can
    be. SilentError: nothing came from there."""
    bench = ImcBench(peer, pacer, led)
    peer.light = _node(bench)
    report = Report(str(peer.link), device=f"node {peer.light:#06x}", maker="")
    try:
        for chosen in requirements:
            result = run_one(bench, chosen, report)
            report.results.append(result)
            on_result(result)
    finally:
        bench.send("SetLedBrightness", name=led, value=0)
        bench.listen(200_000)
    return report


def _node(bench: ImcBench) -> int:
    """Whoever speaks first."""
    end = bench.now() + SILENCE_US
    while bench.now() < end:
        bench._beat()
        for packet in bench.peer.pass_time(STEP_US):
            if packet.src != bench.peer.id:
                bench.heard_us = bench.now()
                return packet.src
    raise SilentError(f"{bench.peer.link}: no IMC node was heard within {SILENCE_US / 1e6:g} s")
