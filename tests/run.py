# SPDX-License-Identifier: Apache-2.0
"""Run the stages of `make test`, go on past a failing one, and close with one summary.

Each stage is a row: how to build, what to run, and how many tests passed and failed in it.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tests" / "linux"), str(ROOT / "tests" / "qemu")]

import images  # noqa: E402

import guest  # noqa: E402

VENV = ROOT / ".venv" / "bin"
CORES = len(os.sched_getaffinity(0))
FUZZ_RUNS_SHORT = 200_000
# Of these harnesses a run is as long as so many of the others.
FUZZ_LONG = {"fuzz_command": 10}


@dataclass
class Outcome:
    """What a stage found: tests passed and failed, the command that repeats a failure, and what
    else the summary has to say."""

    passed: int = 0
    failed: int = 0
    replay: str = ""
    note: str = ""

    def __add__(self, other: Outcome) -> Outcome:
        return Outcome(
            self.passed + other.passed,
            self.failed + other.failed,
            self.replay or other.replay,
            self.note or other.note,
        )


def run(*command: str | Path, env: dict[str, str] | None = None) -> tuple[int, str]:
    """Run a command at the root, show its output as it comes, and return (exit code, output)."""
    words = [str(word) for word in command]
    print("$", textwrap.shorten(shlex.join(words), 200), flush=True)
    process = subprocess.Popen(
        words,
        cwd=ROOT,
        env={**os.environ, **(env or {})},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        text=True,
        errors="replace",
    )
    assert process.stdout is not None
    lines = []
    for line in process.stdout:
        print(line, end="", flush=True)
        lines.append(line)
    return process.wait(), "".join(lines)


def check(*command: str | Path, mend: str = "") -> Outcome:
    """A command that is one test: it passes when it exits 0. mend: what to run when it does not."""
    code, _ = run(*command)
    if code == 0:
        return Outcome(passed=1)
    return Outcome(failed=1, replay=mend or shlex.join(str(word) for word in command))


def build(preset: str) -> Outcome:
    if not (ROOT / "build" / preset / "build.ninja").exists():
        configured = check("cmake", "--preset", preset, "--log-level=NOTICE")
        if configured.failed:
            return configured
    return check("cmake", "--build", f"build/{preset}", "--", "--quiet")


def ctest(preset: str) -> Outcome:
    code, output = run(
        "ctest", "--test-dir", f"build/{preset}", "--output-on-failure", "-j", str(CORES)
    )
    found = re.search(r"(\d+) tests? failed out of (\d+)", output)
    if found is None:
        return Outcome(failed=1, replay=f"ctest --test-dir build/{preset}")
    failed, total = int(found[1]), int(found[2])
    replay = f"ctest --test-dir build/{preset} --rerun-failed --output-on-failure" if code else ""
    return Outcome(total - failed, max(failed, int(code != 0)), replay)


def pytest(preset: str, *where: str, **env: str) -> Outcome:
    command: list[str | Path] = [VENV / "python", "-m", "pytest", "-q", "-n", str(CORES), *where]
    code, output = run(*command, env={"PHAROS_BUILD": str(ROOT / "build" / preset), **env})
    passed = re.search(r"(\d+) passed", output)
    failed = sum(int(n) for n in re.findall(r"(\d+) (?:failed|errors?)\b", output.splitlines()[-1]))
    if passed is None or code != 0:
        failed = max(failed, 1)
    again = f".venv/bin/python -m pytest {' '.join(where)} --last-failed"
    replay = f"PHAROS_BUILD=build/{preset} {again}" if failed else ""
    return Outcome(int(passed[1]) if passed else 0, failed, replay, guest.failures(output))


def suite(preset: str, *where: str) -> Outcome:
    """The suite on one build: C tests, then the tests over the wire."""
    built = build(preset)
    if built.failed:
        return built
    return ctest(preset) + pytest(preset, *where)


def lint(_: argparse.Namespace) -> Outcome:
    tracked = subprocess.run(
        ["git", "ls-files", "*.c", "*.h"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split()
    scripts = ["make", ".ci/run", "boards/native/setup.sh", "tests/linux/init.sh"]
    python = ["host", "tests", "boards", "app", "docs"]
    return (
        check(VENV / "clang-format", "--dry-run", "-Werror", *tracked, mend="make format")
        + check(VENV / "ruff", "check", *python)
        + check(VENV / "ruff", "format", "--check", *python, mend="make format")
        + check(VENV / "mypy", "--config-file", "host/pyproject.toml", "host/src", "tests")
        + check("shellcheck", *scripts)
    )


def linux(_: argparse.Namespace) -> Outcome:
    """What touches a kernel, against a real one: SocketCAN and GPIO in a guest."""
    built = build("native")
    if built.failed:
        return built
    result = guest.stage("native")
    return Outcome(result.passed, result.failed, result.replay, result.note)


def world(_: argparse.Namespace) -> Outcome:
    """Worlds of lights, faults and attackers in which every promise must hold."""
    built = build("native")
    if built.failed:
        return built
    code, output = run(VENV / "python", "tests/sim/world/simulate.py")
    found = re.search(r"^(\d+) passed, (\d+) failed$", output, re.MULTILINE)
    if found is None:
        return Outcome(failed=1, replay="make simulate")
    failed = max(int(found[2]), int(code != 0))
    return Outcome(int(found[1]), failed, "make simulate" if failed else "")


def budget(_: argparse.Namespace) -> Outcome:
    return check(VENV / "python", "tests/budget/budget.py")


def fuzz(args: argparse.Namespace) -> Outcome:
    outcome = build("fuzz")
    if outcome.failed:
        return outcome
    harnesses = sorted((ROOT / "build" / "fuzz" / "tests" / "fuzz").glob("fuzz_*"))
    for harness in (path for path in harnesses if path.is_file() and os.access(path, os.X_OK)):
        corpus = ROOT / "build" / "fuzz" / "corpus" / harness.name
        corpus.mkdir(parents=True, exist_ok=True)
        runs = args.fuzz_runs // FUZZ_LONG.get(harness.name, 1)
        flags = [f"-runs={runs}", "-seed=1", "-timeout=10", "-verbosity=0"]
        flags += ["-print_final_stats=1", f"-artifact_prefix={corpus}-"]
        outcome += check(harness, *flags, corpus)
    return outcome


def zephyr(_: argparse.Namespace) -> Outcome:
    """Upstream Zephyr, where a tree of it is at hand: twister, every image and its budget, and what
    runs in QEMU."""
    base = os.environ.get("ZEPHYR_BASE")
    if base is None:
        return Outcome(note="left out, not run: ZEPHYR_BASE names no Zephyr tree (docs/boards.md)")
    version = images.zephyr_version(Path(base))
    again = f"ZEPHYR_BASE={base} tests/run.py zephyr"
    # The tests over the wire take the MAVLink dialect from it.
    outcome = build("native")
    for name in images.TARGETS:
        outcome += check(VENV / "python", "tests/qemu/images.py", name)
    for name, where in images.IN_QEMU.items():
        elf = images.folder(name) / "zephyr" / "zephyr.elf"
        outcome += pytest("native", *where, PHAROS_QEMU_IMAGE=str(elf))
    twister: list[str | Path] = [
        Path(base) / "scripts" / "twister",
        "-T",
        ".",
        "-A",
        "boards",
        "--force-toolchain",
    ]
    # Its filter reads devicetrees without CMakeLists.txt; 4.1.99 refuses an unknown vendor.
    twister.append(f"-x=DTS_ROOT={ROOT / 'drivers'}")
    twister += ["-O", images.folder("twister"), "--clobber-output", "--inline-logs"]
    for board in dict.fromkeys(target.board for target in images.TARGETS.values()):
        twister += ["-p", images.board_name(board, version)]
    code, output = run(*twister, env=images.environment("arm"))
    counts = re.search(r"(\d+) of (\d+) (?:executed )?test configurations passed", output)
    if counts is None:
        return outcome + Outcome(failed=1, replay=again)
    passed, total = int(counts[1]), int(counts[2])
    return outcome + Outcome(passed, max(total - passed, int(code != 0)), again if code else "")


STAGES: dict[str, Callable[[argparse.Namespace], Outcome]] = {
    "lint": lint,
    "native": lambda _: suite("native", "tests", "host"),
    "world": world,
    "linux": linux,
    "budget": budget,
    "zephyr": zephyr,
    "asan-gcc": lambda _: suite("native-asan", "tests", "host"),
    # The host's tests are of Python: one build with a sanitizer behind them is enough.
    "asan-clang": lambda _: suite("native-asan-clang", "tests"),
    "fuzz": fuzz,
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stages", nargs="*", help=f"any of: {', '.join(STAGES)}; default: all")
    parser.add_argument(
        "--fuzz-runs", type=int, default=FUZZ_RUNS_SHORT, help="executions of each fuzz harness"
    )
    args = parser.parse_args()
    unknown = [name for name in args.stages if name not in STAGES]
    if unknown:
        parser.error(f"no stage {', '.join(unknown)}; there are: {', '.join(STAGES)}")

    # A job in a script's background ignores SIGINT, which tests send to what they start.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rows = []
    for name in args.stages or STAGES:
        print(f"\n=== {name}", flush=True)
        start = time.monotonic()
        outcome = STAGES[name](args)
        rows.append((name, outcome, time.monotonic() - start))

    print(f"\n{'stage':<12}{'passed':>8}{'failed':>8}{'seconds':>9}")
    for name, outcome, seconds in rows:
        print(f"{name:<12}{outcome.passed:>8}{outcome.failed:>8}{seconds:>9.0f}")
        if outcome.note:
            print(f"  {outcome.note}")
        if outcome.failed and outcome.replay:
            print(f"  again: {outcome.replay}")
    total = sum((outcome for _, outcome, _ in rows), Outcome())
    print(f"\n{total.passed} passed, {total.failed} failed")
    return int(total.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
