# SPDX-License-Identifier: Apache-2.0
"""A model of one light, written from the MAVLink guide, common.xml and docs/architecture.md's
promises. It shares no code with the firmware, and sees only what the world sees: what was sent,
what came back, and the board's outputs.

A wire may lose what was sent, so the model holds every state that the light can be in: a set of
certain ones, and commands that may or may not have arrived since, in order. An ACK or a status
rules states out; when it rules out all, a promise is broken.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from gimbal_oracle import GimbalOracle
from hardpoint_oracle import HardpointOracle
from lamp import BEACON, INTERNAL, Effect, Lamp, turned
from sensor_oracle import SensorOracle
from strobe_oracle import StrobeOracle

ACCEPTED = 0
TEMPORARILY_REJECTED = 1
DENIED = 2
UNSUPPORTED = 3
FAILED = 4

ON_OFF = 405
CONFIGURE = 406

# Whom a MAVLink 1 COMMAND_ACK is for: it has no such fields.
NOBODY = (0, 0)

# Docs of the parameters: defaults of heat.
THROTTLE_C = 80.0
SHUTDOWN_C = 100.0
RECOVER_C = 70.0
FLOOR = 0.2
SAFE = 0.1
SLEW_PER_S = 0.1
# A sample is at most 0.1 s old and the sensor's noise small; the world looks every 0.25 s.
SENSOR_ERROR_C = 1.5
SETTLE_US = 500_000
LOOK_US = 250_000

ACK_US = 500_000
# What has not been answered by then is not under way any more.
FLIGHT_US = 2_000_000
# After a fault the light is itself again: a watchdog bites within 2 s, a boot takes less than 1 s.
HEAL_US = 3_500_000
# What a light may say on one wire, without being asked for lists or files [bytes/s].
TRAFFIC_MAX = 4_000
LOSS_US = 5_000_000
LOSS_ERROR_US = 1_000_000
# A converter that fails is known to by then.
CHIP_US = 1_500_000
# A node with the light's id is told of, and forgotten.
NODE_US = 3_500_000  # NodeStatus comes each second
CLASH_US = 4_000_000
CLASH_OVER_US = 12_000_000
# docs/settings.md: a change is stored when it has stood for a second; one that goes on changing
# after 30 s; twenty at most as fast as that.
STORE_US = 32_000_000
STOOD_US = 2_500_000
BURST = 20


@dataclass
class Sent:
    """A command on its way. sure: nothing on the way could lose it or its answer."""

    sender: tuple[int, int]
    command: int
    effect: Effect
    results: frozenset[int]
    at_us: int
    sure: bool
    is_far: bool = False  # over other lights: it may be obeyed after what was sent later
    late_told: bool = False


@dataclass
class Tally:
    commands: int = 0
    accepted: int = 0
    refused: int = 0
    unanswered: int = 0
    statuses: int = 0
    edges: int = 0
    resets: int = 0
    samples: int = 0


@dataclass
class Circumstances:
    """What the world knows of the light's surroundings, as it makes them."""

    wire_clean_us: int = 0  # since when nothing on the wire was lost or changed
    healthy_us: int = 0  # since when no reset, stall or sensor fault has disturbed it
    sensor: str = "none"
    sensor_us: int = 0
    stalled_us: int | None = None
    torn_us: int | None = None  # since when the flash may fail, until a reset
    wire_faulty: bool = False
    bus_faulty: bool = False
    bus_us: int = 0
    node_us: int | None = None  # its last NodeStatus; None: nobody listens
    chip: str = "none"
    chip_us: int = 0
    adc_us: int = 0
    clash: bool = False
    clash_us: int = -CLASH_OVER_US
    heard_us: int | None = None  # last sign of life that counts; None: none since the reset
    may_be_heard_us: int = -SETTLE_US  # last sign of life that perhaps arrived
    up_us: int = 0


class Oracle:
    """One light's. `violations` is what was promised and not kept."""

    def __init__(self, *, key: bool, restore: bool, fallback: str) -> None:
        self.key = key
        self.restore = restore
        self.fallback = fallback  # "", "loss-off", "loss-beacon"
        self.certain: set[Lamp] = {Lamp()}
        self.pending: list[Sent] = []
        self.spent: deque[Sent] = deque(maxlen=64)
        self.history: list[tuple[int, frozenset[Lamp]]] = [(0, frozenset(self.certain))]
        self.around = Circumstances()
        self.violations: list[str] = []
        self.tally = Tally()
        self.resets_seen = 0
        self.resets_due = 0
        self._hottest: deque[tuple[int, float]] = deque()
        self._latched_us: int | None = None
        self._may_be_latched = False  # within the sensor's error
        self._steady_us = 0  # since when the set of possible states is the same
        self._commands = 0  # that may have changed the lamp since the reset
        self._ruled_us = -1  # when a status last ruled states out
        self._edge_us = -1  # when a command began a phase, rather than showed one
        self._traffic: dict[str, deque[tuple[int, int]]] = {}
        self.gimbal = GimbalOracle(self._broken)
        self._hardpoint = HardpointOracle()
        self._sensor = SensorOracle()
        self._strobe = StrobeOracle(self._broken)

    # --- what may be --------------------------------------------------------------------------
    def _closure(self, states: Iterable[Lamp], sent: Iterable[Sent]) -> set[Lamp]:
        found = set(states)
        for one in sent:
            if FAILED in one.results or ACCEPTED in one.results:
                found |= {one.effect(state) for state in found}
        return found

    def possible(self) -> set[Lamp]:
        """Every state that the light can be in now."""
        return self._closure(self.certain, self.pending)

    def _settle(self, now_us: int) -> None:
        while self.pending and now_us - self.pending[0].at_us > FLIGHT_US:
            lost = self.pending.pop(0)
            self.certain = self._closure(self.certain, [lost])
            self.spent.append(lost)
            self.tally.unanswered += 1
            self._changed(now_us)

        self._fall_back(now_us)

    def _fall_back(self, now_us: int) -> None:
        """Silence of all commanders is a command of its own; when it was heard is known to a
        second, or not at all."""
        around = self.around
        if not self.fallback or around.may_be_heard_us < around.up_us - LOOK_US:
            return
        fallen = {
            BEACON if self.fallback == "loss-beacon" else replace(state, enable=False)
            for state in self.certain
        }
        silent_us = now_us - around.may_be_heard_us
        if silent_us > LOSS_US + LOSS_ERROR_US and around.heard_us is not None:
            changed = fallen
        elif self._may_be_lost(now_us):
            changed = self.certain | fallen
        else:
            return
        self._hardpoint.forget()
        if changed != self.certain:
            self.certain = changed
            self._changed(now_us)

    def _changed(self, now_us: int) -> None:
        self._steady_us = now_us
        self.history.append((now_us, frozenset(self.possible())))

    def _broken(self, now_us: int, what: str) -> None:
        self.violations.append(f"{now_us / 1e6:.3f} s: {what}")

    # --- what was sent ------------------------------------------------------------------------
    def sent(self, one: Sent, *, authorised: bool) -> None:
        """authorised: the security table lets this sender do it."""
        self._settle(one.at_us)
        self.tally.commands += 1
        if authorised:
            self._commands += 1
            self.pending.append(one)
            self._changed(one.at_us)
            self.life(one.at_us, False)  # a sign of life for sure once it is accepted

    def switched(self, now_us: int, effect: Effect) -> None:
        """By a protocol without answers."""
        self._settle(now_us)
        self._commands += 1
        self.life(now_us, False)
        changed = {effect(state) for state in self.possible()}
        self.certain = changed | self.possible()
        self.spent += [one for one in self.pending if not one.is_far]
        self.pending = [one for one in self.pending if one.is_far]
        self._changed(now_us)

    def hardpoint(self, now_us: int, on: int) -> None:
        """A command of the DroneCAN node, new or repeated."""
        self._settle(now_us)
        around = self.around
        hears = not around.bus_faulty and now_us - around.bus_us > FLIGHT_US
        sure = hears and not self._may_fail(now_us) and not self._may_be_lost(now_us)
        if self._hardpoint.sent(now_us, on, sure):
            self.switched(now_us, turned(bool(on)))
        else:
            self.life(now_us, False)

    def life(self, now_us: int, sure: bool) -> None:
        """A sign of life of a commander. One that comes in the instant of the loss may be late."""
        self._fall_back(now_us)
        self.around.may_be_heard_us = max(now_us, self.around.may_be_heard_us)
        if sure:
            self.around.heard_us = now_us

    # --- what came ----------------------------------------------------------------------------
    def acknowledged(self, now_us: int, to: tuple[int, int], command: int, result: int) -> None:
        self._fall_back(now_us)
        # Answers come at once: it is the last such command's. Those before it were lost, or theirs.
        for index in reversed(range(len(self.pending))):
            one = self.pending[index]
            if one.command == command and to in (one.sender, NOBODY):
                break
        else:
            late = [
                one for one in self.spent if one.command == command and to in (one.sender, NOBODY)
            ]
            # over others it may come after a reset
            is_far = any(one.is_far and one.at_us <= self.around.up_us for one in late)
            if not is_far and (not late or not self._was_disturbed(now_us)):
                self._broken(now_us, f"an ACK of {command} to {to} that nobody waits for")
            return
        if result not in one.results and not (result == FAILED and self._may_fail(now_us)):
            self._broken(now_us, f"command {command} of {to} was answered with {result}")
        earlier = self.pending[:index]
        before = self._closure(self.certain, earlier)
        if result == ACCEPTED:
            self.tally.accepted += 1
            if command in (ON_OFF, CONFIGURE):
                self.life(max(one.at_us, self.around.heard_us or 0), True)
                if not one.is_far:
                    self._hardpoint.taken(one.at_us)
            obeyed = {one.effect(state) for state in before}
            if now_us > self._ruled_us and all(not s.enable or s.glows for s in before):
                self._edge_us = now_us
            before = before | obeyed if one.is_far else obeyed
        else:
            self.tally.refused += 1
        self.certain = before
        self.spent += [*(each for each in earlier if not each.is_far), one]
        self.pending[: index + 1] = [each for each in earlier if each.is_far]
        self._changed(now_us)

    def _was_disturbed(self, now_us: int) -> bool:
        return self.around.wire_faulty or now_us - self.around.wire_clean_us < 2 * FLIGHT_US

    def _may_fail(self, now_us: int) -> bool:
        """Heat, a sensor that has failed, or a light that just started."""
        return self._may_be_latched or self._hot(now_us) or not self._is_healthy(now_us)

    def status(self, now_us: int, message: Any) -> None:
        self.tally.statuses += 1
        said = Lamp(
            bool(message.enable), int(message.mode), float(message.brightness),
            float(message.strobe_period), float(message.strobe_duty_cycle),
        )  # fmt: skip
        self._settle(now_us)
        possible = self.possible()
        fitting = {state for state in possible if state.shows_as(said)}
        if not fitting:
            shown = "; ".join(str(state) for state in sorted(possible, key=str)[:3])
            self._broken(now_us, f"the status says {said}, and nobody commanded that: {shown}")
            self.certain, self.pending = {said}, []
        elif not self.pending and self.certain != fitting:
            self.certain = fitting
            self._ruled_us = now_us
            self._changed(now_us)
        if math.isnan(message.temp_c) and self._is_healthy(now_us):
            self._broken(now_us, "the sensor is well, and the status has no temperature")

    def traffic(self, now_us: int, wire: str, size: int, most: int = 5 * TRAFFIC_MAX) -> None:
        """most: in 5 s."""
        recent = self._traffic.setdefault(wire, deque())
        recent.append((now_us, size))
        while recent and now_us - recent[0][0] > 5_000_000:
            recent.popleft()
        if sum(size for _, size in recent) > most:
            self._broken(now_us, f"more than {most} in 5 s on {wire}")
            recent.clear()

    def node_health(self, now_us: int, health: int) -> None:
        """NodeStatus: WARNING (1) while another node has the light's id, and no light is no
        warning but an error (2)."""
        around = self.around
        for_us = now_us - max(around.clash_us, around.bus_us, around.healthy_us)
        if around.bus_faulty or around.stalled_us is not None:
            return
        if around.clash and for_us > CLASH_US and health == 0:
            self._broken(now_us, "another node has its id, and its health is OK")
        if not around.clash and for_us > CLASH_OVER_US and health == 1:
            self._broken(now_us, "nobody has its id any more, and its health is WARNING")

    # --- what the board does ------------------------------------------------------------------
    def reset_expected(self, now_us: int) -> None:
        self.resets_due += 1
        self.around.healthy_us = now_us

    def sample(self, now_us: int, outputs: dict[str, Any]) -> None:
        self.tally.samples += 1
        self._settle(now_us)
        if int(outputs["resets"]) != self.resets_seen:
            self._restarted(now_us, int(outputs["resets"]), str(outputs["reset_cause"]))
        temp_c = outputs["temp_mdegc"] / 1000
        self._hottest.append((now_us, temp_c))
        while now_us - self._hottest[0][0] > SETTLE_US:
            self._hottest.popleft()
        hot_c = SHUTDOWN_C - SENSOR_ERROR_C
        failing = not self._is_healthy(now_us)
        if self._sensor.sample(now_us, temp_c, self.around.sensor, failing, hot_c) or (
            temp_c >= hot_c
        ):
            self._may_be_latched = True
        elif temp_c < RECOVER_C - SENSOR_ERROR_C and self._latched_us is None and not failing:
            self._may_be_latched = False
        level = int(outputs["level_ppm"]) / 1e6
        self._check_heat(now_us, level, temp_c)
        self._check_chip(now_us, level)
        self._check_level(now_us, level)
        self._check_answers(now_us)
        self._check_node(now_us)
        servos = outputs["servos"]
        is_at = (servos["pan"]["angle_mdeg"] / 1000, servos["tilt"]["angle_mdeg"] / 1000)
        self.gimbal.sample(now_us, is_at, self.around.stalled_us is None)

    def look_again(self, now_us: int, outputs: dict[str, Any]) -> None:
        """After what came: a command that was accepted is in force."""
        self._fall_back(now_us)
        self._check_level(now_us, int(outputs["level_ppm"]) / 1e6)

    def _restarted(self, now_us: int, resets: int, cause: str) -> None:
        came = resets - self.resets_seen
        self.resets_seen = resets
        self.tally.resets += came
        stalled = self.around.stalled_us is not None and cause == "watchdog"
        if came > self.resets_due and not stalled:
            self._broken(now_us, f"a reset that nobody asked for: {cause}")
        self.resets_due = 0
        kept = self._stored(now_us) if self.restore else {Lamp()}
        self.around.stalled_us = None
        self.around.torn_us = None
        self.around.up_us = now_us
        self.around.healthy_us = now_us
        self.around.heard_us = None
        self._latched_us = None
        self._may_be_latched = False
        self._commands = 0
        self._hardpoint.forget()
        self.gimbal.restarted(now_us)
        self.spent += self.pending
        self.pending.clear()
        self.certain = kept
        self.history = [(now_us, frozenset(kept))]
        self._changed(now_us)

    def _stored(self, now_us: int) -> set[Lamp]:
        """What may have been stored: what has stood for long enough, or else every state in force
        within the time that storing may take."""
        around = self.around
        fails = around.torn_us is not None or around.stalled_us is not None
        stood = now_us - max(self._steady_us, around.up_us) > STOOD_US
        if stood and not fails and self._commands < BURST:
            return {replace(state, kept=True) for state in self.possible()}
        since_us = (now_us if around.torn_us is None else around.torn_us) - STORE_US
        found: set[Lamp] = {Lamp()} if since_us < 0 else set()
        for index, (_, states) in enumerate(self.history):
            end = self.history[index + 1][0] if index + 1 < len(self.history) else now_us
            if end >= since_us:
                found |= states
        return {replace(state, kept=True) for state in found}

    def _hot(self, now_us: int) -> bool:
        return any(temp >= SHUTDOWN_C - SENSOR_ERROR_C for _, temp in self._hottest)

    def _is_healthy(self, now_us: int) -> bool:
        around = self.around
        return (
            around.sensor == "none"
            and around.chip == "none"
            and around.stalled_us is None
            and now_us - self._disturbed_us() > HEAL_US
        )

    def _disturbed_us(self) -> int:
        return max(self.around.healthy_us, self.around.sensor_us, self.around.chip_us)

    def _limit(self, temp_c: float) -> float:
        """The most that heat allows, with the sensor's error on the light's side."""
        temp_c -= SENSOR_ERROR_C
        if temp_c >= SHUTDOWN_C:
            return 0.0
        if temp_c <= THROTTLE_C:
            return 1.0
        share = (temp_c - THROTTLE_C) / (SHUTDOWN_C - THROTTLE_C)
        return 1.0 - share * (1.0 - FLOOR)

    def _check_heat(self, now_us: int, level: float, temp_c: float) -> None:
        coolest = min(temp for _, temp in self._hottest)
        lasted = now_us - self._hottest[0][0] >= SETTLE_US // 2
        sensor = self.around.sensor
        failed_for = now_us - self.around.sensor_us
        # docs/startup.md: while a thread hangs, for 2.25 s at most, the lamp is as it was
        sees = (
            self.around.chip != "adc"
            and now_us - self.around.adc_us > HEAL_US
            and self.around.stalled_us is None
        )
        if sensor == "none" and failed_for > HEAL_US and lasted and sees:
            if level > self._limit(coolest) + 0.01:
                self._broken(now_us, f"at {temp_c:.1f} degC the level is {level:.3f}")
            if coolest - SENSOR_ERROR_C >= SHUTDOWN_C:
                self._latched_us = now_us
            if self._latched_us is not None:
                if temp_c < RECOVER_C + SENSOR_ERROR_C:
                    self._latched_us = None
                elif level > 0.0 and now_us > self._latched_us:
                    self._broken(now_us, f"lit at {temp_c:.1f} degC after a shutdown")
        if sensor in ("open", "short") and failed_for > SETTLE_US and sees:
            most = SAFE if sensor == "open" else 0.0
            if level > most + 1e-6:
                self._broken(now_us, f"the sensor is {sensor}, and the level is {level:.3f}")
            if sensor == "short":
                self._latched_us = now_us

    def _check_chip(self, now_us: int, level: float) -> None:
        """A lamp that cannot be written is as it was, until it is written: then dark. Neither is
        brighter than was commanded, which is looked at anyhow."""
        around = self.around
        known = now_us - max(around.chip_us, around.up_us) > CHIP_US
        if around.chip == "adc" and known and level > SAFE + 1e-6:
            self._broken(now_us, f"no temperature can be read, and the level is {level:.3f}")

    def _may_be_lost(self, now_us: int) -> bool:
        """Whether the light may think that every commander is silent."""
        heard = self.around.heard_us
        return bool(self.fallback) and (heard is None or now_us - heard >= LOSS_US - LOSS_ERROR_US)

    def _check_level(self, now_us: int, level: float) -> None:
        possible = self.possible()
        if level > 0.0:
            lit = [state for state in possible if state.enable]
            if not lit:
                self._broken(now_us, "lit, and nobody has switched it on")
            elif level > max(state.brightness for state in lit) / 100.0 + 1e-5:
                self._broken(now_us, f"level {level:.3f} is more than was commanded")
        if level == 0.0 and self._must_be_lit(now_us, possible):
            self._broken(now_us, "dark, and it was commanded on")

    def _must_be_lit(self, now_us: int, possible: set[Lamp]) -> bool:
        steady = len(possible) == 1 and now_us - self._steady_us > SETTLE_US
        if not steady or not self._is_healthy(now_us) or self._may_be_lost(now_us):
            return False
        (state,) = possible
        return (
            state.enable
            and state.mode == INTERNAL
            and state.brightness >= 1.0
            and (state.period == 0.0 or state.duty in (0.0, 100.0))
            and not self._may_be_latched
            and max(temp for _, temp in self._hottest) < RECOVER_C - SENSOR_ERROR_C
        )

    def _check_answers(self, now_us: int) -> None:
        for one in self.pending:
            if one.sure and not one.late_told and now_us - one.at_us > ACK_US:
                clean = one.at_us >= self.around.wire_clean_us and not self.around.wire_faulty
                undisturbed = self.around.stalled_us is None and (
                    now_us - self.around.healthy_us > HEAL_US
                )
                if clean and undisturbed:
                    one.late_told = True
                    self._broken(now_us, f"command {one.command} of {one.sender} is not answered")
        stalled_us = self.around.stalled_us
        if stalled_us is not None and now_us - stalled_us > HEAL_US:
            self.around.stalled_us = None
            self._broken(now_us, "a thread hangs, and the watchdog has not bitten")

    def _check_node(self, now_us: int) -> None:
        around = self.around
        if around.node_us is None or around.bus_faulty or around.stalled_us is not None:
            return
        since = max(around.node_us, around.bus_us, around.healthy_us, around.up_us)
        if now_us - since > NODE_US:
            self._broken(now_us, "nothing is heard of it on a CAN bus that is well")
            around.node_us = now_us

    def edges(self, edges: list[tuple[int, int]]) -> None:
        """Changes of the level since the last call: [time, ppm]."""
        for at_us, ppm in edges:
            self.tally.edges += 1
            if self._strobe.edge(at_us, ppm):
                self._check_strobe(at_us)

    def _check_strobe(self, now_us: int) -> None:
        possible = self.possible()
        if len(possible) != 1:
            return
        (state,) = possible
        if (
            not state.enable
            or state.mode != INTERNAL
            or state.period == 0.0
            or not 0.0 < state.duty < 100.0
            or self.around.chip != "none"
            or self._may_be_latched
            or self._may_be_lost(now_us)
            or max(temp for _, temp in self._hottest) > RECOVER_C - SENSOR_ERROR_C
        ):
            return
        begun_us = self._steady_us + (self._steady_us != self._edge_us)
        since_us = max(begun_us, self._disturbed_us() + HEAL_US)
        wanted_us = state.period * 1e6
        self._strobe.check(since_us, wanted_us, wanted_us * state.duty / 100.0)
