# SPDX-License-Identifier: Apache-2.0
"""Frames that take their time on the CAN bus: `--can0 udp,paced`."""

from __future__ import annotations

import re

import can
import pytest

from can_node import EBUSY, ENETDOWN, FD, ONE_SHOT, NewNode, message, only


def stuffed(bits: str) -> str:
    """ISO 11898-1: after five equal bits, stuff bits included, comes their opposite."""
    out = ""
    for bit in bits:
        out += bit
        if re.search(r"(0{5}|1{5})$", out):
            out += "1" if bit == "0" else "0"
    return out


def crc15(bits: str) -> str:
    value = int(bits, 2) << 15
    for at in range(value.bit_length() - 1, 14, -1):
        if value >> at & 1:
            value ^= 0xC599 << (at - 15)
    return f"{value:015b}"


def bits_of(frame: can.Message) -> int:
    """On the bus, with the three bits between frames; classic."""
    data = "".join(f"{byte:08b}" for byte in frame.data)
    length = f"{frame.dlc:04b}"
    if frame.is_extended_id:
        identifier = f"{frame.arbitration_id:029b}"
        head = "0" + identifier[:11] + "11" + identifier[11:] + "000"
    else:
        head = f"0{frame.arbitration_id:011b}000"
    body = head + length + data
    return len(stuffed(body + crc15(body))) + 13


FRAMES = [
    message(0, extended=False),
    message(0x7FF, b"\xff" * 8, extended=False),
    message(0x555, b"\x55" * 8, extended=False),
    message(0, b"\0" * 8),
    message(0x1FFFFFFF, b"\xff" * 8),
    message(0x100BB90A, bytes.fromhex("01880100E100C0")),
    message(0x1234567, b"\x0f\x87\xc3\xe1\xf0\x78\x3c\x1e"),
]


@pytest.mark.parametrize("frame", FRAMES, ids=str)
@pytest.mark.parametrize("bitrate", [1_000_000, 125_000])
def test_a_frame_takes_the_time_of_its_bits(
    node: NewNode, frame: can.Message, bitrate: int
) -> None:
    light = node(bus="udp:CHANNEL,paced")
    light.start(FD, bitrate)
    light.send(frame, frame, frame)
    said, _ = light.advance(10_000)
    us = bits_of(frame) * 1_000_000 // bitrate
    assert [int(line[0]) for line in said if line[1] == "rx"] == [us, 2 * us, 3 * us]


def test_a_bus_with_all_it_can_carry(node: NewNode) -> None:
    """1 Mbit/s, ten nodes' worth of frames: as many in a second as their bits allow."""
    light = node(bus="udp:CHANNEL,paced")
    light.start()
    light.command("quiet 1")
    light.advance()
    frame = message(0x100BB90A, bytes.fromhex("01880100E100C0"))
    per_second = 1_000_000 // bits_of(frame)
    for _ in range(0, 2 * per_second, 100):
        light.send(*[frame] * 100)
        light.light.advance(0, can0=light.sent)
    light.command("quiet 0")
    # All are waiting: the next second brings exactly what fits.
    heard = sum(len(only(light.advance(10_000)[0], "rx")) for _ in range(100))
    assert heard == per_second


def test_stopping_in_the_middle_of_a_frame(node: NewNode) -> None:
    light = node(bus="udp:CHANNEL,paced")
    light.start(FD, 125_000)
    light.send(message(1), message(2))
    light.command("send 5 0 0 2")
    light.advance(100)
    light.command("stop")
    said, frames = light.advance(10_000)
    assert only(said, "sent") == [["5", str(-ENETDOWN)], ["6", str(-ENETDOWN)]]
    assert only(said, "rx") == []
    assert frames == []
    light.start(FD, 125_000)
    light.command("send 7 0 0 1")
    assert [frame.arbitration_id for frame in light.advance(10_000)[1]] == [7]


def test_fd_data_are_faster(node: NewNode) -> None:
    light = node(bus="udp:CHANNEL,paced")
    light.start(FD, 1_000_000, 4_000_000)
    light.send(message(0, extended=False, fd=True))
    said, _ = light.advance(1000)
    # By hand: 31 bits at 1 Mbit/s, 33 at 4 Mbit/s; 39.25 us, seen on a clock of 1 us.
    assert said[-1][:2] == ["40", "rx"]


def test_the_lower_id_goes_first(node: NewNode) -> None:
    light = node(bus="udp:CHANNEL,paced")
    light.start()
    light.command("send 100 0 0 3")
    light.send(message(0x7F0, extended=False), message(0x080, extended=False))
    said, frames = light.advance(10_000)
    # 0x7F0 has the bus to itself when the command comes; then 0x080 beats 0x100.
    order = [(line[1], line[2]) for line in said if line[1] in ("rx", "sent")]
    assert sorted(order) == sorted(
        [("rx", "7f0"), ("rx", "80"), ("sent", "100"), ("sent", "101"), ("sent", "102")]
    )
    assert order.index(("rx", "80")) < order.index(("sent", "101"))
    assert [frame.arbitration_id for frame in frames] == [0x100, 0x101, 0x102]


def test_one_shot_loses_arbitration(node: NewNode) -> None:
    light = node(bus="udp:CHANNEL,paced")
    light.start(ONE_SHOT)
    light.send(message(1, extended=False), message(2, extended=False))
    light.advance(10)
    light.command("send 100 0 0 1")
    assert only(light.advance(10)[0], "sent") == []
    assert only(light.advance(1000)[0], "sent") == [["100", str(-EBUSY)]]


def test_sending_is_complete_when_the_bits_have_left(node: NewNode) -> None:
    light = node(bus="udp:CHANNEL,paced")
    light.start(FD, 125_000)
    light.command("send 0 0 0 2")
    assert light.advance(423)[1] == []
    # The all-zero frame has 53 bits (by hand: 34 + 6 + 13), 8 us each.
    said, frames = light.advance(1)
    assert [line[0] for line in said if line[1] == "sent"] == ["424"]
    assert len(frames) == 1


def test_paced_in_real_time_takes_its_time(node: NewNode) -> None:
    light = node(bus="udp:CHANNEL,paced", virtual=False)
    light.command("start 4 20000")
    light.command("send 0 0 0 3")
    lines: list[list[str]] = []
    data = b""
    while len(lines) < 3:
        data += light.peer.read(1)
        lines = [line.split() for line in data.decode().split("\n") if " sent " in line]
    light.receive(3)
    # At least 47 bits of 50 us each, or more when the host is late.
    times = [int(line[0]) for line in lines]
    assert times[2] - times[0] >= 2 * 47 * 50
