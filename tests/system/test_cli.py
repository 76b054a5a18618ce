# SPDX-License-Identifier: Apache-2.0
"""The command line: what is wrong is said in one line, with exit status 2."""

from __future__ import annotations

import subprocess

import pytest

from harness import BINARY


def _run(*options: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(BINARY), *options],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )


@pytest.mark.parametrize(
    "options",
    [
        ["--nonsense"],
        ["--time"],
        ["--time", "sideways"],
        ["--seed", "x"],
        ["--seed", "-1"],
        ["--uart0", "carrier-pigeon:home"],
        ["--uart0", "udpin:127.0.0.1"],
        ["--uart0", "udpin:127.0.0.1:99999"],
        ["--uart0", "udppair:127.0.0.1:0"],
        ["--uart0", "serial:/dev/null,fast"],
        ["--uart0", "pty:"],
        ["--uart9", "udpin:127.0.0.1:0"],
        ["--time", "virtual", "--until", "yesterday"],
        ["stray"],
    ],
    ids=" ".join,
)
def test_bad_option_is_one_line_and_exit_status_2(options: list[str]) -> None:
    result = _run(*options)
    assert result.returncode == 2
    lines = result.stderr.splitlines()
    assert len(lines) == 1, result.stderr
    assert len(lines[0]) < 300
    named = [word for word in options if word.startswith("--")][-1:] or options
    assert named[0] in lines[0], "the line names what is wrong"


@pytest.mark.parametrize("option", ["--record", "--trace", "--control"])
def test_file_that_cannot_be_made_is_one_line_that_names_it(option: str) -> None:
    result = _run(option, "/nonexistent/folder/file", "--time", "virtual", "--until", "1s")
    assert result.returncode in (1, 2)
    lines = result.stderr.splitlines()
    assert len(lines) == 1, result.stderr
    assert option in lines[0]
    assert "/nonexistent/folder/file" in lines[0]


def test_help_names_every_wire_and_is_not_an_error() -> None:
    result = _run("--help")
    assert result.returncode == 0
    for word in ("--uart0", "--time", "--control", "--seed", "--record", "--trace", "udpin"):
        assert word in result.stdout


def test_until_ends_a_free_virtual_run() -> None:
    result = _run("--time", "virtual", "--until", "1h", "--console", "none")
    assert result.returncode == 0, result.stderr
