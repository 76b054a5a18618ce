# SPDX-License-Identifier: Apache-2.0
"""Power-ups of the native light in virtual time, with chips that are late, silent or broken.

make simulate-powerup                 300 seeds
make simulate-powerup SEEDS=1:10001   those from 1 to 10 000, and the table of what was met
tests/sim/powerup/powerup.py --seed 42    one seed, and what became of it
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import re
import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

from pharos import MavlinkConnection, RefusedError, Simulator, find_dialect, load_dialect
from powerup_oracle import ANSWER_US, Answer, Oracle, Seen
from powerup_plan import DURATION_US, GRID, KINDS, LATE_MS, MS, Fault, Plan, draw

ROOT = Path(__file__).resolve().parents[3]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
STEP_US = 100 * MS
PROMPT = b"pharos:~$ "
ESCAPE = re.compile(rb"\x1b\[[0-9;?]*[A-Za-z]")
ON_OFF = 405
REQUEST_MESSAGE = 512
STATUS = 440
LIGHT = 243
HOT_MDEGC = 160_000
COOL_MDEGC = 25_000


class World:
    """One plan, carried out: what was seen is in `seen`."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.seen = Seen(boots_us=[0])
        self.sim = Simulator(
            BUILD / "pharos",
            {"uart0": "pty:{folder}/uart0", "console": "pty:{folder}/shell"},
            seed=plan.seed,
            dialect=load_dialect(find_dialect(BUILD)),
        )
        self._open: list[Answer] = []
        self._echo = b""

    def _set(self, fault: Fault, on: bool) -> None:
        device, _, name = fault.device.partition(" ")
        kind = fault.kind if on else "none"
        try:
            if device == "thread":
                self.sim.fault("thread", kind, name=name)
            elif device == "sensor":
                self._set_sensor(fault.kind, on)
            elif fault.device == "watchdog runs":
                self.sim.fault("chip", "running" if on else "none", name="watchdog")
            else:
                late = {"delay_us": fault.delay_us} if kind == "late" else {}
                self.sim.fault("chip", kind, name=device, **late)
        except RefusedError:  # a thread that was never started, as its device was not
            return
        self._note(fault, on)

    def _note(self, fault: Fault, on: bool) -> None:
        """When it really was set: a CPU that hangs goes beyond what was asked."""
        now_us = self.sim.now_us()
        if on:
            self.seen.faults[fault] = replace(fault, begin_us=now_us, end_us=DURATION_US + 1)
        elif fault in self.seen.faults:
            self.seen.faults[fault] = replace(self.seen.faults[fault], end_us=now_us)

    def _set_sensor(self, kind: str, on: bool) -> None:
        if kind == "hot":
            mdegc = HOT_MDEGC if on else COOL_MDEGC
            self.sim.set(ambient_mdegc=mdegc, temp_mdegc=mdegc)
        else:
            self.sim.fault("thermistor", kind if on else "none")

    # --- asking ---------------------------------------------------------------------------------
    def _ask(self, mav: MavlinkConnection, shell: Any, what: str) -> None:
        if any(answer.what == what for answer in self._open):
            return
        if what == "shell":
            shell.send(b"light status\r")
        elif what == "on":
            mav.send_command_long(ON_OFF, 1)
        else:
            mav.send_command_long(REQUEST_MESSAGE, STATUS)
        self._open.append(Answer(self.sim.now_us(), what, None))

    def _answered(self, what: str, result: int | None = None) -> None:
        for answer in [answer for answer in self._open if answer.what == what]:
            answer.came_us = self.sim.now_us()
            answer.result = result
            self._open.remove(answer)
            self.seen.answers.append(answer)

    def _listen(self, mav: MavlinkConnection, shell: Any) -> None:
        now_us = self.sim.now_us()
        for message in mav.drain():
            kind = message.get_type()
            if message.get_srcComponent() != LIGHT:
                continue
            if kind == "HEARTBEAT":
                self.seen.states.append((now_us, int(message.system_status)))
            elif kind == "COMMAND_ACK":
                what = "on" if message.command == ON_OFF else "status"
                self._answered(what, int(message.result))
        mav.inbox.clear()
        self._echo += b"".join(shell.take())
        _, asked, rest = ESCAPE.sub(b"", self._echo).rpartition(b"light status")
        if asked and PROMPT in rest:
            self._echo = b""
            self._answered("shell")
        for answer in [answer for answer in self._open if now_us - answer.at_us >= ANSWER_US]:
            self._open.remove(answer)
            self.seen.answers.append(answer)

    # --- time -----------------------------------------------------------------------------------
    def _observe(self) -> None:
        outputs = self.sim.outputs()
        self.seen.levels.append((self.sim.now_us(), int(outputs["level_ppm"])))
        if outputs["reset_us"] > self.seen.boots_us[-1]:
            self._note_resets(int(outputs["resets"]), int(outputs["reset_us"]))

    def _note_resets(self, resets: int, last_us: int) -> None:
        """Steps are shorter than two resets are apart; a world that resets faster is broken."""
        if resets > len(self.seen.boots_us) + 1:
            raise AssertionError(f"{resets} resets at {last_us / 1e6:g} s: it resets at once")
        self.seen.boots_us.append(last_us)

    def run(self) -> Seen:
        plan = self.plan
        later = [(f.begin_us, f, True) for f in plan.faults if f.begin_us > 0]
        later += [(f.end_us, f, False) for f in plan.faults if f.end_us <= DURATION_US]
        changes = sorted(later, key=lambda change: change[0])
        asks = list(plan.asks)
        with self.sim:
            mav = self.sim.connect("uart0")
            shell = self.sim.open("console")
            mav.heartbeat()
            for fault in plan.faults:
                if fault.begin_us == 0:
                    self._set(fault, True)
            self.sim.request("reset", cause="power-on")
            while self.sim.now_us() < DURATION_US:
                now_us = self.sim.now_us()
                while changes and changes[0][0] <= now_us:
                    _, fault, on = changes.pop(0)
                    self._set(fault, on)
                if self.sim.now_us() >= 2000 * MS and any(
                    f.device == "counter" for f in plan.faults
                ):
                    self.sim.gpio("sync", bool(now_us // STEP_US % 2))
                while asks and asks[0].at_us <= now_us:
                    self._ask(mav, shell, asks.pop(0).what)
                until = [changes[0][0]] if changes else []
                until += [asks[0].at_us] if asks else []
                self.sim.advance(min([STEP_US, *(t - now_us for t in until)]))
                self._observe()
                self._listen(mav, shell)
            self.seen.edges = [(edge.time_us, edge.level_ppm) for edge in self.sim.edges()]
            self._afterwards(mav)
        return self.seen

    def _afterwards(self, mav: MavlinkConnection) -> None:
        """Without faults the next power-up is as any."""
        met = dict(self.seen.faults)
        for fault in self.plan.faults:
            self._set(fault, False)
        self.seen.faults = met
        self.sim.set(ambient_mdegc=COOL_MDEGC, temp_mdegc=COOL_MDEGC)
        self.sim.request("reset", cause="power-on")
        mav.heartbeat()
        self.sim.advance(s=1)
        mav.drain()
        mav.inbox.clear()
        if mav.command_long(ON_OFF, 1).result != 0 or self.sim.outputs()["level_ppm"] != 1_000_000:
            raise AssertionError("not lit after all faults have gone, and a power-up")


def run(plan: Plan) -> list[str]:
    """What was wrong."""
    world = World(plan)
    try:
        seen = world.run()
    except Exception as error:
        return [f"{type(error).__name__}: {error}"]
    return Oracle(plan, seen).check()


def run_seed(seed: int) -> tuple[int, list[str]]:
    return seed, run(draw(seed))


def _table(seeds: range) -> str:
    """How many of the seeds have had each cell."""
    count = Counter(cell for seed in seeds for cell in draw(seed).cells)
    lines = [f"{'':<10}" + "".join(f"{kind:>13}" for kind in KINDS)]
    lines += [
        f"{chip:<10}" + "".join(f"{count[chip, kind]:>13}" for kind in KINDS) for chip in LATE_MS
    ]
    assert all(count[cell] for cell in GRID) or len(seeds) < len(GRID), "an empty cell"
    return "\n".join(lines)


def _seeds(text: str) -> range:
    first, _, end = text.partition(":")
    return range(int(first), int(end))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seeds", type=_seeds, default=range(1, 301), metavar="FIRST:END")
    parser.add_argument("--seed", type=int, help="one, and its story")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    args = parser.parse_args()
    if args.seed is not None:
        plan = draw(args.seed)
        print("\n".join(str(fault) for fault in plan.faults))
        wrong = run(plan)
        print("\n".join(wrong) or "nothing was wrong")
        return 1 if wrong else 0
    failed = 0
    begin = time.monotonic()
    with multiprocessing.Pool(args.jobs) as pool:
        for seed, wrong in pool.imap_unordered(run_seed, args.seeds, chunksize=8):
            if wrong:
                failed += 1
                print(f"seed {seed}: {wrong[0]}\n  again: {Path(__file__).name} --seed {seed}")
    print(_table(args.seeds))
    taken_s = time.monotonic() - begin
    print(f"{len(args.seeds)} power-ups, {failed} failed, {taken_s:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
