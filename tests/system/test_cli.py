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
        ["--uart0", "udpin:not an address:14550"],
        ["--uart0", "udppair:127.0.0.1:0"],
        ["--uart0", "serial:/dev/null,fast"],
        ["--uart0", "pty:"],
        ["--uart9", "udpin:127.0.0.1:0"],
        ["--time", "virtual", "--until", "yesterday"],
        ["--record", "/nonexistent/folder/file.vcd"],
        ["--trace", "/nonexistent/folder/file"],
        ["--control", "/nonexistent/folder/socket"],
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
    culprit = options[1] if len(options) > 1 and options[0] == "--time" else options[-1]
    assert culprit.split(":")[0] in lines[0] or options[0].lstrip("-") in lines[0]


def test_address_in_use_is_one_line_and_exit_status_2() -> None:
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        result = _run("--uart0", f"udpin:{address}", "--time", "virtual", "--until", "1s")
    assert result.returncode == 2
    assert len(result.stderr.splitlines()) == 1
    assert address in result.stderr


def test_help_names_every_wire_and_is_not_an_error() -> None:
    result = _run("--help")
    assert result.returncode == 0
    for word in ("--uart0", "--time", "--control", "--seed", "--record", "--trace", "udpin"):
        assert word in result.stdout


def test_until_ends_a_free_virtual_run() -> None:
    result = _run("--time", "virtual", "--until", "1h", "--console", "none")
    assert result.returncode == 0, result.stderr
