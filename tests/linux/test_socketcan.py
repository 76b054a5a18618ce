# SPDX-License-Identifier: Apache-2.0
"""--can0 socketcan:NAME on a real kernel's CAN. The peer is python-can's own interface."""

from __future__ import annotations

import contextlib
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from echo_light import Light, Peer
from guest_can import (
    CRTL_ACTIVE,
    ERR_BUSOFF,
    ERR_CRTL,
    ERR_RESTARTED,
    RX_PASSIVE,
    TX_WARNING,
    HeldQueue,
    add_vcan,
    error_frame,
    link,
    vcan,
)
from guest_light import BUILD, until

# Zephyr's numbers of modes, of frame flags and of states.
FD = 4
IDE, FDF, BRS = 1, 4, 8
ACTIVE, WARNING, PASSIVE, BUS_OFF = range(4)
ENETUNREACH = 101
# Far more frames than the kernel keeps for a socket (net.core.rmem_max).
FLOOD = 5000


class Node:
    """can_app on an interface, in real time."""

    def __init__(self, folder: Path, interface: str, *, fd: bool = True) -> None:
        options = ("--can0", f"socketcan:{interface}", "--uart0", "udpin:127.0.0.1:0")
        self.light = Light(BUILD / "tests/native/can_app", folder, *options, virtual=False)
        self.peer = Peer(self.light, "uart0")
        self.interface = interface
        self.lines: list[list[str]] = []
        self.command(f"start {FD if fd else 0}")
        self.until_said("done", ["0"])

    def command(self, text: str) -> None:
        self.peer.send(text.encode() + b"\n")

    def said(self, kind: str) -> list[list[str]]:
        """What it has said of that kind, without the times."""
        while not self.peer.is_silent():
            assert self.peer.sock is not None
            self.lines += [line.split() for line in self.peer.sock.recv(4096).decode().splitlines()]
        return [line[2:] for line in self.lines if line[1] == kind]

    def until_said(self, kind: str, words: list[str]) -> None:
        until(f"{kind} {words}", lambda: words in self.said(kind))

    def count(self, name: str) -> int:
        return int(self.light.do("buses")["buses"]["can0"][name])

    def close(self) -> None:
        self.peer.close()
        self.light.close()
        text = self.light.stderr.read_text()
        assert "ERROR: " not in text, text
        assert "runtime error" not in text, text


@pytest.fixture
def node(tmp_path: Path, vcan0: str) -> Iterator[Node]:
    made = Node(tmp_path, vcan0)
    yield made
    made.close()


@pytest.fixture
def bus(vcan0: str) -> Iterator[can.BusABC]:
    with can.Bus(interface="socketcan", channel=vcan0, fd=True) as opened:
        yield opened


def receive(bus: can.BusABC) -> can.Message:
    """The next frame that is no error frame."""
    while True:
        message = bus.recv(30.0)
        assert message is not None
        if not message.is_error_frame:
            return message


def listeners(interface: str) -> int:
    """Raw sockets that take all frames of the interface."""
    text = Path("/proc/net/can/rcvlist_all").read_text()
    return sum(1 for line in text.splitlines() if line.split()[:1] == [interface])


@pytest.mark.parametrize("fd", [False, True])
@pytest.mark.parametrize("extended", [False, True])
def test_every_length_there_and_back(node: Node, bus: can.BusABC, extended: bool, fd: bool) -> None:
    node.command("echo 1")
    until("echo", lambda: len(node.said("done")) == 2)
    for length in [0, 1, 7, 8, *((12, 16, 20, 24, 32, 48, 64) if fd else ())]:
        data = bytes(range(length))
        bus.send(
            can.Message(
                arbitration_id=0x123, data=data, is_extended_id=extended,
                is_fd=fd, bitrate_switch=fd,
            )
        )  # fmt: skip
        echo = receive(bus)
        assert (echo.arbitration_id, bytes(echo.data)) == (0x124, data)
        assert (echo.is_extended_id, echo.is_fd, echo.bitrate_switch) == (extended, fd, fd)


def test_what_candump_sees(node: Node, vcan0: str) -> None:
    before = listeners(vcan0)
    dump = subprocess.Popen(["candump", "-n", "2", "-L", vcan0], stdout=subprocess.PIPE, text=True)
    until("candump", lambda: listeners(vcan0) > before)
    node.command(f"send 1abcde {IDE} 3 1")
    node.command(f"send 123 {FDF | BRS} 9 1")
    out, _ = dump.communicate(timeout=30)
    lines = [line.split(" ", 2)[2] for line in out.splitlines()]
    # Flags of the FD frame: BRS 1, and FDF 4, which the kernel adds.
    assert lines == ["001ABCDE#000000", "123##5" + "00" * 12]


def test_an_interface_without_fd_refuses_fd_frames_and_goes_on(tmp_path: Path) -> None:
    with vcan("vcan7", mtu="16") as classic, contextlib.closing(Node(tmp_path, classic)) as node:
        node.command(f"send 10 {FDF} 9 1")
        node.until_said("sent", ["10", "-5"])
        node.command("send 11 0 8 1")
        node.until_said("sent", ["11", "0"])


def test_interface_down_and_up(node: Node, bus: can.BusABC, vcan0: str) -> None:
    link("set", vcan0, "down")
    until("an error", lambda: node.count("errors") >= 1)
    node.command("send 20 0 0 1")
    node.until_said("state", [str(PASSIVE), "128", "0"])
    link("set", vcan0, "up")
    # It waited in its mailbox.
    node.until_said("sent", ["20", "0"])
    node.until_said("state", [str(ACTIVE), "0", "0"])
    assert node.count("reconnects") == 1
    with can.Bus(interface="socketcan", channel=vcan0, fd=True) as again:
        again.send(can.Message(arbitration_id=0x77, is_extended_id=False))
        node.until_said("rx", ["77", "0", "0"])


def test_interface_vanishes_and_comes_back(node: Node, vcan0: str) -> None:
    link("del", vcan0)
    until("an error", lambda: node.count("errors") >= 1)
    add_vcan(vcan0)
    until("it is back", lambda: node.count("reconnects") == 1)
    node.command("send 21 0 0 1")
    node.until_said("sent", ["21", "0"])
    assert node.light.stderr.read_text().count("trying again") == 1


def test_an_interface_that_comes_later(tmp_path: Path) -> None:
    with contextlib.closing(Node(tmp_path, "vcan8")) as node:
        until("an error", lambda: node.count("errors") >= 2)
        with vcan("vcan8"):
            node.command("send 22 0 0 1")
            node.until_said("sent", ["22", "0"])


def test_states_of_the_controller_below(node: Node, vcan0: str) -> None:
    error_frame(vcan0, ERR_CRTL, bytes([0, TX_WARNING, 0, 0, 0, 0, 96, 3]))
    node.until_said("state", [str(WARNING), "96", "3"])
    # Without counters: the threshold.
    error_frame(vcan0, ERR_CRTL, bytes([0, RX_PASSIVE]))
    node.until_said("state", [str(PASSIVE), "0", "128"])
    error_frame(vcan0, ERR_CRTL, bytes([0, CRTL_ACTIVE]))
    node.until_said("state", [str(ACTIVE), "0", "0"])


def test_bus_off_and_restart(node: Node, bus: can.BusABC, vcan0: str) -> None:
    error_frame(vcan0, ERR_BUSOFF)
    node.until_said("state", [str(BUS_OFF), "255", "0"])
    node.command("send 30 0 0 1")
    node.until_said("done", [str(-ENETUNREACH)])
    error_frame(vcan0, ERR_RESTARTED)
    node.until_said("state", [str(ACTIVE), "0", "0"])
    node.command("send 31 0 0 1")
    node.until_said("sent", ["31", "0"])
    assert receive(bus).arbitration_id == 0x31


def test_a_burst_is_heard_whole(node: Node, bus: can.BusABC) -> None:
    node.command("quiet 1")
    until("quiet", lambda: len(node.said("done")) == 2)
    for number in range(2000):
        bus.send(can.Message(arbitration_id=number, data=bytes(8)))
    until("all frames", lambda: node.count("rx_frames") == 2000)


# A frame takes CAN_MTU or CANFD_MTU bytes of the queue.
@pytest.mark.parametrize(
    ("flags", "dlc", "size"), [(0, 8, 16), (FDF | BRS, 15, 72)], ids=["classic", "fd"]
)
def test_full_send_queue_is_counted_and_every_frame_goes_in_order(
    node: Node, bus: can.BusABC, vcan0: str, flags: int, dlc: int, size: int
) -> None:
    queue = HeldQueue(vcan0, 10 * size)
    node.command(f"send 40 {flags} {dlc} 30")
    until("a refusal by the full queue", lambda: node.count("tx_retries") > 0)
    assert node.count("tx_frames") == 10
    queue.release()
    ids = range(0x40, 0x40 + 30)
    assert [receive(bus).arbitration_id for _ in ids] == list(ids)
    until("all sent", lambda: node.said("sent") == [[f"{i:x}", "0"] for i in ids])
    assert node.count("errors") == 0


def test_full_receive_queue_is_counted(node: Node, vcan0: str) -> None:
    node.command("quiet 1")
    until("quiet", lambda: len(node.said("done")) == 2)
    before = node.count("rx_frames")
    node.light.process.send_signal(signal.SIGSTOP)
    try:
        with can.Bus(interface="socketcan", channel=vcan0) as bus:
            for number in range(FLOOD):
                bus.send(can.Message(arbitration_id=number % 0x7FF, data=bytes(8)))
    finally:
        node.light.process.send_signal(signal.SIGCONT)
    until("the rest", lambda: node.count("rx_frames") - before + node.count("rx_drops") == FLOOD)
    assert node.count("rx_drops") > 0
    assert node.count("rx_frames") > before
