# SPDX-License-Identifier: Apache-2.0
"""Change the code in small ways, one at a time, and see which changes no test notices.

    mutants.py [--count N] [--seed N] [FOLDER…]     e.g. app/core app/proto

Each mutant is one line of one source file, changed by a rule of universalmutator: a sample, drawn
with the seed. Lines that log, assert or include are left alone, and so is what compiles to the same
object. A mutant that does not compile counts for nothing. It is killed by the first that fails of:
the C tests, the tests over the wire, a few simulated worlds. The tree that is changed is a clone in
build/mutants; the report ends with the rate per folder and every survivor.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import shlex
import signal
import subprocess
import sys
import venv
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PLACE = ROOT / "build" / "mutants"
TREE = PLACE / "tree"
BUILD = TREE / "build" / "native"
VENV = PLACE / "venv"
TOOL = "universalmutator==1.14.1"
FOLDERS = ("app/core", "app/proto", "app/threads", "drivers", "boards/native/drivers")
# What stands on such a line is no behaviour that a test could see.
IGNORED = r"LOG_|ASSERT|_Static_assert|#\s*(include|if|el|end|error)|^\s*(\*|//)|SPDX|^\S*\s*X\("
# A mutant that never comes to an end is killed by this.
C_TESTS_S = 300.0
WIRE_S = 1800.0
WORLDS = "1:20"

LIST = f"""
import contextlib, json, sys
from universalmutator import mutator
found = {{}}
for path in sys.stdin.read().split():
    with open(path) as file, contextlib.redirect_stdout(sys.stderr):
        lines = file.readlines()
        rules = ["universal.rules", "c_like.rules", "c.rules"]
        found[path] = [
            (number, text) for number, text, *_ in
            mutator.mutants_regexp(lines, rules, ignorePatterns=[{IGNORED!r}])
        ]
json.dump(found, sys.stdout)
"""


@dataclass(frozen=True)
class Mutant:
    path: str  # from the root of the tree
    line: int  # from 1
    text: str  # instead of what stands there

    @property
    def folder(self) -> str:
        return next(folder for folder in FOLDERS if self.path.startswith(folder + "/"))

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.text.strip()}"


def run(*command: str | Path, timeout_s: float | None = None, **env: str) -> bool:
    """Whether it ends well, in the tree and in time."""
    process = subprocess.Popen(
        [str(word) for word in command], cwd=TREE, env={**os.environ, **env},
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip
    try:
        return process.wait(timeout_s) == 0
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        process.wait()
        return False


def prepare() -> None:
    """A clone with a build of all tests, and the tool in an environment of its own."""
    PLACE.mkdir(parents=True, exist_ok=True)
    if not (VENV / "bin" / "python").exists():
        venv.create(VENV, with_pip=True)
        subprocess.run([VENV / "bin" / "python", "-m", "pip", "-q", "install", TOOL], check=True)
    if not TREE.exists():
        subprocess.run(["git", "clone", "-q", "--shared", ROOT, TREE], check=True)
        (TREE / ".venv").symlink_to(ROOT / ".venv")
    for command in (
        ["git", "fetch", "-q", "origin", "HEAD"],
        ["git", "reset", "-q", "--hard", "FETCH_HEAD"],
        ["cmake", "--preset", "native", "--log-level=ERROR"],
        ["ninja", "-C", "build/native", "--quiet"],
    ):
        subprocess.run(command, cwd=TREE, check=True, stdout=subprocess.DEVNULL)


def candidates(folders: Sequence[str]) -> list[Mutant]:
    files = subprocess.run(
        ["git", "ls-files", *(f"{folder}/*.c" for folder in folders)],
        cwd=TREE, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    listed = subprocess.run(
        [VENV / "bin" / "python", "-c", LIST],
        cwd=TREE, input=files, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        check=True,
    ).stdout  # fmt: skip
    return [
        Mutant(path, number, text)
        for path, changes in sorted(json.loads(listed).items())
        for number, text in changes
    ]


def objects(path: str) -> list[str]:
    """What the build makes of a source file: it may be in several programs."""
    commands = json.loads((BUILD / "compile_commands.json").read_text())
    words = [
        shlex.split(command["command"])
        for command in commands
        if Path(command["directory"], command["file"]).resolve() == TREE / path
    ]
    return [command[command.index("-o") + 1] for command in words]


def digest(outputs: Sequence[str]) -> str:
    """Of the code and data in objects, without what a debugger reads."""
    total = hashlib.sha256()
    for output in outputs:
        bare = PLACE / "bare.o"
        subprocess.run(["objcopy", "--strip-debug", BUILD / output, bare], check=True)
        total.update(bare.read_bytes())
    return total.hexdigest()


def killer() -> str:
    """What notices; "": nothing does."""
    python = str(TREE / ".venv" / "bin" / "python")
    jobs = str(len(os.sched_getaffinity(0)))
    wire = [python, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-n", jobs]
    wire += ["tests", "host"]
    worlds = [python, "tests/sim/world/simulate.py", "--seeds", WORLDS]
    if not run("ctest", "--test-dir", BUILD, "-j", jobs, "--stop-on-failure", timeout_s=C_TESTS_S):
        return "C tests"
    if not run(*wire, timeout_s=WIRE_S, PHAROS_BUILD=str(BUILD)):
        return "wire"
    return "" if run(*worlds, timeout_s=WIRE_S, PHAROS_BUILD=str(BUILD)) else "worlds"


def outcomes(sample: Iterator[Mutant], count: int) -> Iterator[tuple[Mutant, str]]:
    """The first `count` that compile to something else, each with what killed it."""
    ninja = ["ninja", "-C", str(BUILD), "--quiet"]
    while count > 0 and (mutant := next(sample, None)) is not None:
        outputs = objects(mutant.path)
        file = TREE / mutant.path
        original = file.read_text()
        before = digest(outputs) if outputs else ""
        lines = original.splitlines(keepends=True)
        lines[mutant.line - 1] = mutant.text
        file.write_text("".join(lines))
        try:
            if not outputs or not run(*ninja, *outputs) or digest(outputs) == before:
                continue
            count -= 1
            yield mutant, killer() if run(*ninja) else "the build"
        finally:
            file.write_text(original)
            run(*ninja, *outputs)


def report(results: Sequence[tuple[Mutant, str]]) -> None:
    by_folder = defaultdict(list)
    for mutant, killed_by in results:
        by_folder[mutant.folder].append(killed_by)
    print(f"\n{'folder':<24}{'mutants':>8}{'killed':>8}{'rate':>8}")
    for folder, killers in by_folder.items():
        killed = sum(map(bool, killers))
        print(f"{folder:<24}{len(killers):>8}{killed:>8}{100 * killed / len(killers):>7.1f}%")
    for mutant in (mutant for mutant, killed_by in results if not killed_by):
        print(f"survived: {mutant}")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="*", metavar="FOLDER", help=f"of: {', '.join(FOLDERS)}")
    parser.add_argument("--count", type=int, default=300, help="mutants to try; default: 300")
    parser.add_argument("--seed", type=int, default=1, help="of the sample; default: 1")
    args = parser.parse_args()
    if unknown := [folder for folder in args.folders if folder not in FOLDERS]:
        parser.error(f"no folder {', '.join(unknown)}; there are: {', '.join(FOLDERS)}")
    # A job in a script's background ignores SIGINT, which tests send to what they start.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    prepare()
    if killed_by := killer():
        print(f"mutants: without any change, this fails: {killed_by}", file=sys.stderr)
        return 1
    found = candidates(args.folders or FOLDERS)
    random.Random(args.seed).shuffle(found)
    print(f"{args.count} of {len(found)} mutants, seed {args.seed}", flush=True)
    results = []
    for mutant, killed_by in outcomes(iter(found), args.count):
        results.append((mutant, killed_by))
        print(f"{killed_by or 'SURVIVED':<10}{mutant}", flush=True)
    report(results)
    return 0


if __name__ == "__main__":
    sys.exit(main())
