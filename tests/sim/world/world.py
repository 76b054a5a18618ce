# SPDX-License-Identifier: Apache-2.0
"""One simulated world: real firmware in virtual time, a vehicle, stations, a bus, an attacker, heat
and faults, all from one plan; an oracle for each light watches."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dronecan import uavcan

from oracle import (
    ACCEPTED,
    DENIED,
    FLIGHT_US,
    UNSUPPORTED,
    Effect,
    Oracle,
    Sent,
    configured,
    is_in_range,
    nothing,
    turned,
)
from parties import CONFIGURE, KEY, ON_OFF, REQUEST_MESSAGE, STAMP, STATUS, Party
from pharos import Simulator, find_dialect, load_dialect
from plan import SECOND_US, Action, Plan

POLL_US = 250_000
RING_POLL_US = 50_000
HEAL_US = 5_000_000
HARDPOINT = 3
NODE = 10
REBOOT = 246  # MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN
REAL32 = 9  # MAV_PARAM_TYPE


@dataclass
class Outcome:
    """What a world's run found."""

    seed: int
    violations: list[str] = field(default_factory=list)
    simulated_us: int = 0
    events: int = 0
    faults: int = 0
    tally: Counter[str] = field(default_factory=Counter)


class Light:
    """One light of the world: its process, its wires, its oracle."""

    def __init__(self, world: World, number: int) -> None:
        self.world = world
        self.number = number
        self.system = 1 + number
        features = world.plan.features
        wires = {"uart0": "tcpin:127.0.0.1:0"}
        if "ring" in features:
            wires |= {"uart1": "tcpin:127.0.0.1:0", "uart2": "tcpin:127.0.0.1:0"}
        if "can" in features and number == 0:
            wires["can0"] = "udp:127.255.255.255:{port}"
        self.sim = Simulator(
            world.binary, wires, seed=world.plan.seed * 8 + number + 1, dialect=world.dialect
        )
        fallback = next((f for f in features if f.startswith("loss-")), "")
        self.oracle = Oracle(
            key="key" in features, restore="restore" in features, fallback=fallback
        )
        self.recorded: list[tuple[int, bytes]] = []
        self.is_silent = False

    @property
    def address(self) -> tuple[int, int]:
        return self.system, 243

    def start(self) -> None:
        self.sim.start()
        self.links = {
            name: self.sim.open(name)
            for name in self.sim.wires()
            if self.sim.wires()[name].address.startswith("tcpin")
        }
        self.decoder = self.world.dialect.MAVLink(None, 255, 190)
        self.decoder.robust_parsing = True
        self.node = (
            self.sim.node(NODE)
            if "can" in self.world.plan.features and (self.number == 0)
            else None
        )
        self.configure()

    # --- before the story begins --------------------------------------------------------------
    def configure(self) -> None:
        features = self.world.plan.features
        wanted = {"MAV_SYSID": self.system}
        if "restore" in features:
            wanted["LGT_RESTORE"] = 1
        if self.oracle.fallback:
            wanted |= {
                "LGT_LOSS": 5,
                "LGT_FALLBACK": 1 if self.oracle.fallback == "loss-off" else 2,
            }
        if "ring" in features:
            wanted["MAV_ROUTE"] = 1
        if "can" in features:
            wanted["CAN_HARDPT_ID"] = HARDPOINT
        if "exclusion" in features:
            wanted["LGT_SRC_EXCL"] = 2
        if "key" in features:
            wanted["MAV_SECURE"] = 1
        owner = Party(self.world.dialect, 255, 190)
        self.sim.advance(s=1)
        for name, value in wanted.items():
            self._set(owner, name, value)
        if "key" in features:
            setup = owner.d.MAVLink_setup_signing_message(1, 243, list(KEY), STAMP)
            if self.system != 1:  # its new id is in force after a reset
                setup.target_system = 1
            self.links["uart0"].send(owner.frame(setup, 0))
        self.sim.advance(s=3)
        self.sim.request("reset", cause="power-on")
        self.sim.advance(s=2)
        for link in self.links.values():
            link.take()
        outputs = self.sim.outputs()
        self.oracle.resets_seen = int(outputs["resets"])
        self.sim.skip_edges()
        self.began_us = self.sim.now_us()

    def _set(self, owner: Party, name: str, value: int) -> None:
        message = owner.d.MAVLink_param_set_message(1, 243, name.encode(), value, REAL32)
        self.links["uart0"].send(owner.frame(message, 0))
        self.sim.advance(100_000)

    # --- time ---------------------------------------------------------------------------------
    def now_us(self) -> int:
        """World time: since the story began."""
        return self.sim.now_us() - self.began_us

    def advance(self, us: int) -> None:
        """What came in a step in which the light was reset is not judged: part of it was sent
        before, part after."""
        self.sim.advance(us)
        outputs = self.sim.outputs()
        was_reset = int(outputs["resets"]) != self.oracle.resets_seen
        self.oracle.edges(
            [(edge.time_us - self.began_us, edge.level_ppm) for edge in self.sim.edges()]
        )
        if was_reset:
            self.world.tell(self, f"was reset: {outputs['reset_cause']}")
            self.links["uart0"].take()
        self.oracle.sample(self.now_us(), outputs)
        self.take()

    def take(self) -> None:
        data = b"".join(self.links["uart0"].take())
        if not data:
            return
        now_us = self.now_us()
        self.oracle.traffic(now_us, len(data))
        for message in self.decoder.parse_buffer(data) or []:
            if message.get_type() == "BAD_DATA":
                continue
            if (message.get_srcSystem(), message.get_srcComponent()) == self.address:
                self._heard(now_us, message)

    def _heard(self, now_us: int, message: Any) -> None:
        kind = message.get_type()
        if kind == "COMMAND_ACK":
            to = (message.target_system, message.target_component)
            self.world.tell(self, f"answers {message.command} of {to[0]}/{to[1]}: {message.result}")
            self.oracle.acknowledged(now_us, to, message.command, message.result)
        elif kind == "ILLUMINATOR_STATUS":
            self.oracle.status(now_us, message)
        elif kind == "STATUSTEXT":
            self.world.tell(self, f"says '{message.text}'")

    # --- what is sent to it -------------------------------------------------------------------
    def is_sure(self) -> bool:
        around = self.oracle.around
        now_us = self.now_us()
        return (
            not around.wire_faulty
            and around.stalled_us is None
            and now_us - around.wire_clean_us > FLIGHT_US
            and now_us - around.up_us > SECOND_US
        )

    def send(self, party: Party, message: Any, *, record: bool = False) -> None:
        frame = party.frame(message, self.now_us())
        if record:
            self.recorded.append((self.now_us(), frame))
        self.links["uart0"].send(frame)
        self.advance(0)

    def command(
        self,
        party: Party,
        number: int,
        params: tuple[float, ...],
        effect: Effect,
        results: frozenset[int],
    ) -> None:
        authorised = not self.oracle.key or party.key is not None
        one = Sent(party.address, number, effect, results, self.now_us(), self.is_sure())
        self.oracle.sent(one, authorised=authorised)
        self.send(party, party.command(number, *params, to=self.address), record=True)


class World:
    """Runs a plan. told: called with each line of the story."""

    def __init__(self, plan: Plan, binary: Path, told: Callable[[str], None] | None = None) -> None:
        self.plan = plan
        self.binary = binary
        self.told = told
        self.dialect = load_dialect(find_dialect(binary.parent))
        has_key = "key" in plan.features
        key = KEY if has_key else None
        d = self.dialect
        self.stations = {
            "owner": Party(d, 255, 190, key, version=1 if "version-1" in plan.features else 2),
            "second": Party(d, 250, 190, key),
        }
        self.autopilots = [Party(d, 1 + i, 1, key) for i in range(plan.lights)]
        self.stranger = Party(d, 66, 190)
        self.lights = [Light(self, i) for i in range(plan.lights)]
        self.now_us = 0
        self.outcome = Outcome(plan.seed)

    def tell(self, light: Light, line: str) -> None:
        if self.told is not None:
            self.told(f"{light.now_us() / 1e6:9.3f} s  light {light.number}    {line}")

    # --- the loop -----------------------------------------------------------------------------
    def run(self) -> Outcome:
        try:
            for light in self.lights:
                light.start()
            self._story()
            self._afterwards()
        finally:
            for light in self.lights:
                light.sim.stop()
                light.sim._folder.cleanup()
        outcome = self.outcome
        for light in self.lights:
            who = f"light {light.number}: " if len(self.lights) > 1 else ""
            outcome.violations += [who + line for line in light.oracle.violations]
            outcome.tally.update(vars(light.oracle.tally))
        outcome.simulated_us = self.now_us * len(self.lights)
        return outcome

    def _story(self) -> None:
        actions = list(self.plan.actions)
        beat_us = 0
        while self.now_us < self.plan.duration_us:
            due_us = min(beat_us, actions[0].at_us if actions else self.plan.duration_us)
            self._pass_until(max(due_us, self.now_us))
            while actions and actions[0].at_us <= self.now_us:
                self._act(actions.pop(0))
            if beat_us <= self.now_us:
                self._beat()
                beat_us += SECOND_US
            if due_us <= self.now_us:
                self._pass_until(min(self.now_us + 1000, self.plan.duration_us))

    def _pass_until(self, end_us: int) -> None:
        step_us = RING_POLL_US if "ring" in self.plan.features else POLL_US
        while self.now_us < end_us:
            self.now_us = min(end_us, self.now_us + step_us)
            for light in self.lights:
                light.advance(max(0, self.now_us - light.now_us()))
            self._shuttle()
            self.outcome.events += 1

    def _shuttle(self) -> None:
        """What one light sent on the ring's UARTs reaches the other."""
        if len(self.lights) < 2:
            return
        first, second = self.lights
        for name in ("uart1", "uart2"):
            there = b"".join(first.links[name].take())
            back = b"".join(second.links[name].take())
            for light, data in ((second, there), (first, back)):
                if data:
                    light.oracle.traffic(self.now_us, len(data))
                    light.links[name].send(data)

    def _beat(self) -> None:
        for light in self.lights:
            if light.is_silent:
                continue
            for party in [self.stations["owner"], self.autopilots[light.number]]:
                is_station = party is self.stations["owner"]
                message = party.station() if is_station else party.autopilot()
                light.send(party, message, record=True)
                light.oracle.life(light.now_us(), light.is_sure())

    def _afterwards(self) -> None:
        """All faults end; then everything answers again."""
        for light in self.lights:
            light.is_silent = False
            self._end_faults(light)
        self._pass_until(self.now_us + HEAL_US)
        self._beat()
        for light in self.lights:
            before = light.oracle.tally.accepted
            for on in (True, False):
                self._switch(light, self.stations["owner"], float(on))
                self._pass_until(self.now_us + SECOND_US)
            if light.oracle.tally.accepted < before + 2:
                light.oracle.violations.append(
                    f"{self.now_us / 1e6:.3f} s: 5 s after the last fault it does not obey"
                )

    def _end_faults(self, light: Light) -> None:
        for action in (
            Action(0, "wire", ("none", 0)),
            Action(0, "ambient", (25,)),
            Action(0, "fan", (1,)),
            Action(0, "sensor", ("none",)),
            Action(0, "bus", ("none", 0)),
        ):
            self._perform(light, action)
        light.sim.set(temp_mdegc=25_000)
        light.oracle.around.sensor_us = light.now_us()

    # --- actions ------------------------------------------------------------------------------
    def _act(self, action: Action) -> None:
        if self.told is not None:
            self.told(str(action))
        self.outcome.events += 1
        self._perform(self.lights[action.light], action)

    def _perform(self, light: Light, action: Action) -> None:
        getattr(self, "_" + action.verb)(light, *action.args)

    def _switch(self, light: Light, party: Party, value: float) -> None:
        is_valid = value in (0.0, 1.0)
        results = frozenset({ACCEPTED} if is_valid else {DENIED})
        effect = turned(value == 1.0) if is_valid else nothing
        light.command(party, ON_OFF, (value,), effect, results)

    def _on(self, light: Light, station: str) -> None:
        if not light.is_silent:
            self._switch(light, self.stations[station], 1.0)

    def _off(self, light: Light, station: str) -> None:
        if not light.is_silent:
            self._switch(light, self.stations[station], 0.0)

    def _wrong_switch(self, light: Light, station: str, value: float) -> None:
        if not light.is_silent:
            self._switch(light, self.stations[station], value)

    def _configure(
        self, light: Light, station: str, brightness: float, period: float, duty: float, mode: int
    ) -> None:
        if light.is_silent:
            return
        if is_in_range(brightness, period, duty, mode):
            results, effect = {ACCEPTED}, configured(brightness, period, duty, mode)
        else:
            results, effect = {DENIED}, nothing
        light.command(
            self.stations[station],
            CONFIGURE,
            (mode, brightness, period, duty),
            effect,
            frozenset(results),
        )

    def _unknown(self, light: Light, station: str, number: int) -> None:
        if not light.is_silent:
            light.command(self.stations[station], number, (0.0,), nothing, frozenset({UNSUPPORTED}))

    def _status(self, light: Light, station: str) -> None:
        if not light.is_silent:
            light.command(
                self.stations[station], REQUEST_MESSAGE, (STATUS,), nothing, frozenset({ACCEPTED})
            )

    def _hardpoint(self, light: Light, on: int) -> None:
        light = self.lights[0]
        command = uavcan.equipment.hardpoint.Command(hardpoint_id=HARDPOINT, command=on)
        assert light.node is not None
        light.node.broadcast(command)
        # a light with a key hears DroneCAN only if MAV_KEY_CAN says so
        if "exclusion" not in self.plan.features and not light.oracle.key:
            light.oracle.switched(light.now_us(), bool(on), not light.oracle.around.bus_faulty)
        light.advance(0)

    # --- faults -------------------------------------------------------------------------------
    def _wire(self, light: Light, kind: str, rate_ppm: int) -> None:
        fields = {} if kind == "none" else {"rate_ppm": rate_ppm}
        light.sim.fault("uart0", kind, **fields)
        light.oracle.around.wire_faulty = kind != "none"
        light.oracle.around.wire_clean_us = light.now_us()
        self.outcome.faults += kind != "none"

    def _ambient(self, light: Light, degrees: int) -> None:
        light.sim.set_ambient(degrees)
        self.outcome.faults += degrees > 25

    def _fan(self, light: Light, works: int) -> None:
        light.sim.set_fan(bool(works))
        self.outcome.faults += not works

    def _sensor(self, light: Light, kind: str) -> None:
        light.sim.fault("thermistor", kind)
        light.oracle.around.sensor = kind
        light.oracle.around.sensor_us = light.now_us()
        self.outcome.faults += kind != "none"

    def _reset(self, light: Light, cause: str) -> None:
        light.oracle.reset_expected(light.now_us())
        light.sim.request("reset", cause=cause)
        light.advance(0)
        self.outcome.faults += 1

    def _cut(self, light: Light, byte: int) -> None:
        light.sim.fault("storage", "torn", byte=byte)
        self.outcome.faults += 1

    def _stall(self, light: Light, thread: str) -> None:
        light.sim.fault("thread", "stalled", name=thread)
        light.oracle.around.stalled_us = light.now_us()
        light.oracle.around.healthy_us = light.now_us()
        self.outcome.faults += 1

    def _silence(self, light: Light, on: int) -> None:
        for each in self.lights:  # one hears of another's stations
            each.is_silent = bool(on)
        self.outcome.faults += on

    def _garbage(self, light: Light, seed: int, count: int) -> None:
        light.links["uart0"].send(random.Random(seed).randbytes(count))
        light.oracle.around.wire_clean_us = light.now_us()
        light.advance(0)
        self.outcome.faults += 1

    def _half(self, light: Light, count: int) -> None:
        frame = self.stranger.frame(self.stranger.command(ON_OFF, 1.0, to=light.address), 0)
        light.links["uart0"].send(frame[:count])
        light.oracle.around.wire_clean_us = light.now_us()
        light.advance(0)
        self.outcome.faults += 1

    def _bus(self, light: Light, kind: str, value: int) -> None:
        light = self.lights[0]
        if light.node is None:
            return
        fields = {"none": {}, "lost": {"rate_ppm": value}, "bus-off": {"hold_us": value}}[kind]
        light.sim.fault("can0", kind, **fields)
        light.oracle.around.bus_faulty = kind != "none"
        self.outcome.faults += kind != "none"

    # --- the attacker -------------------------------------------------------------------------
    def _attack(self, light: Light, how: str) -> None:
        if not light.oracle.key:
            return
        self.outcome.faults += 1
        d, stranger = self.dialect, self.stranger
        if how == "replay":
            self._replay(light)
            return
        party, message = {
            "on": (stranger, stranger.command(ON_OFF, 1.0, to=light.address)),
            "off": (stranger, stranger.command(ON_OFF, 0.0, to=light.address)),
            "autopilot": (Party(d, 77, 1), stranger.autopilot()),
            "station": (stranger, stranger.station()),
            "setup": (stranger, d.MAVLink_setup_signing_message(*light.address, [0] * 32, STAMP)),
            "parameter": (
                stranger,
                d.MAVLink_param_set_message(
                    *light.address,
                    b"THR_SHUTDOWN",
                    149,
                    REAL32,
                ),
            ),
            "reboot": (stranger, stranger.command(REBOOT, 1.0, to=light.address)),
        }[how]
        light.send(party, message)

    def _replay(self, light: Light) -> None:
        """A frame that certainly arrived, and later ones of its stream as well."""
        now_us = light.now_us()
        old = [
            frame
            for at_us, frame in light.recorded
            if now_us - at_us > 3 * SECOND_US and at_us > light.oracle.around.up_us
        ]
        if old and light.is_sure() and not light.is_silent:
            light.links["uart0"].send(random.Random(now_us).choice(old))
            light.advance(0)
