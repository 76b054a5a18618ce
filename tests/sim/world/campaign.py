# SPDX-License-Identifier: Apache-2.0
"""Many worlds: in this process, on the cores of this machine, or on a Dask cluster."""

from __future__ import annotations

import hashlib
import itertools
import os
import time
import traceback
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plan import FAULTS, FEATURES, draw
from world import Outcome, World

ROOT = Path(__file__).resolve().parents[3]
BINARY = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve() / "pharos"
# Seeds of one task: long enough that handing it out costs nothing.
CHUNK = 8


def run_seed(seed: int, binary: Path = BINARY) -> Outcome:
    """One world. What goes wrong in running it is a violation as well."""
    try:
        return World(draw(seed), binary).run()
    except Exception:
        return Outcome(seed, [traceback.format_exc(limit=-3)])


def run_chunk(seeds: list[int], build: str) -> list[Outcome]:
    if build_of() != build:  # it changed under the worker
        raise RuntimeError("this worker's build is not the campaign's any more")
    return [run_seed(seed) for seed in seeds]


def build_of(binary: Path = BINARY) -> str:
    """What a build is known by: two that differ must not share a campaign."""
    return hashlib.sha256(binary.read_bytes()).hexdigest()


@dataclass
class Summary:
    """What a campaign saw."""

    seeds: int = 0
    failures: list[Outcome] = field(default_factory=list)
    simulated_us: int = 0
    events: int = 0
    faults: int = 0
    tally: Counter[str] = field(default_factory=Counter)
    company: Counter[tuple[str, str]] = field(default_factory=Counter)
    seconds: float = 0.0

    def add(self, outcome: Outcome) -> None:
        plan = draw(outcome.seed)
        self.seeds += 1
        self.simulated_us += outcome.simulated_us
        self.events += outcome.events
        self.faults += outcome.faults
        self.tally.update(outcome.tally)
        self.company.update(itertools.product(sorted(plan.faults), sorted(plan.features)))
        if outcome.violations:
            self.failures.append(outcome)

    def empty_cells(self) -> list[tuple[str, str]]:
        """Faults that never met a feature."""
        return [cell for cell in itertools.product(FAULTS, FEATURES) if not self.company[cell]]

    def table(self) -> str:
        """How many worlds had a fault (row) and a feature (column)."""
        width = max(len(name) for name in FEATURES) + 2
        lines = [" " * 12 + "".join(f"{name:>{width}}" for name in FEATURES)]
        lines += [
            f"{fault:<12}" + "".join(f"{self.company[fault, name]:>{width}}" for name in FEATURES)
            for fault in FAULTS
        ]
        return "\n".join(lines)

    def text(self) -> str:
        hours = self.simulated_us / 3.6e9
        tally = self.tally
        return (
            f"{self.seeds} worlds, {hours:.1f} simulated hours, {self.faults} faults, "
            f"{self.events} steps in {self.seconds:.0f} s\n"
            f"{tally['commands']} commands sent: {tally['accepted']} accepted, "
            f"{tally['refused']} refused, {tally['unanswered']} lost on the way; "
            f"{tally['statuses']} statuses, {tally['edges']} edges, {tally['resets']} resets, "
            f"{tally['samples']} looks at the outputs"
        )


def _chunks(seeds: Iterable[int]) -> Iterator[list[int]]:
    iterator = iter(seeds)
    while chunk := list(itertools.islice(iterator, CHUNK)):
        yield chunk


def run_here(seeds: Iterable[int]) -> Iterator[Outcome]:
    for seed in seeds:
        yield run_seed(seed)


def run_on(address: str, seeds: Iterable[int]) -> Iterator[Outcome]:
    """On the cluster whose scheduler is at `address`; "local": one worker a core, here. A worker
    that dies loses no seed: its tasks go to another. One with another build is refused."""
    from distributed import Client, LocalCluster, as_completed

    from workers import SameBuild

    if address == "local":
        cluster: Any = LocalCluster(threads_per_worker=1, dashboard_address=None)
    elif address.isdigit():
        cluster = LocalCluster(n_workers=int(address), threads_per_worker=1, dashboard_address=None)
    else:
        cluster = address
    with Client(cluster) as client:
        build = build_of()
        client.register_plugin(SameBuild(build))
        tasks = client.map(run_chunk, list(_chunks(seeds)), build=build, pure=False, retries=3)
        for _, outcomes in as_completed(tasks, with_results=True):
            yield from outcomes
    if not isinstance(cluster, str):
        cluster.close()


def run(seeds: Iterable[int], workers: str = "") -> Iterator[tuple[Outcome, Summary]]:
    """Each outcome as it comes, with the summary so far."""
    summary = Summary()
    began = time.monotonic()
    for outcome in run_on(workers, seeds) if workers else run_here(seeds):
        summary.add(outcome)
        summary.seconds = time.monotonic() - began
        yield outcome, summary
