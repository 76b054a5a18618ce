# SPDX-License-Identifier: Apache-2.0
"""The guest itself: what every other test here stands on."""

from __future__ import annotations

import subprocess
from pathlib import Path

import can


def test_python_can_over_vcan_classic_and_fd(vcan0: str) -> None:
    with (
        can.Bus(interface="socketcan", channel=vcan0, fd=True) as sender,
        can.Bus(interface="socketcan", channel=vcan0, fd=True) as receiver,
    ):
        sender.send(can.Message(arbitration_id=0x123, is_extended_id=False, data=b"12345678"))
        fd = can.Message(arbitration_id=0x18FE1234, is_fd=True, data=bytes(range(64)))
        sender.send(fd)
        classic = receiver.recv(10)
        assert classic is not None
        assert (classic.arbitration_id, bytes(classic.data)) == (0x123, b"12345678")
        received = receiver.recv(10)
        assert received is not None
        assert received.is_fd
        assert bytes(received.data) == bytes(range(64))


def test_can_utils_reach_python(vcan0: str, vcan1: str) -> None:
    with (
        can.Bus(interface="socketcan", channel=vcan0) as bus,
        can.Bus(interface="socketcan", channel=vcan1) as other,
    ):
        subprocess.run(["cansend", vcan0, "5A1#11.22.33"], check=True)
        message = bus.recv(10)
        assert message is not None
        assert (message.arbitration_id, bytes(message.data)) == (0x5A1, b"\x11\x22\x33")
        assert other.recv(0) is None


def test_what_the_guest_writes_stays_in_the_guest() -> None:
    """The root is an overlay over the host's, which is mounted read-only below it."""
    mounts = [line.split() for line in Path("/proc/mounts").read_text().splitlines()]
    writable = [(where, kind) for _, where, kind, how, *_ in mounts if how.split(",")[0] == "rw"]
    assert ("/", "overlay") in writable
    shares = [where for where, kind in writable if kind == "hostfs"]
    assert len(shares) == 1
    assert (Path(shares[0]) / "command").exists()
