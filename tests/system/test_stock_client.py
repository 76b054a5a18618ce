# SPDX-License-Identifier: Apache-2.0
"""Programs from PyPI, as they come, in real time."""

from __future__ import annotations

import json
import lzma
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from harness import BUILD
from pharos import find_dialect, load_dialect
from programs import read_until
from realtime import LIMIT_S, light_at


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """HOST:PORT of a light that runs in real time and listens over UDP."""
    with light_at(tmp_path) as found:
        yield found


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
            read_until(
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
