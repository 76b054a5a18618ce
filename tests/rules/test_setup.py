# SPDX-License-Identifier: Apache-2.0
"""The set-up: Debian's own interpreter and compilers, and what make's help and stages say of it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()


def test_the_interpreter_is_debians() -> None:
    assert Path(sys.prefix) == ROOT / ".venv"
    assert sys.base_prefix == "/usr"


def test_the_build_took_debians_compiler_and_this_interpreter() -> None:
    cache = (BUILD / "CMakeCache.txt").read_text()
    compiler = re.search(r"^CMAKE_C_COMPILER:\w+=(.*)$", cache, re.MULTILINE)
    python = re.search(r"^Python3_EXECUTABLE:\w+=(.*)$", cache, re.MULTILINE)
    assert compiler is not None
    assert python is not None
    assert Path(compiler[1]).parent == Path("/usr/bin")
    assert Path(python[1]) == ROOT / ".venv" / "bin" / "python"


def make(*words: str) -> str:
    done = subprocess.run(["make", "-C", ROOT, *words], capture_output=True, text=True, check=True)
    return done.stdout


def test_make_alone_prints_its_help() -> None:
    assert make() == make("help")


def test_help_tells_of_every_target() -> None:
    """All but those that only others need."""
    told = re.findall(r"^make ([\w-]+)  +\S", make("help"), re.MULTILINE)
    phony = re.findall(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert sorted(told) == sorted(set(" ".join(phony).split()) - {"tools", "test-tools"})


@pytest.mark.parametrize("name", ["Makefile", "README.md", "CONTRIBUTING.md", ".ci/run"])
def test_stages_that_are_named_are_there(name: str) -> None:
    usage = subprocess.run(
        [sys.executable, ROOT / "tests" / "run.py", "--help"],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    there = re.search(r"any of: ([^;]*);", usage.replace("\n", " "))
    assert there is not None
    stages = {stage.strip() for stage in there[1].split(",")}
    path = ROOT / name
    text = path.read_text() if path.exists() else ""
    named = re.findall(r'STAGES="?([\w -]+)|tests/run\.py ([a-z][\w-]*)', text)
    assert {stage for pair in named for stage in " ".join(pair).split()} <= stages


def test_one_version_is_told_by_all() -> None:
    header = (ROOT / "app" / "version.h").read_text()
    numbers = re.findall(r"^#define PHAROS_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", header, re.M)
    told = ".".join(numbers)
    assert re.fullmatch(r"\d+\.\d+\.\d+", told)
    assert version("pharos") == told
    done = subprocess.run([BUILD / "pharos", "--version"], capture_output=True, text=True)
    assert done.stdout == f"pharos {told} (native)\n"


def test_no_two_files_of_tests_share_a_name() -> None:
    """pytest takes the second for the first and collects neither."""
    files = subprocess.run(
        ["git", "ls-files", "*/test_*.py"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split()
    names = [Path(file).name for file in files]
    assert len(names) > 1
    assert sorted({name for name in names if names.count(name) > 1}) == []
