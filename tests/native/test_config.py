# SPDX-License-Identifier: Apache-2.0
"""--config: options in a file; --check and --dump-config."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from echo_light import PATIENCE_S, Light, Start


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "pharos.conf"


def run(binary: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [binary, *words], capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )


def refusal(binary: Path, *words: str) -> str:
    """The one line with which it ends."""
    done = run(binary, *words, "--check")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    return done.stderr.removeprefix("echo_app: ").rstrip("\n")


def ambient(light: Light) -> int:
    return int(light.do("outputs")["ambient_mdegc"])


def test_options_of_the_file_are_in_force(start: Start, file: Path) -> None:
    file.write_text(
        "# a light\n\n; another comment\nambient = 55 ; degC\nuart1=tcpin:127.0.0.1:0\n"
    )
    light = start("--config", str(file))
    assert ambient(light) == 55000
    assert light.wire("uart1")["address"].startswith("tcpin:127.0.0.1:")
    assert ambient(start(f"--config={file}")) == 55000


@pytest.mark.parametrize("order", [("ambient", "config"), ("config", "ambient")])
def test_command_line_takes_the_place_of_the_file(
    start: Start, file: Path, order: tuple[str, ...]
) -> None:
    file.write_text("ambient = 55\n")
    values = {"config": str(file), "ambient": "-5"}
    light = start(*(word for name in order for word in (f"--{name}", values[name])))
    assert ambient(light) == -5000


def test_reset_keeps_what_was_read(start: Start, file: Path) -> None:
    file.write_text("ambient = 55\n")
    light = start("--config", str(file))
    file.write_text("nonsense\n")
    for _ in range(2):
        light.do("reset")
    file.unlink()
    light.do("reset")
    assert ambient(light) == 55000
    assert light.do("outputs")["resets"] == 3


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("ambient = 25\nambience = 3\n", "2: ambience: unknown option; --help lists all"),
        ("ambient = hot\n", "1: ambient: 'hot' is no temperature of -100 to 300 degrees Celsius"),
        ("\n\nambient\n", "3: not as NAME = VALUE"),
        ("ambient\nambience = 3\n", "1: not as NAME = VALUE"),
        ("ambience = 3\nambient\n", "1: ambience: unknown option; --help lists all"),
        ("[light]\nambient = 3\n",
         "2: ambient: no section [light]; options stand without one"),
        ("ambient = 1\nseed = 2\nambient = 3\n",
         "3: ambient: given in line 1 already (a line that begins with a blank goes on with the "
         "one before)"),
        ("seed = 1\n ambient = 3\n",
         "2: seed: given in line 1 already (a line that begins with a blank goes on with the one "
         "before)"),
        ("unsafe-simulated-sensor = maybe\n",
         '1: unsafe-simulated-sensor: "maybe" is neither yes nor no'),
        ("unsafe-simulated-sensor =\n", '1: unsafe-simulated-sensor: "" is neither yes nor no'),
        ("seed = 1\nuart0 = " + "x" * 300 + "\n", "2: longer than 199 bytes"),
        ("seed = \0\n", "1: not text"),
        ("config = other\n", "1: config: unknown option; --help lists all"),
    ],
)  # fmt: skip
def test_errors_name_file_line_and_option(binary: Path, file: Path, text: str, line: str) -> None:
    file.write_text(text)
    assert refusal(binary, "--config", str(file)) == f"{file}:{line}"


def test_file_that_cannot_be_read_is_one_line(binary: Path, file: Path) -> None:
    assert refusal(binary, "--config", str(file)) == f"{file}: No such file or directory"
    file.mkdir()
    assert refusal(binary, "--config", str(file)) == f"{file}: Is a directory"
    file.rmdir()
    file.write_text("# \n" * 30000)
    assert refusal(binary, "--config", str(file)) == f"{file}: more than 64 KiB"
    assert refusal(binary, "--config") == "--check: No such file or directory"
    assert run(binary, "--config").stderr == ("echo_app: --config needs a value: --config FILE\n")


def test_check_opens_nothing(binary: Path, file: Path, tmp_path: Path) -> None:
    file.write_text(f"settings = {tmp_path / 'settings'}\ncontrol = {tmp_path / 'control'}\n")
    done = run(binary, "--config", str(file), "--check")
    assert (done.returncode, done.stdout, done.stderr) == (0, "ok\n", "")
    assert list(tmp_path.iterdir()) == [file]


def test_dump_is_such_a_file_of_all_options(binary: Path, file: Path) -> None:
    text = run(binary, "--help").stdout
    options = set(re.findall(r"^  --([a-z0-9-]+)", text, re.MULTILINE))
    own = {"help", "version", "config", "check", "dump-config"}
    dumped = run(binary, "--ambient", "31.5", "--unsafe-simulated-sensor", "--dump-config").stdout
    names = re.findall(r"^(?:# )?([a-z0-9-]+) = ", dumped, re.MULTILINE)
    assert sorted(names) == sorted(options - own)
    given = [line for line in dumped.split("\n") if line and not line.startswith("#")]
    assert sorted(given) == ["ambient = 31.5", "unsafe-simulated-sensor = yes"]
    file.write_text(dumped)
    assert run(binary, "--config", str(file), "--dump-config").stdout == dumped


def test_flag_may_be_no(binary: Path, file: Path) -> None:
    file.write_text("unsafe-simulated-sensor = no\n")
    assert (
        "# unsafe-simulated-sensor = yes\n"
        in run(binary, "--config", str(file), "--dump-config").stdout
    )
