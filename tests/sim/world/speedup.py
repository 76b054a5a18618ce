# SPDX-License-Identifier: Apache-2.0
"""Do two workers of a Dask cluster find what one process finds, and nearly twice as fast?

make simulate-speedup SEEDS=1:201        on a machine with two cores that does nothing else
"""

from __future__ import annotations

import argparse
import os
import sys

from campaign import build_of, run
from simulate import seed_range
from world import Outcome

WORKERS = 2
LEAST = 1.8


def measure(seeds: range, workers: str) -> tuple[dict[int, Outcome], float]:
    """Everything that each seed came to, and the seconds."""
    outcomes = {}
    seconds = 0.0
    for outcome, summary in run(seeds, workers):
        outcomes[outcome.seed] = outcome
        seconds = summary.seconds
    return outcomes, seconds


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=seed_range, default=seed_range("1:201"), help="FIRST:END")
    args = parser.parse_args()
    if (cores := len(os.sched_getaffinity(0))) < WORKERS:
        print(f"speedup: {WORKERS} cores are needed, here is {cores}", file=sys.stderr)
        return 2
    alone, alone_s = measure(args.seeds, "")
    together, together_s = measure(args.seeds, str(WORKERS))
    different = [seed for seed in args.seeds if alone[seed] != together.get(seed)]
    failed = sum(bool(outcome.violations) for outcome in alone.values())
    print(f"{len(args.seeds)} worlds, {failed} failed; build {build_of()[:12]}")
    print(f"one process     {alone_s:8.1f} s")
    print(f"{WORKERS} Dask workers  {together_s:8.1f} s, {alone_s / together_s:.2f} x as fast")
    if different:
        print(f"they differ in seeds {', '.join(map(str, different[:10]))}", file=sys.stderr)
    elif alone_s / together_s < LEAST:
        print(f"less than {LEAST} x as fast: is the machine idle?", file=sys.stderr)
    else:
        return 0
    return 1


if __name__ == "__main__":
    sys.exit(main())
