# SPDX-License-Identifier: Apache-2.0
"""Hold the core, the protocols and their generated code to what a Cortex-M4 may spend on them.

Compiles each module of budget.toml with Debian's arm-none-eabi-gcc, -Os and -Werror, prints flash,
RAM and the worst stack, and fails where a module exceeds its budget, or needs arithmetic in double
precision or printf. No Zephyr is needed.

Stack is the deepest chain of calls from any function of the module, through every module here.
What is called through a pointer, and the C library, is not in it.

Also compiles them without each option that minimal.conf leaves out, and without all of those.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUDGET = Path(__file__).resolve().with_name("budget.toml")
MINIMAL = ROOT / "minimal.conf"
PREFIX = "arm-none-eabi-"

CPU = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]
FLAGS = [
    *CPU, "-Os", "-std=gnu11", "-Wall", "-Wextra", "-Werror", "-Wshadow", "-Wno-unused-parameter",
    "-Wdouble-promotion", "-Wstrict-prototypes", "-ffunction-sections", "-fdata-sections",
    "-fno-common", "-fcallgraph-info=su",
]  # fmt: skip

# The EABI's helpers for double precision, and everything that formats text.
HEAVY = re.compile(r"^(__aeabi_(d\w+|cd\w+|[a-z]+2d)|\w*printf\w*)$")


class BudgetError(Exception):
    """The measurement could not be made."""


@dataclass
class Module:
    """A row of budget.toml, and what was measured."""

    name: str
    sources: list[str]
    budget: dict[str, int]
    objects: list[Path] = field(default_factory=list)
    measured: dict[str, int] = field(default_factory=dict)
    heavy: list[str] = field(default_factory=list)


@dataclass
class Graph:
    """Who calls whom, and each function's own frame, by the compiler's unique names."""

    frames: dict[str, int] = field(default_factory=dict)
    calls: dict[str, set[str]] = field(default_factory=dict)
    depths: dict[str, int] = field(default_factory=dict)

    def read(self, text: str) -> set[str]:
        """Add one file's .ci; the functions that it defines."""
        defined = set()
        for title, label in re.findall(r'node: \{ title: "([^"]+)" label: "([^"]*)"', text):
            size = re.search(r"(\d+) bytes \((static|dynamic|dynamic,bounded)\)", label)
            if size is not None:
                if size[2] == "dynamic":
                    raise BudgetError(f"{title}: its stack has no bound")
                self.frames[title] = int(size[1])
                defined.add(title)
        for source, target in re.findall(
            r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text
        ):
            self.calls.setdefault(source, set()).add(target)
        return defined

    def depth(self, function: str, above: tuple[str, ...] = ()) -> int:
        if function in above:
            raise BudgetError("recursion: " + " -> ".join([*above, function]))
        if function not in self.depths:
            callees = self.calls.get(function, set())
            deepest = max((self.depth(f, (*above, function)) for f in callees), default=0)
            self.depths[function] = self.frames.get(function, 0) + deepest
        return self.depths[function]


def run(*command: str | Path) -> str:
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        raise BudgetError(f"{' '.join(words)}\n{done.stdout}{done.stderr}")
    return done.stdout


def configure(build: Path, *fragments: Path) -> None:
    run(
        sys.executable, "boards/native/scripts/kconfig.py",
        "--kconfig", ROOT / "Kconfig", "--srctree", ROOT / "boards/native/kconfig",
        "--out", build, "--sources", build / "kconfig_sources.txt", ROOT / "prj.conf", *fragments,
    )  # fmt: skip


def generate(build: Path) -> list[str]:
    """What the build makes before it compiles; the flags that find it."""
    configure(build)
    run(sys.executable, "app/proto/mavlink/generate.py", "--out", build / "mavlink")
    run(sys.executable, "app/proto/dronecan/generate.py", build / "proto/dronecan")
    return [
        "-imacros", str(build / "autoconf.h"), "-I", "app", "-I", "drivers/include",
        "-I", str(build), "-isystem", str(build / "mavlink/include"),
    ]  # fmt: skip


def find(pattern: str, build: Path) -> list[Path]:
    base, below = (build, pattern.removeprefix("build:")) if ":" in pattern else (ROOT, pattern)
    found = sorted(base.glob(below))
    if not found:
        raise BudgetError(f"budget.toml: no file matches {pattern}")
    return found


def sections(objects: list[Path]) -> dict[str, int]:
    """Bytes of flash and RAM, before the linker drops what nothing calls."""
    sizes = {"flash": 0, "ram": 0}
    for name, size in re.findall(
        r"^(\.\S+)\s+(\d+)\s+\d+$", run(PREFIX + "size", "-A", *objects), re.MULTILINE
    ):
        if name.startswith((".text", ".rodata", ".data")):
            sizes["flash"] += int(size)
        if name.startswith((".data", ".bss")):
            sizes["ram"] += int(size)
    return sizes


def compile_module(module: Module, flags: list[str], build: Path, graph: Graph) -> set[str]:
    defined: set[str] = set()
    folder = build / "objects" / module.name
    folder.mkdir(parents=True)
    for source in [path for pattern in module.sources for path in find(pattern, build)]:
        output = folder / f"{source.stem}.o"
        run(PREFIX + "gcc", *FLAGS, *flags, "-c", source, "-o", output)
        module.objects.append(output)
        defined |= graph.read(output.with_suffix(".ci").read_text())
    return defined


def measure(modules: list[Module], build: Path) -> None:
    flags = generate(build)
    graph = Graph()
    defined = {module.name: compile_module(module, flags, build, graph) for module in modules}
    for module in modules:
        module.measured = sections(module.objects)
        module.measured["stack"] = max(graph.depth(name) for name in defined[module.name])
        undefined = run(PREFIX + "nm", "-u", *module.objects)
        module.heavy = sorted(
            {name for name in re.findall(r" U (\S+)", undefined) if HEAVY.match(name)}
        )


def sources_of(option: str) -> set[str]:
    """Names of the files that are built with the option alone."""
    found: set[str] = set()
    for lists in (ROOT / "app").rglob("CMakeLists.txt"):
        text = lists.read_text()
        for block in re.findall(rf"^if\({option}\)\n(.*?)^endif", text, re.MULTILINE | re.DOTALL):
            found |= set(re.findall(r"\b(\w+\.c)\b", block))
            found |= {
                path.name
                for folder in re.findall(r"add_subdirectory\((\w+)\)", block)
                for path in (lists.parent / folder).glob("*.c")
            }
    return found


def compile_without(modules: list[Module]) -> int:
    """Compile what is left without minimal.conf's options; how many ways."""
    lines = re.findall(r"^(CONFIG_PHAROS_\w+)=n$", MINIMAL.read_text(), re.MULTILINE)
    ways = [(option,) for option in lines] + [tuple(lines)]
    for way in ways:
        left_out = set().union(*(sources_of(option) for option in way))
        with tempfile.TemporaryDirectory() as folder:
            build = Path(folder)
            flags = generate(build)
            fragment = build / "without.conf"
            fragment.write_text("".join(f"{option}=n\n" for option in way))
            configure(build, fragment)
            rest = [
                path
                for module in modules
                for pattern in module.sources
                for path in find(pattern, build)
                if path.name not in left_out
            ]
            try:
                run(PREFIX + "gcc", *CPU, "-std=gnu11", "-fsyntax-only", *flags, *rest)
            except BudgetError as error:
                raise BudgetError(f"without {', '.join(way)}:\n{error}") from error
    return len(ways)


def report(modules: list[Module]) -> list[str]:
    """Print the table; the lines that say what is over budget."""
    kinds = ("flash", "ram", "stack")
    print(f"{'module':<12}" + "".join(f"{kind:>9}{'of':>9}" for kind in kinds))
    wrong = []
    for module in modules:
        cells = ""
        for kind in kinds:
            cells += f"{module.measured[kind]:>9}{module.budget[kind]:>9}"
            if module.measured[kind] > module.budget[kind]:
                wrong.append(
                    f"{module.name}: {kind} {module.measured[kind]} bytes, "
                    f"budget {module.budget[kind]} (tests/budget/budget.toml)"
                )
        print(f"{module.name:<12}{cells}")
        wrong += [f"{module.name} pulls in {name}" for name in module.heavy]
    return wrong


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    if shutil.which(PREFIX + "gcc") is None:
        print(
            "budget: arm-none-eabi-gcc is missing; as root: "
            "apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi",
            file=sys.stderr,
        )
        return 1
    rows = tomllib.loads(BUDGET.read_text())
    modules = [
        Module(name, row["sources"], {kind: row[kind] for kind in ("flash", "ram", "stack")})
        for name, row in rows.items()
    ]
    try:
        with tempfile.TemporaryDirectory() as folder:
            measure(modules, Path(folder))
        ways = compile_without(modules)
    except BudgetError as error:
        print(f"budget: {error}", file=sys.stderr)
        return 1
    wrong = report(modules)
    for line in wrong:
        print(f"over budget: {line}", file=sys.stderr)
    print(f"{len(modules)} modules, {len(wrong)} over budget; compiled {ways} ways with less in it")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
