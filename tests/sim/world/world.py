# SPDX-License-Identifier: Apache-2.0
"""One simulated world: real firmware in virtual time, a vehicle, stations, a bus, an attacker, heat
and faults, all from one plan; an oracle for each light watches."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from dronecan import uavcan

from attacker import Attacker
from lamp import configured, dimmed, is_in_range, nothing, turned
from light import GIMBAL, HARDPOINT, OWN_NODE, Light
from oracle import ACCEPTED, DENIED, TEMPORARILY_REJECTED, UNSUPPORTED, Sent
from parties import CONFIGURE, KEY, MOUNT, ON_OFF, REQUEST_MESSAGE, STATUS, Party
from pharos import find_dialect, load_dialect
from plan import SECOND_US, Action, Plan

POLL_US = 250_000
RING_POLL_US = 50_000
HEAL_US = 5_000_000
HOT_C = 150
WARM_MDEGC = 76_000


@dataclass
class Outcome:
    """What a world's run found."""

    seed: int
    violations: list[str] = field(default_factory=list)
    simulated_us: int = 0
    events: int = 0
    faults: int = 0
    tally: Counter[str] = field(default_factory=Counter)


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
        self.attacker = Attacker(d)
        self.lights = [Light(self, i) for i in range(plan.lights)]
        for light in self.lights:  # who asks other lights from this one's wire
            light.far = Party(d, 200 + light.number, 190, key)
        self.now_us = 0
        self.outcome = Outcome(plan.seed)

    def parties(self) -> list[Party]:
        return [*self.stations.values(), *self.autopilots, *(light.far for light in self.lights)]

    def is_far(self, address: tuple[int, int]) -> bool:
        return any(light.far.address == address for light in self.lights)

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
                if light.greets:
                    light.greet()
                light.advance(max(0, self.now_us - light.now_us()))
            self._shuttle()
            self.outcome.events += 1

    def _shuttle(self) -> None:
        """What one light of the ring sends on uart1 reaches the next one's uart2, and back."""
        if len(self.lights) < 2:
            return
        count = len(self.lights)
        came = {
            (light.number, name): b"".join(light.links[name].take())
            for light in self.lights
            for name in ("uart1", "uart2")
        }
        for (number, name), data in came.items():
            if not data:
                continue
            other = self.lights[(number + (1 if name == "uart1" else -1)) % count]
            self.lights[number].oracle.traffic(self.now_us, name, len(data))
            other.links["uart2" if name == "uart1" else "uart1"].send(data)

    def _beat(self) -> None:
        if self.lights[0].insists >= 0:
            self._hardpoint(self.lights[0], self.lights[0].insists)
        for light in self.lights:
            if light.oracle.key and "attacker" in self.plan.faults:
                self.attacker.pretend(light)
            if light.is_silent:
                continue
            sure = light.is_sure()
            for party in [self.stations["owner"], self.autopilots[light.number], light.far]:
                if party is light.far and len(self.lights) < 2:
                    continue
                is_vehicle = party is self.autopilots[light.number]
                said = party.autopilot() if is_vehicle else party.station()
                light.write(party, said, record=False)  # a recording of a command tells more
            light.greet()
            light.oracle.life(light.now_us(), sure)
            light.advance(0)

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
            Action(0, "clash", (0,)),
            Action(0, "chip", ("none",)),
            Action(0, "insist", (-1,)),
            Action(0, "greet", (0,)),
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
        if light.hears_others():
            light.oracle.hardpoint(light.now_us(), on)
        light.advance(0)

    def _insist(self, light: Light, on: int) -> None:
        """The node repeats a command all the time; -1: no more."""
        self.lights[0].insists = on

    def _greet(self, light: Light, on: int) -> None:
        """The IMC peer sends many heartbeats, as if each could be lost."""
        light.greets = bool(on)

    def _chatter(self, light: Light, seed: int, count: int) -> None:
        """Others' talk on the bus, none of which concerns the light."""
        node = self.lights[0].node
        assert node is not None
        rng = random.Random(seed)
        color = uavcan.equipment.indication.SingleLightCommand(light_id=7)
        for _ in range(count):
            node.broadcast(
                rng.choice(
                    (
                        uavcan.equipment.hardpoint.Command(hardpoint_id=HARDPOINT + 1, command=1),
                        uavcan.equipment.indication.LightsCommand(commands=[color]),
                        uavcan.equipment.actuator.ArrayCommand(commands=[]),
                        uavcan.protocol.NodeStatus(uptime_sec=rng.randrange(1 << 20)),
                    )
                )
            )
        self.lights[0].advance(0)

    def _led(self, light: Light, value: int) -> None:
        assert light.imc is not None
        light.imc.send("SetLedBrightness", name="lamp", value=value)
        # a light with a key hears IMC only if MAV_KEY_IMC says so
        if light.hears_others():
            light.oracle.switched(light.now_us(), dimmed(value))
        light.advance(0)

    def _point(self, light: Light, pan: int, tilt: int) -> None:
        if light.is_silent:
            return
        light.oracle.gimbal.sent(light.now_us(), (float(pan), float(tilt)))
        light.command(
            self.stations["owner"],
            MOUNT,
            (float(tilt), 0.0, float(pan), 0.0, 0.0, 0.0, 2.0),
            nothing,
            frozenset({ACCEPTED, TEMPORARILY_REJECTED}),
            to=(light.system, GIMBAL),
        )

    def _far(self, light: Light, on: int) -> None:
        """A command to the next light, over this one and the ring."""
        if light.is_silent:
            return
        there = self.lights[(light.number + 1) % len(self.lights)]
        party = light.far
        authorised = not there.oracle.key or party.key is not None
        one = Sent(
            party.address,
            ON_OFF,
            turned(bool(on)),
            frozenset({ACCEPTED}),
            there.now_us(),
            False,
            True,
        )
        there.oracle.sent(one, authorised=authorised)
        light.send(party, party.command(ON_OFF, float(on), to=there.address))

    # --- faults -------------------------------------------------------------------------------
    def _wire(self, light: Light, kind: str, rate_ppm: int) -> None:
        fields = {} if kind == "none" else {"rate_ppm": rate_ppm}
        light.sim.fault("uart0", kind, **fields)
        light.oracle.around.wire_faulty = kind != "none"
        light.oracle.around.wire_clean_us = light.now_us()
        self.outcome.faults += kind != "none"

    def _ambient(self, light: Light, degrees: int) -> None:
        light.sim.set_ambient(degrees)
        if degrees > HOT_C:  # the housing takes minutes: it begins warm, which no sensor believes
            light.sim.set(temp_mdegc=WARM_MDEGC)
            light.oracle.around.sensor_us = light.now_us()
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
        light.oracle.around.torn_us = light.now_us()
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
        stranger = self.attacker.stranger
        frame = stranger.frame(stranger.command(ON_OFF, 1.0, to=light.address), 0)
        light.links["uart0"].send(frame[:count])
        light.oracle.around.wire_clean_us = light.now_us()
        light.advance(0)
        self.outcome.faults += 1

    def _strangers(self, light: Light, count: int) -> None:
        """A message that nobody knows, from that many senders: what routers pass on."""
        for sender in range(count):
            header = bytes([0xFD, 0, 0, 0, sender, 100 + sender, 1, 0xF0, 0xF1, 0x01])
            light.links["uart0"].send(header + b"\x12\x34")
        light.advance(0)
        self.outcome.faults += 1

    def _bus(self, light: Light, kind: str, value: int) -> None:
        light = self.lights[0]
        if light.node is None:
            return
        fields = {"none": {}, "lost": {"rate_ppm": value}, "bus-off": {"hold_us": value}}[kind]
        light.sim.fault("can0", kind, **fields)
        light.oracle.around.bus_faulty = kind != "none"
        light.oracle.around.bus_us = light.now_us()
        self.outcome.faults += kind != "none"

    def _clash(self, light: Light, on: int) -> None:
        light = self.lights[0]
        around = light.oracle.around
        if light.node is None or bool(on) == around.clash:
            return
        if light.twin is not None:
            light.twin.close()
        light.twin = light.sim.node(OWN_NODE) if on else None
        around.clash = bool(on)
        around.clash_us = light.now_us()
        self.outcome.faults += on

    def _chip(self, light: Light, name: str) -> None:
        around = light.oracle.around
        before = around.chip
        if before != "none":
            light.sim.fault("chip", "none", name=before)
        if name != "none":
            light.sim.fault("chip", "error", name=name)
        if "adc" in (name, around.chip):
            around.adc_us = light.now_us()
        around.chip = name
        was_reset = around.up_us >= around.chip_us
        around.chip_us = light.now_us()
        self.outcome.faults += name != "none"
        if before != "none" and was_reset:  # its driver has not started, until the next one
            self._reset(light, "power-on")

    def _later(self, light: Light, seconds: int) -> None:
        """Power goes, and comes back when the others' clocks are that much later."""
        for party in self.parties():
            party.later_us += seconds * SECOND_US
        self._reset(light, "power-on")

    # --- the attacker -------------------------------------------------------------------------
    def _attack(self, light: Light, how: str) -> None:
        if light.oracle.key:
            self.outcome.faults += 1
            self.attacker.attack(light, how)
