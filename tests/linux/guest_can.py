# SPDX-License-Identifier: Apache-2.0
"""Virtual CAN interfaces of the guest's kernel, their send queues, and error frames.

guest_can.py COMMAND…    COMMAND, with vcan0 there
"""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

# Room for a CAN FD frame.
FD_MTU = "72"
PATIENCE_S = 30.0

# linux/can.h and linux/can/error.h
ERR_FLAG = 0x20000000
ERR_CRTL, ERR_PROT, ERR_ACK, ERR_BUSOFF, ERR_RESTARTED = 0x4, 0x8, 0x20, 0x40, 0x100
TX_WARNING, TX_PASSIVE, RX_PASSIVE, CRTL_ACTIVE = 0x08, 0x20, 0x10, 0x40


def link(*words: str) -> None:
    subprocess.run(["ip", "link", *words], check=True)


def add_vcan(name: str, mtu: str = FD_MTU) -> None:
    link("add", "dev", name, "type", "vcan")
    link("set", name, "mtu", mtu, "up")


@contextlib.contextmanager
def vcan(name: str, mtu: str = FD_MTU) -> Iterator[str]:
    """An interface that is up; what is left of it at the end is removed."""
    add_vcan(name, mtu)
    try:
        yield name
    finally:
        link("del", name)


@contextlib.contextmanager
def vxcan(near: str, far: str) -> Iterator[tuple[str, str]]:
    """Two interfaces, up: what is sent on one comes in at the other."""
    link("add", "dev", near, "type", "vxcan", "peer", "name", far)
    try:
        for name in (near, far):
            link("set", name, "mtu", FD_MTU, "up")
        for name in (near, far):
            _wait_for_operstate(name)
        yield near, far
    finally:
        link("del", near)


def _wait_for_operstate(name: str) -> None:
    """Until then, frames are dropped."""
    state = Path("/sys/class/net", name, "operstate")
    end = time.monotonic() + PATIENCE_S
    while state.read_text().strip() != "up":
        assert time.monotonic() < end, f"{name} does not come up"
        os.sched_yield()


class HeldQueue:
    """A send queue in front of an interface, which holds what comes until release(). A frame that
    does not fit into its `limit` bytes (16 for a classic one, 72 with CAN FD) is refused: ENOBUFS.
    """

    def __init__(self, interface: str, limit: int) -> None:
        self._interface = interface
        self._tc("add", "limit", str(limit))

    def hold(self) -> None:
        self._tc("change", "block")

    def release(self) -> None:
        self._tc("change", "release_indefinite")

    def _tc(self, action: str, *words: str) -> None:
        where = ("qdisc", action, "dev", self._interface, "root", "plug")
        subprocess.run(["tc", *where, *words], check=True)


def error_frame(interface: str, kind: int, data: bytes = b"") -> None:
    """As a controller's driver would report it."""
    with socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as raw:
        raw.bind((interface,))
        raw.send(struct.pack("=IB3x8s", ERR_FLAG | kind, 8, data))


def main() -> None:
    # What one side sends in lock-step lies in the other's queue until it looks.
    for queue in ("rmem_max", "rmem_default"):
        Path("/proc/sys/net/core", queue).write_text(str(16 << 20))
    add_vcan("vcan0")
    os.execvp(sys.argv[1], sys.argv[1:])


if __name__ == "__main__":
    main()
