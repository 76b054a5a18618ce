# SPDX-License-Identifier: Apache-2.0
"""Does the hunt find bugs? Builds the light with each of the bugs in bugs/, one at a time, and runs
seeds until one fails.

make simulate-bugs                 all of them
make simulate-bugs BUGS='no-latch one-slot'

A bug is a patch to the tree, as `git diff` prints it, below three lines: What it changes, as who
made it would say; what it Breaks; and Within how many seeds it is to be found.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from campaign import ROOT, run_seed

BUGS = Path(__file__).resolve().parent / "bugs"
FIELDS = ("What", "Breaks", "Within")


@dataclass(frozen=True)
class Bug:
    name: str
    path: Path
    what: str
    breaks: str
    within: int


def read_bug(path: Path) -> Bug:
    head = path.read_text().partition("\ndiff --git ")[0].splitlines()
    fields = dict(line.split(": ", 1) for line in head if ": " in line)
    what, breaks, within = (fields[name] for name in FIELDS)
    return Bug(path.stem, path, what, breaks, int(within))


def all_bugs() -> list[Bug]:
    return [read_bug(path) for path in sorted(BUGS.glob("*.patch"))]


def _run(folder: Path, *command: str) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stdout[-2000:]}{done.stderr[-2000:]}")


class Scratch:
    """A copy of the tree as it is, that builds the light by itself."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        names = subprocess.run(
            ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
        ).stdout.split("\0")
        for name in filter(None, names):
            if (ROOT / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, folder / name)
        (folder / ".venv").symlink_to(ROOT / ".venv")
        self.build = folder / "build" / "native"
        _run(folder, "cmake", "--preset", "native")
        self.make()

    def make(self) -> None:
        _run(self.folder, "cmake", "--build", str(self.build), "--target", "pharos")

    def binary_with(self, bug: Bug) -> Path:
        """Its program, in a folder with the dialect; the copy is as it was afterwards."""
        patch = str(bug.path)
        _run(self.folder, "git", "apply", "--unsafe-paths", patch)
        try:
            self.make()
            folder = self.folder / "with" / bug.name
            shutil.copytree(self.build / "generated", folder / "generated")
            shutil.copy2(self.build / "pharos", folder / "pharos")
        finally:
            _run(self.folder, "git", "apply", "--unsafe-paths", "-R", patch)
        return folder / "pharos"


def _try(job: tuple[int, Path]) -> tuple[int, list[str]]:
    return job[0], run_seed(*job).violations


def hunt(bug: Bug, binary: Path, workers: int) -> tuple[int, str] | None:
    """The first seed of 1, 2, … that fails, and how; None: none within the bug's number."""
    jobs: Iterator[tuple[int, Path]] = ((seed, binary) for seed in range(1, bug.within + 1))
    with multiprocessing.Pool(workers) as pool:
        for seed, violations in pool.imap(_try, jobs):
            if violations:
                pool.terminate()
                return seed, violations[0]
    return None


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", help="of bugs; all of them without")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    args = parser.parse_args()
    bugs = [bug for bug in all_bugs() if not args.names or bug.name in args.names]
    missed = 0
    print(f"{'bug':<26}{'within':>7}{'found at':>9}{'s':>6}  how")
    with tempfile.TemporaryDirectory(prefix="pharos-bugs-") as name:
        scratch = Scratch(Path(name))
        for bug in bugs:
            began = time.monotonic()
            found = hunt(bug, scratch.binary_with(bug), args.workers)
            seed, how = found or ("never", bug.breaks)
            missed += found is None
            lasted = time.monotonic() - began
            print(f"{bug.name:<26}{bug.within:>7}{seed:>9}{lasted:>6.0f}  {how[:100]}", flush=True)
    print(f"\n{len(bugs) - missed} of {len(bugs)} bugs found")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
