# SPDX-License-Identifier: Apache-2.0
"""The package as it is published: an sdist that needs nothing of the rest of the tree."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

HOST = Path(__file__).resolve().parents[1]
MAVLINK = HOST.parent / "app" / "proto" / "mavlink"
BUILD_SDIST = "import sys; from setuptools import build_meta; build_meta.build_sdist(sys.argv[1])"


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sdist's folder; whatever in it is neither a file nor a folder is refused."""
    folder = tmp_path_factory.mktemp("sdist")
    run(BUILD_SDIST, str(folder), cwd=HOST)
    (archive,) = folder.glob("pharos-*.tar.gz")
    with tarfile.open(archive) as tar:
        assert [member.name for member in tar if not (member.isfile() or member.isdir())] == []
    subprocess.run(["tar", "-xzf", archive, "-C", folder], check=True)
    return folder / archive.name.removesuffix(".tar.gz")


def run(program: str, *args: str, cwd: Path, **environment: str) -> str:
    env = {name: text for name, text in os.environ.items() if name != "PHAROS_DIALECT"}
    done = subprocess.run(
        [sys.executable, "-c", program, *args],
        cwd=cwd, env=env | environment, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_what_the_firmware_shares_is_in_it(unpacked: Path) -> None:
    package = unpacked / "src" / "pharos"
    shared = {"generate.py": MAVLINK, "pharos.xml": MAVLINK / "dialect"}
    for name, folder in shared.items():
        assert (package / "mavlink" / name).read_bytes() == (folder / name).read_bytes()
    version = (HOST.parent / "app" / "version.h").read_bytes()
    assert (package / "version.h").read_bytes() == version
    assert (package / "py.typed").exists()
    assert not (unpacked / "tests").exists()


def test_it_runs_on_its_own_and_makes_its_dialect(unpacked: Path, tmp_path: Path) -> None:
    program = (
        "import pharos, can; dialect = pharos.load_dialect();"
        "print(pharos.__file__, dialect.__file__, dialect.MAVLINK_MSG_ID_ILLUMINATOR_STATUS)"
    )
    source = unpacked / "src"
    out = run(program, cwd=tmp_path, PYTHONPATH=str(source), XDG_CACHE_HOME=str(tmp_path))
    package, dialect, message = out.split()
    assert Path(package).is_relative_to(source)
    assert Path(dialect).is_relative_to(tmp_path)
    assert message == "440"


def test_its_commands_and_its_can_interface_are_registered(unpacked: Path) -> None:
    (entries,) = unpacked.glob("src/*.egg-info/entry_points.txt")
    text = entries.read_text()
    assert "[console_scripts]\npharos = pharos.cli:main\n" in text
    assert "[can.interface]\npharos-udp = pharos.can_udp:PharosUdpBus\n" in text
