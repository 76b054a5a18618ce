# SPDX-License-Identifier: Apache-2.0
"""What goes wrong at a power-up: drawn from a seed, one cell of the grid after the other."""

from __future__ import annotations

import random
from dataclasses import dataclass

MS = 1000
SECOND_US = 1000 * MS
DURATION_US = 12 * SECOND_US

# Longest answers that are only late, in ms; beyond the second, a chip that is not there in time.
LATE_MS: dict[str, tuple[int, int]] = {
    "adc": (95, 400),
    "pwm": (4, 20),
    "gpio": (4, 20),
    "counter": (4, 20),
    "watchdog": (250, 300),
    "uart0": (20, 60),
    "can0": (10, 20),
    "imc": (10, 20),
    "storage": (300, 600),
    "flash": (100, 300),
}
KINDS = ("late", "never", "fails", "fails later")
GRID = [(chip, kind) for chip in LATE_MS for kind in KINDS]

THREADS = ("thermal", "command", "uart_link0", "uart_link1", "uart_link2", "uart_link3",
           "can_link", "imc_link")  # fmt: skip
SENSOR = ("open", "short", "hot")


@dataclass(frozen=True)
class Fault:
    """device: a chip, "thread NAME", "sensor", or "watchdog runs" (kind "at boot"). From begin_us
    on, 0 being before power comes, until end_us."""

    device: str
    kind: str
    begin_us: int
    end_us: int
    delay_us: int = 0

    def is_on(self, at_us: int) -> bool:
        return self.begin_us <= at_us < self.end_us

    def meets(self, begin_us: int, end_us: int) -> bool:
        return self.begin_us <= end_us and begin_us <= self.end_us

    def __str__(self) -> str:
        late = f" {self.delay_us / 1e6:g} s" if self.kind == "late" else ""
        return f"{self.begin_us / 1e6:g}-{self.end_us / 1e6:g} s {self.device} {self.kind}{late}"


@dataclass(frozen=True)
class Ask:
    at_us: int
    what: str  # "on", "status", "shell"


@dataclass(frozen=True)
class Plan:
    seed: int
    cells: tuple[tuple[str, str], ...]
    faults: tuple[Fault, ...]
    asks: tuple[Ask, ...]


def _begin(rng: random.Random, kind: str) -> int:
    at_start = kind == "fails" or (kind != "fails later" and rng.random() < 0.5)
    return 0 if at_start else rng.randrange(1500 * MS, 6000 * MS, MS)


def _end(rng: random.Random, begin_us: int) -> int:
    if rng.random() < 0.6:
        return DURATION_US + 1
    return begin_us + rng.randrange(500 * MS, 6000 * MS, MS)


def _chip(rng: random.Random, chip: str, kind: str) -> Fault:
    begin_us = _begin(rng, kind)
    in_time_ms, most_ms = LATE_MS[chip]
    late_ms = rng.randint(1, in_time_ms) if rng.random() < 0.7 else rng.randint(1, most_ms)
    wire = {"fails": "error", "fails later": "error"}.get(kind, kind)
    return Fault(chip, wire, begin_us, _end(rng, begin_us), late_ms * MS if kind == "late" else 0)


def _others(rng: random.Random) -> list[Fault]:
    faults = []
    if rng.random() < 0.3:
        begin_us = _begin(rng, rng.choice(("fails", "fails later")))
        kind = "stalled at start" if begin_us == 0 else "stalled"
        faults.append(Fault(f"thread {rng.choice(THREADS)}", kind, begin_us, _end(rng, begin_us)))
    if rng.random() < 0.3:
        begin_us = _begin(rng, rng.choice(("fails", "fails later")))
        faults.append(Fault("sensor", rng.choice(SENSOR), begin_us, _end(rng, begin_us)))
    if rng.random() < 0.1:
        faults.append(Fault("watchdog runs", "at boot", 0, DURATION_US + 1))
    return faults


def _may_meet(one: tuple[str, str], other: tuple[str, str]) -> bool:
    """Not twice the same chip; and a CPU that hangs before a watchdog works is beyond help."""
    pair = {one, other}
    hangs = any(cell[0] in ("pwm", "gpio", "counter") and cell[1] == "never" for cell in pair)
    unwatched = any(cell[0] == "watchdog" for cell in pair)
    return one[0] != other[0] and not (hangs and unwatched)


def draw(seed: int) -> Plan:
    """One cell by the seed, so that no run of seeds leaves one out, and up to three others."""
    rng = random.Random(f"power-up {seed}")
    cells = [GRID[seed % len(GRID)]]
    for _ in range(rng.choice((0, 0, 0, 1, 1, 2, 3))):
        cell = rng.choice(GRID)
        if all(_may_meet(cell, other) for other in cells):
            cells.append(cell)
    faults = [_chip(rng, *cell) for cell in cells] + _others(rng)
    asks = [
        Ask(at_us + rng.randrange(400) * MS, rng.choice(("on", "on", "status", "shell", "shell")))
        for at_us in range(0, DURATION_US - 2500 * MS, 500 * MS)
    ]
    return Plan(seed, tuple(cells), tuple(faults), tuple(asks))
