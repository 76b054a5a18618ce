# SPDX-License-Identifier: Apache-2.0
"""The shell on pipes: scripts in, what commands print out; settings in a file."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
APP = BUILD / "tests" / "subsys" / "shell_app"
DEADLINE_S = 20.0


def pipe(script: str, *options: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [APP, "--console", "stdio", *options],
        input=script,
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
    )


def test_on_pipes_there_is_only_what_commands_print() -> None:
    done = pipe("say a b\nfail\n\nnothing\nexit\n")
    assert done.stdout == "<a>\n<b>\nin red\nnothing: command not found\n"
    assert done.returncode == 0


def test_dos_line_ends_are_line_ends() -> None:
    assert pipe("say a\r\nsay b\r\nexit\r\n").stdout == "<a>\n<b>\n"


def test_settings_file_keeps_values(tmp_path: Path) -> None:
    path = tmp_path / "settings"
    option = f"--settings={path}"
    assert pipe("save light/level 42\nexit\n", option).stdout == "saved: 0\n"
    assert path.read_bytes().startswith(b"PHAROS settings 1\n")
    assert "light/level  2 bytes" in pipe("settings list\nexit\n", option).stdout
    assert f"file {path}" in pipe("settings status\nexit\n", option).stdout
    pipe("settings delete light/level\nexit\n", option)
    assert pipe("settings list\nexit\n", option).stdout == ""


def test_a_broken_settings_file_loses_one_record_and_says_so(tmp_path: Path) -> None:
    path = tmp_path / "settings"
    option = f"--settings={path}"
    pipe("save first 11111\nsave second 22222\nexit\n", option)
    content = bytearray(path.read_bytes())
    content[content.index(b"11111")] ^= 1
    path.write_bytes(content)
    done = pipe("settings list\nexit\n", option)
    assert "second  5 bytes" in done.stdout
    assert "first" not in done.stdout
    assert "1 broken records left out" in done.stdout + done.stderr


def test_a_file_that_is_no_settings_file_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "letter"
    path.write_text("Dear all,\n")
    done = pipe("save a 1\nexit\n", f"--settings={path}")
    assert "not a settings file" in done.stdout + done.stderr
    assert "saved: -" in done.stdout
    assert path.read_text() == "Dear all,\n"


def test_settings_in_a_folder_that_is_not_there(tmp_path: Path) -> None:
    """Nothing starts that could not keep what it accepts."""
    done = pipe("save a 1\nexit\n", f"--settings={tmp_path}/no/file")
    assert (done.returncode, done.stdout) == (1, "")
    said = [line for line in done.stderr.splitlines() if "--settings" in line]
    assert said == [f"pharos: --settings: {tmp_path}/no/file: No such file or directory"]


def test_settings_option_wants_a_file(tmp_path: Path) -> None:
    done = pipe("", f"--settings={tmp_path}")
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "not a regular file" in done.stderr
