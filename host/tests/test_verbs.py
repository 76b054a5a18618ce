# SPDX-License-Identifier: Apache-2.0
"""Files, gimbal, self-test, reboot and key of a light, as its user reaches them."""

from __future__ import annotations

import json
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from model_files import ModelFiles
from model_light import ModelLight
from pharos import (
    CommandError,
    Light,
    MavlinkConnection,
    PharosError,
    SilentError,
    Simulator,
    UsageError,
)
from pharos.cli import main
from pharos.cli.key import change_key, make_key, read_key
from pharos.ftp import NOT_FOUND, FileClient, FileError, crc32
from pharos.parameters import Parameters
from real_light import RealLight


@pytest.fixture
def sim(binary: Path) -> Iterator[Simulator]:
    with Simulator(binary, {"uart0": "udpin:127.0.0.1:0"}) as sim:
        yield sim


@pytest.fixture
def light(sim: Simulator) -> Light:
    found = Light(sim.connect("uart0"))
    found.find()
    sim.advance(s=1)
    return found


# --- files ----------------------------------------------------------------------------------------
def test_files_are_listed_and_read(light: Light) -> None:
    files = FileClient(light)
    sizes = files.list_files()
    assert "general.json" in sizes
    parts: list[tuple[int, int]] = []
    content = files.read("/general.json", lambda at, of: parts.append((at, of)))
    assert len(content) == sizes["general.json"]
    assert json.loads(content)["modelName"] == "Illuminator"
    assert parts[-1] == (len(content), len(content))


def test_a_lossy_line_costs_no_byte(sim: Simulator, light: Light) -> None:
    files = FileClient(light)
    name = "parameters.json.xz"
    whole = files.read(name)
    sim.fault("uart0", "lost", rate_ppm=300)
    assert crc32(files.read(name)) == crc32(whole)


def test_what_is_no_file_is_said(light: Light) -> None:
    with pytest.raises(FileError, match="no such file") as caught:
        FileClient(light).read("/none")
    assert caught.value.error == NOT_FOUND


def test_a_light_without_files_is_told_of() -> None:
    model = ModelLight({"has no FTP"})
    found = Light(MavlinkConnection(model, model, model.d))
    found.find()
    with pytest.raises(SilentError, match="no files"):
        FileClient(found).list_files()


def test_a_file_that_ends_early_is_told_of() -> None:
    class Short(ModelFiles):
        def request(self, opcode: int, *args: Any) -> tuple[int, bytes, int]:
            error, data, session = super().request(opcode, *args)
            return error, (data[:4] if opcode == 4 else b""), session

    model = ModelLight({"has no end of file"})
    model.files = Short(model.faults, model.has)
    found = Light(MavlinkConnection(model, model, model.d))
    found.find()
    with pytest.raises(PharosError, match="ends at 0"):
        FileClient(found).read("/general.json")


# --- gimbal, self-test, reboot --------------------------------------------------------------------
def test_the_beam_is_pointed(sim: Simulator, light: Light) -> None:
    light.point(20, 10)
    assert light.connection.target.component == 243
    sim.advance(s=5)
    light.on()
    with pytest.raises(CommandError):
        light.point(float("nan"), float("inf"))


def test_the_self_test_is_waited_for(light: Light) -> None:
    progress: list[int] = []
    light.self_test(10, progress.append)
    assert progress == sorted(progress)
    assert len(progress) >= 3


def test_a_light_that_is_on_reboots_only_when_forced(sim: Simulator, light: Light) -> None:
    light.on()
    with pytest.raises(CommandError, match="busy"):
        light.reboot()
    light.reboot(force=True)
    sim.advance(s=3)
    assert sim.outputs()["resets"] == 1


# --- the key --------------------------------------------------------------------------------------
def test_a_key_is_set_and_taken_away(light: Light) -> None:
    key = bytes(range(32))
    with pytest.raises(PharosError, match="MAV_SECURE"):
        change_key(light, key)
    light.connection.sign(b"", 0)
    Parameters(light).set("MAV_SECURE", 1)
    change_key(light, key)
    light.on()
    light.off()
    change_key(light, b"")
    light.on()


def test_a_key_file_is_its_owners(tmp_path: Path) -> None:
    path = tmp_path / "key"
    key = make_key(str(path))
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert read_key(str(path)) == key
    with pytest.raises(UsageError, match="exists"):
        make_key(str(path))
    (tmp_path / "raw").write_bytes(bytes(range(32)))
    assert read_key(str(tmp_path / "raw")) == bytes(range(32))
    (tmp_path / "bad").write_text("word")
    for name in ("bad", "none", "\0"):
        with pytest.raises(UsageError):
            read_key(str(tmp_path / name))


@pytest.mark.realtime
def test_a_key_from_the_command_line(
    real_light: Callable[..., RealLight], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url, key = real_light("--uart0", "udpin:127.0.0.1:0").url(), str(tmp_path / "light.key")
    assert main(["param", "set", url, "MAV_SECURE", "1"]) == 0
    assert main(["signing", "setup", url, "--key-file", key]) == 0
    assert "a new key is in" in capsys.readouterr().out
    assert main(["on", url, "--key-file", key]) == 0
    capsys.readouterr()
    assert main(["on", url]) == 3
    assert "--key-file" in capsys.readouterr().err
    assert main(["check", url, "--only", "SG-4", "--key-file", key]) == 0
    assert main(["signing", "off", url, "--key-file", key]) == 0
    assert main(["off", url]) == 0


@pytest.mark.realtime
def test_files_from_the_command_line(
    real_light: Callable[..., RealLight],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    url = real_light("--uart0", "udpin:127.0.0.1:0").url()
    monkeypatch.chdir(tmp_path)
    assert main(["files", "list", url]) == 0
    assert "general.json" in capsys.readouterr().out
    assert main(["files", "get", url, "/general.json"]) == 0
    assert json.loads((tmp_path / "general.json").read_text())["vendorName"] == "Pharos"
    assert main(["files", "get", url, "none"]) == 1
    assert main(["files", "get", url, "general.json", "/nonexistent/x"]) == 1
