# SPDX-License-Identifier: Apache-2.0
"""Programs from PyPI, as they come, in real time."""

from __future__ import annotations

import contextlib
import json
import lzma
import os
import re
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from harness import BUILD
from pharos import find_dialect, load_dialect
from realtime import LIMIT_S, light_at


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """HOST:PORT of a light that runs in real time and listens over UDP."""
    with light_at(tmp_path) as found:
        yield found


def _read_until(process: subprocess.Popen[bytes], pattern: str) -> str:
    """Reads output until `pattern` is seen; fails, showing it all, after LIMIT_S."""
    assert process.stdout is not None
    end = time.monotonic() + LIMIT_S
    text = ""
    while not re.search(pattern, text):
        left = end - time.monotonic()
        ready = select.select([process.stdout], [], [], max(0.0, left))[0]
        data = os.read(process.stdout.fileno(), 65536) if ready else b""
        assert data, f"no '{pattern}' in the output:\n{text}"
        text += data.decode(errors="replace")
    return text


class MavProxy:
    """MAVProxy in a folder of its own, with a light as its target."""

    def __init__(self, address: str, folder: Path, modules: str) -> None:
        program = Path(sys.executable).with_name("mavproxy.py")
        self.process = subprocess.Popen(
            [sys.executable, str(program), f"--master=udpout:{address}", "--target-system=1",
             "--target-component=243", f"--default-modules={modules}",
             f"--state-basedir={folder}"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env={**os.environ, "HOME": str(folder), "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip

    def until(self, pattern: str) -> str:
        return _read_until(self.process, pattern)

    def type(self, line: str, answer: str) -> str:
        """Types a line; returns the output up to the answer."""
        assert self.process.stdin is not None
        self.process.stdin.write(line.encode() + b"\n")
        self.process.stdin.flush()
        return self.until(answer)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()


@contextlib.contextmanager
def mavproxy(address: str, folder: Path, modules: str) -> Iterator[MavProxy]:
    program = MavProxy(address, folder, modules)
    try:
        program.until(r"link 1 OK|Detected vehicle|online system 1|heartbeat")
        yield program
    finally:
        program.close()


@pytest.mark.realtime
def test_mavproxy_turns_the_light_on(address: str, tmp_path: Path) -> None:
    with mavproxy(address, tmp_path, "cmdlong") as program:
        program.type("long ILLUMINATOR_ON_OFF 1", r"ILLUMINATOR_ON_OFF.*ACCEPTED")


@pytest.mark.realtime
def test_mavproxy_fetches_files_and_packed_parameters(address: str, tmp_path: Path) -> None:
    with mavproxy(address, tmp_path, "ftp,param") as program:
        program.until(r"Received \d+ parameters \(ftp\)")
        program.type("ftp list", r"parameters\.json\.xz")
        for name in ("general.json", "parameters.json.xz"):
            program.type(f"ftp get {name}", rf"Wrote \d+ bytes to {re.escape(name)}")
        # a line later, since the file is closed after that is said
        received = program.type("param fetch", r"Received \d+ parameters \(ftp\)")
    table = json.loads(lzma.decompress((tmp_path / "parameters.json.xz").read_bytes()))
    json.loads((tmp_path / "general.json").read_bytes())
    assert f"Received {len(table['parameters'])} parameters" in received


@pytest.mark.realtime
def test_imcpys_actor_hears_answers_and_heartbeats(tmp_path: Path) -> None:
    """It announces itself to the group alone, and sends each message from a socket that it closes
    at once: what is not sent to the address that it announced is lost."""
    pytest.importorskip("imcpy")
    with light_at(tmp_path, "--imc", "udp:127.0.0.1:0"):
        actor = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("imcpy_actor.py"))],
            stdout=subprocess.PIPE,
            cwd=tmp_path,
        )
        try:
            _read_until(
                actor, r"(?s)(?=.*Heartbeat of pharos-light)(?=.*EntityState of pharos-light)"
            )
        finally:
            actor.kill()
            actor.wait()


@pytest.mark.realtime
def test_mavutil_with_the_generated_dialect_decodes_status_and_information(address: str) -> None:
    from pymavlink import mavutil

    mavutil.mavlink = load_dialect(find_dialect(BUILD))
    connection = mavutil.mavlink_connection(f"udpout:{address}", source_system=255)
    try:
        connection.mav.heartbeat_send(6, 8, 0, 0, 4)
        status = connection.recv_match(type="ILLUMINATOR_STATUS", blocking=True, timeout=LIMIT_S)
        assert status is not None
        assert status.mode_bitmask == 3
        connection.mav.command_long_send(1, 243, 512, 0, 396, 0, 0, 0, 0, 0, 0)
        information = connection.recv_match(
            type="COMPONENT_INFORMATION_BASIC", blocking=True, timeout=LIMIT_S
        )
        assert information is not None
        assert information.model_name
    finally:
        connection.close()


@pytest.mark.realtime
def test_pymavlinks_ftp_lists_and_fetches_files(address: str, tmp_path: Path) -> None:
    from pymavlink import mavftp, mavutil

    mavutil.mavlink = load_dialect(find_dialect(BUILD))
    connection = mavutil.mavlink_connection(f"udpout:{address}", source_system=255)
    try:
        connection.mav.heartbeat_send(6, 8, 0, 0, 4)
        assert connection.wait_heartbeat(timeout=LIMIT_S) is not None
        ftp = mavftp.MAVFTP(connection, 1, 243)
        listed = {entry.name: entry.size_b for entry in ftp.cmd_list(["/"]).directory_listing}
        assert list(listed) == ["general.json", "parameters.json.xz"]
        for name, size in listed.items():
            ftp.cmd_get([name, str(tmp_path / name)])
            assert ftp.process_ftp_reply("OpenFileRO", timeout=LIMIT_S).error_code == 0
            assert (tmp_path / name).stat().st_size == size
        table = json.loads(lzma.decompress((tmp_path / "parameters.json.xz").read_bytes()))
        assert table["parameters"][0]["name"] == "LGT_CURVE"
        assert ftp.cmd_rm(["general.json"]).error_code == 9  # FileProtected
    finally:
        connection.close()
