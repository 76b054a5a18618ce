# SPDX-License-Identifier: Apache-2.0
"""What happens in one simulated world: drawn from a seed, and nothing else.

Swarm style: each seed turns a random part of the features and faults on, so that rare company
meets.
A plan is a flat list of timed actions; leaving some out gives a smaller plan (shrink.py).
"""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Iterable
from dataclasses import dataclass, replace

SECOND_US = 1_000_000
SHORTEST_S = 60
LONGEST_S = 90

# What the world has, beside one light, a vehicle and a ground station.
FEATURES = (
    "key",  # the owner has a key, and so has the light
    "restore",  # the last state is in force again after a reset
    "loss-off",  # silence of all commanders puts the lamp out
    "loss-beacon",  # or lights a beacon
    "can",  # a DroneCAN node that switches the light
    "nodes",  # others on that bus, who say much that is for others
    "imc",  # an IMC peer that switches and dims the light
    "exclusion",  # DroneCAN and IMC may not command
    "gimbal",  # is pointed
    "ring",  # two lights that forward, joined by two UARTs each
    "many",  # three or four of them
    "two-stations",
    "version-1",  # a station that speaks MAVLink 1
)
# What goes wrong in it.
FAULTS = (
    "lossy",  # a UART loses, flips and doubles bytes
    "heat",  # sun
    "fan",  # fails
    "sensor",  # open, short, stuck, noisy
    "reset",
    "power-cut",  # at a byte of a write
    "stall",  # a thread hangs
    "silence",  # nobody speaks
    "garbage",  # bytes that are no frames, halves of frames
    "attacker",  # has no key; without a key to protect it, only a nuisance
    "bus",  # a CAN bus that loses frames, or goes off
    "clash",  # another node on it has the light's id
    "chip",  # a converter, a timer or a port answers with errors
    "time",  # power comes back days or years later
)
NEEDS = {"exclusion": "can", "nodes": "can", "bus": "can", "clash": "can", "many": "ring"}
EXCLUDE_EACH_OTHER = (("loss-off", "loss-beacon"), ("key", "version-1"))

THREADS = ("thermal", "command", "uart_link0")


@dataclass(frozen=True)
class Action:
    """At `at_us` (world time), `verb` is done to light number `light`."""

    at_us: int
    verb: str
    args: tuple[float | int | str, ...] = ()
    light: int = 0

    def __str__(self) -> str:
        args = " ".join(str(arg) for arg in self.args)
        return f"{self.at_us / 1e6:9.3f} s  light {self.light}  {self.verb} {args}".rstrip()


@dataclass(frozen=True)
class Plan:
    seed: int
    duration_us: int
    features: frozenset[str]
    faults: frozenset[str]
    actions: tuple[Action, ...]

    @property
    def lights(self) -> int:
        return _lights(self.seed, self.features)

    def only(self, indices: Iterable[int]) -> Plan:
        """The same world with these actions only."""
        return replace(self, actions=tuple(self.actions[i] for i in sorted(indices)))


def _lights(seed: int, features: Iterable[str]) -> int:
    if "many" in features:
        return 3 + seed % 2
    return 2 if "ring" in features else 1


def f32(value: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def _settings(rng: random.Random) -> tuple[float, float, float, int]:
    """Brightness, period, duty, mode of a 406 that is in range."""
    brightness = rng.choice((0.0, 0.1, 1.0, 10.0, 25.0, 50.0, 99.9, 100.0, rng.uniform(0, 100)))
    period = rng.choice((0.0, 0.0, 0.02, 0.1, 0.25, 0.5, 1.0, 3.0, rng.uniform(0.02, 5)))
    duty = rng.choice((0.0, 1.0, 10.0, 50.0, 90.0, 100.0, rng.uniform(0, 100)))
    mode = 1 if rng.random() < 0.9 else 2
    return f32(brightness), f32(period), f32(duty), mode


# 406 out of range, one value each.
BAD_SETTINGS = (
    (-0.1, 0.0, 100.0, 1),
    (100.1, 0.0, 100.0, 1),
    (math.nan, 0.0, 100.0, 1),
    (50.0, -1.0, 100.0, 1),
    (50.0, 0.001, 100.0, 1),
    (50.0, 11.0, 100.0, 1),
    (50.0, 1.0, 100.5, 1),
    (50.0, 1.0, math.nan, 1),
    (50.0, 0.0, 100.0, 0),
    (50.0, 0.0, 100.0, 3),
)


class _Draw:
    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.seed = seed
        self.features = self._some(FEATURES)
        self.faults = self._some(FAULTS) or {self.rng.choice(FAULTS)}
        for pair in EXCLUDE_EACH_OTHER:
            if set(pair) <= self.features:
                self.features.discard(self.rng.choice(pair))
        for wants, needed in NEEDS.items():
            if needed not in self.features:
                self.features.discard(wants)
                self.faults.discard(wants)
        if not self.faults:
            self.faults = {"reset"}
        self.duration_us = self.rng.randrange(SHORTEST_S, LONGEST_S) * SECOND_US
        self.actions: list[Action] = []

    def _some(self, names: tuple[str, ...]) -> set[str]:
        share = self.rng.choice((0.15, 0.3, 0.5))
        return {name for name in names if self.rng.random() < share}

    def add(self, verb: str, *args: float | int | str, at_us: int | None = None) -> int:
        when = self.rng.randrange(2 * SECOND_US, self.duration_us) if at_us is None else at_us
        light = self.rng.randrange(_lights(self.seed, self.features))
        self.actions.append(Action(when, verb, args, light))
        return when

    def until(
        self,
        verb: str,
        start: tuple[float | int | str, ...],
        end: tuple[float | int | str, ...],
        longest_s: float,
    ) -> None:
        """A fault that ends again."""
        light = len(self.actions)
        when = self.add(verb, *start)
        length = int(self.rng.uniform(0.3, longest_s) * SECOND_US)
        self.actions.append(replace(self.actions[light], at_us=when + length, args=end))

    def commands(self) -> None:
        rng = self.rng
        for _ in range(rng.randrange(5, 40)):
            station = (
                "owner" if "two-stations" not in self.features else rng.choice(("owner", "second"))
            )
            what = rng.random()
            if what < 0.3:
                self.add("on", station)
            elif what < 0.45:
                self.add("off", station)
            elif what < 0.75:
                self.add("configure", station, *_settings(rng))
            elif what < 0.85:
                self.add("configure", station, *rng.choice(BAD_SETTINGS))
            elif what < 0.9:
                self.add("wrong_switch", station, rng.choice((2.0, -1.0, math.nan, 0.5)))
            elif what < 0.95:
                self.add("unknown", station, rng.choice((400, 31000, 65535)))
            else:
                self.add("status", station)

    def others(self) -> None:
        """Commands of the features that bring their own."""
        rng = self.rng
        if "can" in self.features:
            for _ in range(rng.randrange(1, 8)):
                self.add("hardpoint", rng.randrange(2))
        if "nodes" in self.features:
            for _ in range(rng.randrange(1, 6)):
                self.add("chatter", rng.randrange(1 << 30), rng.randrange(20, 200))
        if "imc" in self.features:
            for _ in range(rng.randrange(1, 8)):
                self.add("led", rng.choice((0, 1, 51, 128, 255)))
        if "gimbal" in self.features:
            for _ in range(rng.randrange(2, 10)):
                self.add("point", rng.randrange(-40, 41), rng.randrange(-40, 41))
        if "ring" in self.features:
            for _ in range(rng.randrange(1, 10)):
                self.add("far", rng.randrange(2))

    def habits(self) -> None:
        """What peers do all the time for a while, once they do it."""
        rng = self.rng
        if "can" in self.features:
            for _ in range(rng.randrange(1, 4)):
                self.until("insist", (rng.randrange(2),), (-1,), 30)
        if "imc" in self.features:
            for _ in range(rng.randrange(1, 3)):
                self.until("greet", (1,), (0,), 20)
        if "attacker" in self.faults and "key" in self.features:
            # its hour is when the owner is not there
            self.until("silence", (1,), (0,), 30)

    def trouble(self) -> None:
        rng = self.rng
        for fault in sorted(self.faults):
            for _ in range(rng.randrange(1, 4)):
                getattr(self, "_" + fault.replace("-", "_"))(rng)

    def _lossy(self, rng: random.Random) -> None:
        kind = rng.choice(("lost", "flipped", "doubled"))
        self.until("wire", (kind, rng.choice((1_000, 10_000, 100_000))), ("none", 0), 10)

    def _heat(self, rng: random.Random) -> None:
        # it burns, and then it freezes, since a world has no time for less
        self.until("ambient", (rng.choice((85, 200, 300)),), (rng.choice((25, -100)),), 30)

    def _fan(self, rng: random.Random) -> None:
        self.until("fan", (0,), (1,), 30)

    def _sensor(self, rng: random.Random) -> None:
        self.until("sensor", (rng.choice(("open", "short", "stuck", "noisy")),), ("none",), 15)

    def _reset(self, rng: random.Random) -> None:
        self.add("reset", rng.choice(("pin", "software", "brownout", "power-on")))

    def _power_cut(self, rng: random.Random) -> None:
        byte = rng.randrange(0, 200)
        light = len(self.actions)
        when = self.add("cut", byte)
        self.add("reset", "power-on", at_us=when + int(rng.uniform(0.0, 4.0) * SECOND_US))
        self.actions[-1] = replace(self.actions[-1], light=self.actions[light].light)

    def _stall(self, rng: random.Random) -> None:
        self.add("stall", rng.choice(THREADS))

    def _silence(self, rng: random.Random) -> None:
        self.until("silence", (1,), (0,), 20)

    def _garbage(self, rng: random.Random) -> None:
        self.add("garbage", rng.randrange(1 << 30), rng.randrange(1, 400))
        self.add("half", rng.randrange(1, 40))
        if "ring" in self.features:
            self.add("strangers", rng.randrange(30, 60))

    def _attacker(self, rng: random.Random) -> None:
        for _ in range(rng.randrange(1, 12)):
            self.add(
                "attack",
                rng.choice(
                    (
                        "on",
                        "off",
                        "autopilot",
                        "setup",
                        "replay",
                        "parameter",
                        "reboot",
                        "station",
                        "point",
                        "status",
                        "other-key",
                        "imc",
                    )
                ),
            )

    def _bus(self, rng: random.Random) -> None:
        if rng.random() < 0.5:
            self.until("bus", ("lost", 50_000), ("none", 0), 5)
        else:
            self.add("bus", "bus-off", rng.randrange(0, 2 * SECOND_US))

    def _clash(self, rng: random.Random) -> None:
        self.until("clash", (1,), (0,), 25)

    def _chip(self, rng: random.Random) -> None:
        self.until("chip", (rng.choice(("adc", "pwm", "gpio")),), ("none",), 10)

    def _time(self, rng: random.Random) -> None:
        self.add("later", rng.choice((60, 3600, 86_400, 40 * 86_400, 3 * 365 * 86_400)))


def draw(seed: int) -> Plan:
    """The plan of a seed; always the same."""
    drawn = _Draw(seed)
    drawn.commands()
    drawn.others()
    drawn.trouble()
    drawn.habits()
    return Plan(
        seed,
        drawn.duration_us,
        frozenset(drawn.features),
        frozenset(drawn.faults),
        tuple(sorted(drawn.actions, key=lambda action: action.at_us)),
    )
