# SPDX-License-Identifier: Apache-2.0
"""Every kind of wire: bytes there and back, several peers, ends that fail."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import signal
import socket
import subprocess
import termios
import time
from pathlib import Path

import pytest

from echo_light import PATIENCE_S, Peer, Start, wait_until

LISTENING = [
    "udpin:127.0.0.1:0",
    "udpin:[::1]:0",
    "udpin:localhost:0",
    "tcpin:127.0.0.1:0",
    "tcpin:[::1]:0",
    "pty:{folder}/tty",
]


@pytest.mark.parametrize("url", LISTENING)
def test_a_listening_wire_carries_bytes_both_ways_in_lock_step(start: Start, url: str) -> None:
    light = start("--uart0", url)
    peer = Peer(light, "uart0")
    sent = 0
    for data in (b"hello", bytes(range(256)), b"\x00"):
        peer.send(data)
        sent += len(data)
        reply = light.advance(0, uart0=sent)
        assert peer.read(len(data)) == data
        # Whatever came in went out again: the fixture echoes.
        assert reply["wires"]["uart0"]["rx_bytes"] == sent
        assert reply["wires"]["uart0"]["tx_bytes"] == sent
    assert light.quit() == 0
    peer.close()


@pytest.mark.parametrize("url", LISTENING)
def test_a_listening_wire_carries_bytes_both_ways_in_real_time(start: Start, url: str) -> None:
    light = start("--uart0", url, virtual=False)
    peer = Peer(light, "uart0")
    for data in (b"hello", bytes(range(256))):
        peer.send(data)
        assert peer.read(len(data)) == data
    peer.close()


def test_one_write_is_one_datagram(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0")
    peer = Peer(light, "uart0")
    assert peer.sock is not None
    peer.send(b"ab")
    light.advance(0, uart0=2)
    peer.send(b"cdef")
    light.advance(0, uart0=6)
    assert [peer.sock.recv(100), peer.sock.recv(100)] == [b"ab", b"cdef"]


def test_udpin_answers_all_peers_of_the_last_minute(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0")
    first, second = Peer(light, "uart0"), Peer(light, "uart0")
    first.send(b"1")
    light.advance(0, uart0=1)
    second.send(b"2")
    light.advance(0, uart0=2)
    assert first.read(2) == b"12"
    assert second.read(1) == b"2"
    # 60 s: the documented time after which a silent peer is forgotten.
    light.advance(59_999_999)
    second.send(b"3")
    light.advance(0, uart0=3)
    assert first.read(1) == b"3"
    light.advance(1)
    second.send(b"4")
    light.advance(0, uart0=4)
    assert second.read(2) == b"34"
    assert first.is_silent()


def test_udpin_keeps_eight_peers(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0")
    peers = []
    for count in range(1, 10):
        peers.append(Peer(light, "uart0"))
        peers[-1].send(b"x")
        light.advance(1, uart0=count)
    # The first, silent for longest, made room for the ninth: it got 8 echoes, the second 8 as well.
    assert peers[0].read(8) == b"x" * 8
    assert peers[0].is_silent()
    assert peers[1].read(8) == b"x" * 8
    assert peers[8].read(1) == b"x"


def test_udpout_sends_there(start: Start) -> None:
    station = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    station.bind(("127.0.0.1", 0))
    station.settimeout(PATIENCE_S)
    light = start("--uart3", f"udpout:127.0.0.1:{station.getsockname()[1]}")
    light.advance(1_000_000)
    boot, address = station.recvfrom(100)
    # 8: power-on, RESET_POR of Zephyr's hwinfo.
    assert [boot, station.recv(100)] == [b"boot 8\n", b"tick 1\n"]
    assert address[0] == "127.0.0.1"
    station.close()


def test_udppair_receives_here_and_sends_there(start: Start) -> None:
    station = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    station.bind(("127.0.0.1", 0))
    station.settimeout(PATIENCE_S)
    light = start("--uart0", f"udppair:127.0.0.1:0,127.0.0.1:{station.getsockname()[1]}")
    own = light.wire("uart0")["address"].removeprefix("udppair:").split(",")[0]
    other = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    other.sendto(b"question", ("127.0.0.1", int(own.split(":")[1])))
    light.advance(0, uart0=8)
    assert station.recv(100) == b"question"
    station.close()
    other.close()


def test_refused_datagrams_are_counted_and_pass(start: Start) -> None:
    station = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    station.bind(("127.0.0.1", 0))
    address = station.getsockname()
    station.close()
    light = start("--uart3", f"udpout:127.0.0.1:{address[1]}")
    light.advance(3_000_000)
    light.advance(3_000_000)
    assert light.wire("uart3")["errors"] > 0
    station = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    station.bind(address)
    station.settimeout(PATIENCE_S)
    light.advance(1_000_000)
    assert station.recv(100) == b"tick 7\n"
    station.close()


def test_tcp_connects_again_and_again(start: Start) -> None:
    listener = socket.create_server(("127.0.0.1", 0))
    address = listener.getsockname()
    listener.close()
    light = start("--uart0", f"tcp:127.0.0.1:{address[1]}", virtual=False)
    wait_until(lambda: light.wire("uart0")["errors"] >= 2, "two refused connections")
    for round_ in range(2):
        listener = socket.create_server(address)
        listener.settimeout(PATIENCE_S)
        client, _ = listener.accept()
        client.settimeout(PATIENCE_S)
        client.sendall(b"hello")
        assert client.recv(100) == b"hello"
        client.close()
        listener.close()
        assert light.wire("uart0")["reconnects"] >= round_
    assert "Connection refused; trying again" in light.stderr.read_text()
    assert light.quit() == 0


def test_tcpin_serves_several_clients_and_survives_their_going(start: Start) -> None:
    light = start("--uart0", "tcpin:127.0.0.1:0")
    first, second = Peer(light, "uart0"), Peer(light, "uart0")
    first.send(b"abc")
    light.advance(0, uart0=3)
    assert first.read(3) == second.read(3) == b"abc"
    first.close()
    second.send(b"de")
    light.advance(0, uart0=5)
    assert second.read(2) == b"de"
    third = Peer(light, "uart0")
    third.send(b"f")
    light.advance(0, uart0=6)
    assert third.read(1) == b"f"


def test_pty_survives_its_user_and_removes_its_link(start: Start) -> None:
    light = start("--uart0", "pty:{folder}/tty")
    link = light.folder / "tty"
    for count in range(1, 4):
        peer = Peer(light, "uart0")
        peer.send(b"z")
        light.advance(0, uart0=count)
        assert peer.read(1) == b"z"
        peer.close()
    assert link.is_symlink()
    assert light.quit() == 0
    assert not link.is_symlink()


def test_serial_port_comes_late_and_goes(start: Start, tmp_path: Path) -> None:
    port = tmp_path / "ttyUSB0"
    light = start("--uart0", f"serial:{port},57600", virtual=False)
    wait_until(lambda: light.wire("uart0")["errors"] >= 1, "a missing port")
    for _ in range(2):
        master, slave = pty.openpty()
        port.symlink_to(os.ttyname(slave))
        before = light.wire("uart0")["reconnects"]
        wait_until(lambda b=before: light.wire("uart0")["reconnects"] > b, "an open port")  # type: ignore[misc]
        os.write(master, b"hello")
        assert os.read(master, 100) == b"hello"
        port.unlink()
        os.close(slave)
        os.close(master)
    assert light.quit() == 0


def test_stdio_carries_bytes_and_its_end_ends_nothing(start: Start) -> None:
    light = start("--uart0", "stdio", virtual=False)
    assert light.process.stdin is not None
    assert light.process.stdout is not None
    light.process.stdin.write(b"hello")
    light.process.stdin.close()
    assert os.read(light.process.stdout.fileno(), 100) == b"hello"
    assert light.do("hello")["name"] == "pharos"
    assert light.quit() == 0


def test_stdio_ends_the_program_when_asked(start: Start) -> None:
    light = start("--uart0", "stdio:eof=exit", virtual=False)
    assert light.process.stdin is not None
    light.process.stdin.close()
    assert light.process.wait(PATIENCE_S) == 0


def start_on_terminal(binary: Path, slave: int) -> subprocess.Popen[bytes]:
    def own_terminal() -> None:
        fcntl.ioctl(slave, termios.TIOCSCTTY, 0)

    process = subprocess.Popen(
        [str(binary), "--console", "none", "--uart0", "stdio"],
        stdin=slave, stdout=slave, stderr=subprocess.DEVNULL,
        start_new_session=True, preexec_fn=own_terminal,
    )  # fmt: skip
    wait_until(lambda: not termios.tcgetattr(slave)[3] & termios.ICANON, "raw mode")
    return process


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGSEGV])
def test_a_terminal_gets_its_mode_back(binary: Path, number: signal.Signals) -> None:
    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)
    process = start_on_terminal(binary, slave)
    os.write(master, b"x")
    assert os.read(master, 10) == b"x"
    process.send_signal(number)
    status = process.wait(PATIENCE_S)
    assert termios.tcgetattr(slave) == before
    assert (status == 0) == (number != signal.SIGSEGV)
    os.close(slave)
    os.close(master)


def test_a_terminal_that_hangs_up_ends_the_program(binary: Path) -> None:
    master, slave = pty.openpty()
    process = start_on_terminal(binary, slave)
    os.close(slave)
    os.close(master)
    assert process.wait(PATIENCE_S) == -signal.SIGHUP


def test_a_slow_reader_stops_nothing(start: Start) -> None:
    """A full FIFO leaves the rest in the socket; nothing of a stream is lost."""
    light = start("--uart0", "tcpin:127.0.0.1:0", virtual=False)
    peer = Peer(light, "uart0")
    assert peer.sock is not None
    data = bytes(i % 251 for i in range(300_000))
    peer.sock.setblocking(False)
    deadline = time.monotonic() + PATIENCE_S
    sent, got = 0, b""
    while len(got) < len(data):
        with contextlib.suppress(BlockingIOError):
            sent += peer.sock.send(data[sent : sent + 4096])
        with contextlib.suppress(BlockingIOError):
            got += peer.sock.recv(65536)
        assert time.monotonic() < deadline
    assert got == data


def test_paced_bytes_take_the_time_of_their_bits(start: Start) -> None:
    light = start("--uart0", "udpin:127.0.0.1:0,paced,baud=9600")
    peer = Peer(light, "uart0")
    peer.send(b"x" * 16)
    # 10 bits a byte at 9600/s, rounded up to the next us and to the kernel's next tick: 16 bytes in
    # 16 667 us, and as long out again.
    assert light.advance(2 * 16_667 - 100, uart0=16)["wires"]["uart0"]["tx_bytes"] == 0
    assert light.advance(200)["wires"]["uart0"]["tx_bytes"] == 16


def test_an_output_that_nobody_reads_blocks_nothing(start: Start) -> None:
    """A pipe holds 64 KiB; the wire a bounded part of the rest; what is left is counted."""
    light = start("--uart0", "stdio", virtual=False)
    assert light.process.stdin is not None
    total = 0
    for _ in range(40):
        light.process.stdin.write(b"x" * 50_000)
        light.process.stdin.flush()
        total += 50_000
    wait_until(lambda: light.wire("uart0")["rx_bytes"] == total, "all input")
    assert light.wire("uart0")["tx_drops"] > 0
    assert light.quit() == 0


def test_a_name_that_is_not_found_stops_nothing(start: Start) -> None:
    # RFC 6761: names in .invalid never resolve.
    light = start("--uart0", "udpout:light.invalid:1", "--uart1", "tcp:light.invalid:1")
    light.advance(1_000_000)
    assert light.wire("uart0")["address"] == "udpout:light.invalid:1"
    assert light.quit() == 0


def test_it_starts_without_standard_streams(binary: Path, tmp_path: Path) -> None:
    trace = tmp_path / "trace"
    command = f"{binary} --time virtual --until 2s --trace {trace} --uart0 udpin:127.0.0.1:0"
    status = subprocess.run(["sh", "-c", f"exec {command} <&- >&- 2>&-"], timeout=PATIENCE_S)
    assert status.returncode == 0
    assert b"timeout main 1000000" in trace.read_bytes()


# --- mDNS ---------------------------------------------------------------------------------------
AVAHI = """#!/bin/sh
printf '%s|' "$@" >> {said}
exec sleep 1000
"""


def _with_avahi(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A stand-in for avahi-publish; the file in which it says what it was told."""
    tools, said = folder / "tools", folder / "said"
    tools.mkdir()
    (tools / "avahi-publish").write_text(AVAHI.format(said=said))
    (tools / "avahi-publish").chmod(0o755)
    monkeypatch.setenv("PATH", str(tools), prepend=":")
    return said


def test_what_listens_for_the_network_is_announced(
    start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = _with_avahi(tmp_path, monkeypatch)
    words = ("--uart0", "udpin:0.0.0.0:0", "--uart1", "udpin:127.0.0.1:0", "--device-id", "2a")
    light = start(*words, virtual=False)
    port = light.do("wires")["wires"]["uart0"]["address"].rpartition(":")[2]
    wait_until(said.exists, "the announcement")
    wait_until(lambda: said.read_text().count("|") == 5, "all of it")
    assert said.read_text() == (
        f"-s|Pharos 2a00000000000000 port {port}|_mavlink._udp|{port}|serial=2a00000000000000|"
    )
    children = Path(f"/proc/{light.process.pid}/task/{light.process.pid}/children").read_text()
    (child,) = map(int, children.split())
    assert light.quit() == 0
    wait_until(lambda: not Path(f"/proc/{child}").exists(), "its end")


@pytest.mark.parametrize("url", ["udpin:127.0.0.1:0", "udpin:[::1]:0", "tcpin:0.0.0.0:0"])
def test_what_only_this_host_reaches_is_not_announced(
    start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, url: str
) -> None:
    said = _with_avahi(tmp_path, monkeypatch)
    light = start("--uart0", url, virtual=False)
    assert light.quit() == 0
    assert not said.exists()


def test_without_avahi_nothing_is_said(
    start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    light = start("--uart0", "udpin:0.0.0.0:0", virtual=False)
    assert light.quit() == 0
    assert "avahi" not in light.stderr.read_text()
