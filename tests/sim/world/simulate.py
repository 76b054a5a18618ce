# SPDX-License-Identifier: Apache-2.0
"""Hunts for broken promises in simulated worlds.

make simulate                            300 seeds, on this machine's cores
make simulate SEEDS=1:100001             those from 1 to 100 000
make simulate SEED=42                    one seed's story, and the smallest part of it that fails
make simulate WORKERS=tcp://HOST:8786    on a Dask cluster; its workers: make simulate-worker
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from campaign import BINARY, build_of, run
from plan import Plan, draw
from shrink import shrink
from world import World


def seed_range(text: str) -> range:
    first, _, end = text.partition(":")
    try:
        seeds = range(int(first), int(end))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no range of seeds such as 1:301") from None
    if not seeds:
        raise argparse.ArgumentTypeError(f"'{text}' has no seed in it: FIRST:END with FIRST < END")
    return seeds


def _violations(plan: Plan, binary: Path) -> list[str]:
    return World(plan, binary).run().violations


def tell(seed: int, binary: Path, smaller: bool) -> int:
    """The story of a seed; when it fails, of the smallest part that does."""
    plan = draw(seed)
    print(
        f"seed {seed}: features: {', '.join(sorted(plan.features)) or 'none'}; "
        f"faults: {', '.join(sorted(plan.faults))}"
    )
    violations = World(plan, binary, print).run().violations
    if not violations:
        print("no promise was broken")
        return 0
    print("broken:", *violations[:10], sep="\n  ")
    if smaller:
        kind = violations[0].partition(" s: ")[2].rstrip("0123456789.")[:24]
        less = shrink(plan, lambda part: any(kind in v for v in _violations(part, binary)))
        print(f"\nthe same with {len(less.actions)} of {len(plan.actions)} actions:")
        print("broken:", *World(less, binary, print).run().violations[:3], sep="\n  ")
    return 1


def hunt(seeds: range, workers: str) -> int:
    summary = None
    for outcome, summary in run(seeds, workers):
        if outcome.violations:
            print(
                f"seed {outcome.seed}: {outcome.violations[0]}\n"
                f"  again: make simulate SEED={outcome.seed}",
                flush=True,
            )
        elif summary.seeds % 100 == 0:
            print(
                f"{summary.seeds} of {len(seeds)} worlds, {len(summary.failures)} failed",
                flush=True,
            )
    assert summary is not None
    print(f"\nworlds with a fault (row) and a feature (column)\n{summary.table()}\n")
    print(summary.text())
    rate = summary.seeds / max(summary.seconds, 1e-9) * 3600
    print(f"{rate:,.0f} worlds an hour; build {build_of()[:12]}")
    print(f"\n{summary.seeds - len(summary.failures)} passed, {len(summary.failures)} failed")
    return int(bool(summary.failures))


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=seed_range, default=seed_range("1:301"), help="FIRST:END")
    parser.add_argument("--seed", type=int, help="tell this one's story")
    parser.add_argument("--whole", action="store_true", help="do not look for a smaller story")
    parser.add_argument(
        "--workers", default="local", help="local, a number of processes, tcp://HOST:PORT, or here"
    )
    args = parser.parse_args()
    if not BINARY.exists():
        print(f"{BINARY} is not there: make build", file=sys.stderr)
        return 2
    if args.seed is not None:
        return tell(args.seed, BINARY, not args.whole)
    return hunt(args.seeds, "" if args.workers == "here" else args.workers)


if __name__ == "__main__":
    sys.exit(main())
