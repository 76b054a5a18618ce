# SPDX-License-Identifier: Apache-2.0
"""No module of these folders includes, by whatever way, one that includes it.

A module is a `.c` and its `.h`, and with them what its own files share (`…_internal.h`). Whoever
reads, tests or moves one then needs what is below it, and nothing else.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# What a quoted include may start from, beside its own folder.
BASES = ("app", "boards/native", "boards/native/drivers", "drivers/include")
FOLDERS = [
    "app/core",
    "app/threads",
    "boards/native/drivers",
    "boards/native/host",
    "boards/native/kernel",
    "boards/native/models",
    "boards/native/subsys",
    "drivers",
]
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)

Graph = dict[Path, set[Path]]


def _sources(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.suffix in (".c", ".h"))


def _module(path: Path) -> Path:
    return path.with_name(path.stem.removesuffix("_internal"))


def modules(folder: Path, bases: list[Path]) -> Graph:
    """Each module below the folder, and those there that it includes."""
    graph: Graph = {}
    for path in _sources(folder):
        its = graph.setdefault(_module(path), set())
        for name in INCLUDE.findall(path.read_text()):
            found = next(
                (file for base in (path.parent, *bases) if (file := base / name).is_file()), None
            )
            if found is not None and found.resolve().is_relative_to(folder.resolve()):
                its.add(_module(found.resolve()))
    return {module: its - {module} for module, its in graph.items()}


def circles(graph: Graph) -> list[list[Path]]:
    """One way round for each module that can be reached from itself, shortest first, once each."""
    found: dict[frozenset[Path], list[Path]] = {}
    for start in graph:
        ways: list[list[Path]] = [[start]]
        seen = {start}
        while ways:
            way = ways.pop(0)
            for module in sorted(graph.get(way[-1], ())):
                if module == start:
                    found.setdefault(frozenset(way), [*way, start])
                elif module not in seen:
                    seen.add(module)
                    ways.append([*way, module])
    return sorted(found.values(), key=len)


@pytest.mark.parametrize("folder", FOLDERS)
def test_no_module_includes_itself_by_way_of_others(folder: str) -> None:
    graph = modules(ROOT / folder, [ROOT / base for base in BASES])
    assert graph, f"{folder} is empty or missing: this rule looks at nothing"
    told = [" → ".join(str(p.relative_to(ROOT / folder)) for p in way) for way in circles(graph)]
    assert not told, "\n".join(told)


def test_the_rule_sees_a_circle(tmp_path: Path) -> None:
    for name, text in {
        "a.h": '#include "b.h"\n',
        "b.c": '#include "b.h"\n#include "sub/c.h"\n',
        "b.h": "",
        "sub/c.h": '#include "a.h"\n#include "nowhere.h"\n',
        "d.c": '#include "a.h"\n',
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    graph = modules(tmp_path, [tmp_path])
    assert [p.name for p in circles(graph)[0]] == ["a", "b", "c", "a"]
    assert len(circles(graph)) == 1
    (tmp_path / "sub/c.h").write_text("")
    assert not circles(modules(tmp_path, [tmp_path]))
