# SPDX-License-Identifier: Apache-2.0
"""The CAN controller on the user-space bus: frames, names of buses, lock-step, real time."""

from __future__ import annotations

import re
import select
import socket
import subprocess
from pathlib import Path

import pytest

from can_node import BRS, FD, FDF, IDE, NewNode, free_port, message, only
from echo_light import PATIENCE_S, Peer, Start, wait_until


@pytest.mark.parametrize("fd", [False, True])
@pytest.mark.parametrize("extended", [False, True])
def test_every_length_there_and_back(node: NewNode, extended: bool, fd: bool) -> None:
    light = node()
    light.start()
    light.command("echo 1")
    lengths = [0, 1, 7, 8, *((12, 16, 20, 24, 32, 48, 64) if fd else ())]
    sent = [message(0x123, bytes(range(n)), extended=extended, fd=fd) for n in lengths]
    light.advance()
    light.send(*sent)
    _, echoed = light.advance(10)
    assert [
        (m.arbitration_id, bytes(m.data), m.is_extended_id, m.is_fd, m.dlc) for m in echoed
    ] == [(0x124, bytes(m.data), extended, fd, m.dlc) for m in sent]


def test_a_frame_of_the_device_to_the_byte(node: NewNode) -> None:
    light = node()
    light.start()
    raw = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    host, port = light.address.split(":")[1:]
    raw.bind((host, int(port)))
    raw.settimeout(PATIENCE_S)
    light.command(f"send 1abcde {IDE | FDF} 9 1")
    light.advance()
    datagram = raw.recv(100)
    raw.close()
    # Header as in the framing's vector (FD, extended id 0x1ABCDE, 12 bytes) but for the CRC.
    assert datagram[:2] == bytes.fromhex("3429")
    assert datagram[4:] == bytes.fromhex("0100DEBC1A80") + bytes(12)


def test_the_vector_is_heard(node: NewNode) -> None:
    light = node()
    light.start()
    host, port = light.address.split(":")[1:]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as raw:
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        vector = bytes.fromhex("3429F8640100DEBC1A80000102030405060708090A0B")
        raw.sendto(vector, (host, int(port)))
    light.sent += 1
    said, _ = light.advance()
    assert only(said, "rx") == [["1abcde", str(IDE | FDF | BRS), "9"]]


def test_what_is_no_frame_is_counted(node: NewNode) -> None:
    light = node()
    light.start()
    host, port = light.address.split(":")[1:]
    good = bytes.fromhex("3429F8640100DEBC1A80000102030405060708090A0B")
    bad = [
        b"",
        b"x",
        good[:-1],
        good + b"\0",
        good[:2] + b"\0\0" + good[4:],
        b"\0" * 10,
        b"y" * 2000,
    ]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as raw:
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        for datagram in bad:
            raw.sendto(datagram, (host, int(port)))
    light.send(message(1))
    said, _ = light.advance()
    assert only(said, "rx") == [["1", str(IDE), "0"]]
    assert light.count("rx_malformed") == len(bad)


def test_two_lights_hear_each_other_and_not_themselves(node: NewNode, start: Start) -> None:
    first = node()
    second = start("--can0", first.address, "--uart0", "udpin:127.0.0.1:0", app="can_app")
    peer = Peer(second, "uart0")
    first.start()
    peer.send(b"start 4\n")
    second.advance(0, uart0=8)
    first.command("send 7f 0 0 1")
    _, frames = first.advance()
    assert [frame.arbitration_id for frame in frames] == [0x7F]
    reply = second.advance(0, can0=1)
    assert reply["buses"]["can0"]["rx_frames"] == 1
    assert peer.read(reply["wires"]["uart0"]["tx_bytes"]).split(b"\n")[1] == b"0 rx 7f 0 0"
    first.light.advance(0)
    assert first.count("rx_frames") == 0
    assert first.count("rx_drops") == 0
    peer.close()


def test_multicast(node: NewNode) -> None:
    port = free_port()
    light = node(bus=f"udp:239.65.82.77:{port}")
    assert light.address == f"udp:239.65.82.77:{port}"
    light.start()
    light.command("echo 1")
    light.advance()
    light.send(message(5))
    assert [frame.arbitration_id for frame in light.advance()[1]] == [6]


@pytest.mark.parametrize(
    ("bus", "address"),
    [
        ("udp", "udp:239.65.82.0:57732"),
        ("udp:3", "udp:239.65.82.3:57732"),
        ("udp:9,paced", "udp:239.65.82.9:57732,paced"),
        ("udp:127.255.255.255:57735", "udp:127.255.255.255:57735"),
    ],
)
def test_names_of_buses(start: Start, bus: str, address: str) -> None:
    light = start("--can0", bus)
    assert light.do("buses")["buses"]["can0"]["address"] == address


def test_real_time_is_on_the_bus_by_default_and_virtual_time_is_not(start: Start) -> None:
    default = "udp:239.65.82.0:57732"
    assert start(virtual=False).do("buses")["buses"]["can0"]["address"] == default
    assert start().do("buses")["buses"]["can0"]["address"] == "none"


@pytest.mark.parametrize(
    ("bus", "error"),
    [
        ("token-ring", '"token-ring" is no CAN bus; udp, socketcan:NAME and none are'),
        ("udp:256", "bus: "),
        ("udp:1,fast", "bus: "),
        ("udp,fast", "say udp[:N][,paced]"),
        ("udp:10.0.0.1:5", "neither 127.255.255.255 nor a multicast address"),
        ("udp:127.255.255.255:0", "port: "),
        ("socketcan:", "say socketcan:NAME"),
        ("socketcan:a-name-that-is-too-long", "say socketcan:NAME"),
        ("socketcan:can0,paced", "has its own pace"),
        ("none:x", "say none"),
    ],
)
def test_a_wrong_bus_is_one_line(binary: Path, bus: str, error: str) -> None:
    result = subprocess.run(
        [binary, "--can0", bus], capture_output=True, timeout=PATIENCE_S, check=False
    )
    assert result.returncode == 2
    assert error in result.stderr.decode()
    assert result.stderr.count(b"\n") == 1


def test_an_interface_that_is_not_there_is_no_end(start: Start) -> None:
    light = start("--can0", "socketcan:nosuch0")
    light.advance(1000)
    assert light.do("buses")["buses"]["can0"]["errors"] >= 1
    light.advance(1000)
    assert light.stderr.read_text().count("trying again") == 1


# --- lock-step -----------------------------------------------------------------------------------


def test_frames_beyond_the_awaited_stay_for_the_next_advance(node: NewNode) -> None:
    light = node()
    light.start()
    light.bus.send(message(1))
    light.bus.send(message(2))
    light.light.advance(0, can0=2, uart0=light.told)
    for identifier in range(3, 8):
        light.bus.send(message(identifier))
    light.sent = 5
    wait_until(lambda: light.count("rx_frames") == 7, "frames")
    said = light.light.advance(0, can0=5)
    text = light.peer.read(said["wires"]["uart0"]["tx_bytes"] - light.read).decode()
    assert re.findall(r"rx (\w+)", text) == ["1", "2", "3", "4", "5"]


def test_frames_that_never_come(node: NewNode) -> None:
    reply = node().light.ask("advance", us=10, await_ms=20, **{"await": {"can0": 3}})
    assert reply["error"] == "await: can0 has received 0 of 3 frames after 20 ms"


def run_trace(node: NewNode, seed: int) -> bytes:
    light = node("--seed", str(seed), "--trace", "{folder}/trace", bus="udp:CHANNEL,paced")
    light.start(FD, 500_000)
    light.command("echo 1")
    for kind in ("lost", "flipped", "doubled", "reordered"):
        light.light.do("fault", device="can0", kind=kind, rate_ppm=100_000)
    for i in range(50):
        light.send(*(message(100 * i + k, bytes([i, k])) for k in range(4)))
        light.command(f"send {16 * i:x} 0 8 2")
        light.advance(1234)
        if i == 25:
            light.light.do("reset")
            light.start(FD, 500_000)
            light.command("echo 1")
    assert light.light.quit() == 0
    return (light.light.folder / "trace").read_bytes()


def test_same_seed_and_frames_same_trace_to_the_byte(node: NewNode) -> None:
    first = run_trace(node, 1)
    assert first.count(b"can-rx") > 150
    assert first == run_trace(node, 1)
    assert first != run_trace(node, 2)


def test_a_reset_keeps_the_bus_and_forgets_the_controller(node: NewNode) -> None:
    light = node()
    light.start()
    light.send(message(1))
    light.advance()
    light.light.do("fault", device="can0", kind="lost", rate_ppm=0)
    light.light.do("reset")
    light.send(message(2))
    # Not started yet: the frame is nobody's.
    assert only(light.advance()[0], "rx") == []
    light.start()
    light.send(message(3))
    assert only(light.advance()[0], "rx") == [["3", str(IDE), "0"]]
    light.command("send 5 0 0 1")
    assert [frame.arbitration_id for frame in light.advance()[1]] == [5]


# --- real time -----------------------------------------------------------------------------------


def test_real_time(node: NewNode) -> None:
    light = node(virtual=False)
    light.command("start 4")
    light.command("echo 1")
    light.command("quiet 1")
    wait_until(lambda: light.light.wire("uart0")["tx_bytes"] > 20, "started")
    for i in range(300):
        light.bus.send(message(i, bytes(8)))
        assert select.select([light.bus.fileno()], [], [], PATIENCE_S)[0]
        assert [frame.arbitration_id for frame in light.receive(1)] == [i + 1]
