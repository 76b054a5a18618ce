# SPDX-License-Identifier: Apache-2.0
"""DroneCAN framing: frames known from elsewhere, and every way a transfer can be broken."""

from __future__ import annotations

from typing import Any

import pytest
from dronecan import transport, uavcan

from pharos.can_transfer import (
    FD_LENGTHS,
    TIMEOUT_US,
    Assembler,
    Header,
    pack,
    parse_identifier,
    split,
)
from pharos.cli.can import actuator_command, hardpoint_command, lights_command

Frame = tuple[int, bytes]


def _targetted(data: bytes) -> Any:
    message = uavcan.tunnel.Targetted(target_node=68, serial_id=0, options=1, baudrate=57600)
    message.protocol.protocol = 1
    message.buffer.from_bytes(data)
    return message


def _status() -> Any:
    status = uavcan.protocol.NodeStatus()
    status.uptime_sec = 1
    return status


def _frames(message: Any, header: Header, transfer_id: int = 0, fd: bool = False) -> list[Frame]:
    seed = transport.get_dronecan_data_type(message).base_crc
    pieces = split(pack(message, fd), seed, transfer_id, fd)
    return [(header.identifier, data) for data in pieces]


# Frames of ArduPilot's and libcanard's making.
GOLDEN: list[tuple[str, Any, Header, int, bool, int, list[str]]] = [
    ("keepalive", _targetted(b""), Header(3001, 10, 16), 0, False, 0x100BB90A, ["01880100E100C0"]),
    (
        "keepalive FD",
        _targetted(b""),
        Header(3001, 10, 16),
        0,
        True,
        0x100BB90A,
        ["01880100E10000C0"],
    ),
    (
        "tunnelled bytes",
        _targetted(bytes.fromhex("FD010203")),
        Header(3001, 10, 16),
        0,
        False,
        0x100BB90A,
        ["D45501880100E180", "00FD01020360"],
    ),
    (
        "tunnelled bytes FD",
        _targetted(bytes.fromhex("FD010203")),
        Header(3001, 10, 16),
        0,
        True,
        0x100BB90A,
        ["01880100E10009FA020406C0"],
    ),
    (
        "LightsCommand 254, full",
        lights_command(254, 1.0),
        Header(1081, 10, 24),
        0,
        False,
        0x1804390A,
        ["FEFFFFC0"],
    ),
    (
        "hardpoint 0 on",
        hardpoint_command(0, True),
        Header(1070, 10, 24),
        0,
        False,
        0x18042E0A,
        ["000100C0"],
    ),
    (
        "actuator 9 = +0.5",
        actuator_command(9, 0.75),
        Header(1010, 10, 8),
        0,
        False,
        0x0803F20A,
        ["09000038C0"],
    ),
    ("NodeStatus", _status(), Header(341, 68, 24), 0, False, 0x18015544, ["01000000000000C0"]),
    (
        "GetNodeInfo",
        uavcan.protocol.GetNodeInfo.Request(),
        Header(1, 10, 20, 68, True),
        3,
        False,
        0x1401C48A,
        ["C3"],
    ),
]


@pytest.mark.parametrize(
    ("message", "header", "transfer_id", "fd", "identifier", "data"),
    [row[1:] for row in GOLDEN],
    ids=[row[0] for row in GOLDEN],
)
def test_golden_frames_there_and_back(
    message: Any, header: Header, transfer_id: int, fd: bool, identifier: int, data: list[str]
) -> None:
    golden = [(identifier, bytes.fromhex(text)) for text in data]
    assert _frames(message, header, transfer_id, fd) == golden
    assert parse_identifier(identifier) == header
    assembler = Assembler()
    came = [assembler.receive(0, *frame, fd) for frame in golden]
    assert came[:-1] == [None] * (len(golden) - 1)
    last = came[-1]
    assert last is not None
    assert (last.header, last.transfer_id, last.fd) == (header, transfer_id, fd)
    assert pack(last.message, fd) == pack(message, fd)


def test_120_bytes_are_19_classic_frames_or_3_of_fd() -> None:
    assert len(_frames(_targetted(bytes(120)), Header(3001, 10, 16))) == 19
    fd = _frames(_targetted(bytes(120)), Header(3001, 10, 16), fd=True)
    assert [len(data) for _, data in fd] == [64, 64, 4]


@pytest.mark.parametrize("fd", [False, True], ids=["classic", "fd"])
@pytest.mark.parametrize("length", range(121))
def test_every_length_comes_back_in_frames_that_exist(length: int, fd: bool) -> None:
    data = bytes(index * 37 % 256 for index in range(length))
    assembler = Assembler()
    got = None
    for identifier, frame in _frames(_targetted(data), Header(3001, 10, 16), fd=fd):
        assert len(frame) in FD_LENGTHS
        assert len(frame) <= (64 if fd else 8)
        got = assembler.receive(0, identifier, frame, fd)
    assert got is not None
    assert bytes(got.message.buffer.to_bytes()) == data


SIX = _frames(_targetted(bytes(range(30))), Header(3001, 10, 16), 7)
WHOLE = _frames(_targetted(b"hello, light"), Header(3001, 10, 16), 8)


def _run(assembler: Assembler, frames: list[Frame], step_us: int = 100) -> list[bytes]:
    """The buffers of the transfers that come of it."""
    now, out = 0, []
    for frame in frames:
        now += step_us
        transfer = assembler.receive(now, *frame, False)
        if transfer is not None:
            out.append(bytes(transfer.message.buffer.to_bytes()))
    return out


@pytest.mark.parametrize("lost", range(len(SIX)))
def test_transfer_with_a_lost_frame_is_dropped_and_the_next_one_is_not(lost: int) -> None:
    assembler = Assembler()
    assert _run(assembler, SIX[:lost] + SIX[lost + 1 :] + WHOLE) == [b"hello, light"]
    assert assembler.errors + assembler.repeated > 0


@pytest.mark.parametrize("twice", range(len(SIX)))
def test_frame_that_comes_twice_does_no_harm(twice: int) -> None:
    assembler = Assembler()
    frames = SIX[: twice + 1] + SIX[twice:] + WHOLE
    assert _run(assembler, frames) == [bytes(range(30)), b"hello, light"]
    assert assembler.errors <= (1 if twice == 0 else 0)  # a start that comes twice starts anew


@pytest.mark.parametrize("at", range(len(SIX) - 1))
def test_swapped_frames_are_no_transfer(at: int) -> None:
    frames = list(SIX)
    frames[at], frames[at + 1] = frames[at + 1], frames[at]
    assert _run(Assembler(), frames + WHOLE) == [b"hello, light"]


def test_transfer_that_comes_twice_counts_once() -> None:
    assembler = Assembler()
    assert _run(assembler, SIX + SIX + WHOLE + WHOLE) == [bytes(range(30)), b"hello, light"]
    assert assembler.repeated == len(SIX) + len(WHOLE)


def test_transfer_id_may_come_again_after_the_timeout() -> None:
    assembler = Assembler()
    keepalive = _frames(_targetted(b""), Header(3001, 10, 16))[0]
    assert assembler.receive(0, *keepalive, False) is not None
    assert assembler.receive(TIMEOUT_US, *keepalive, False) is None
    assert assembler.receive(TIMEOUT_US + 1, *keepalive, False) is not None


def test_transfer_times_out_between_frames() -> None:
    assert _run(Assembler(), SIX, TIMEOUT_US) == [bytes(range(30))]
    assert _run(Assembler(), SIX, TIMEOUT_US + 1) == []


def test_interleaved_sources_do_not_disturb_each_other() -> None:
    other = _frames(_targetted(bytes(range(100, 130))), Header(3001, 11, 16), 7)
    mixed = [frame for pair in zip(SIX, other, strict=True) for frame in pair]
    assert _run(Assembler(), mixed) == [bytes(range(30)), bytes(range(100, 130))]


@pytest.mark.parametrize("bit", range(8 * 7))
def test_flipped_bit_in_a_multi_frame_payload_fails_its_crc(bit: int) -> None:
    identifier, data = SIX[2]
    flipped = bytearray(data)
    flipped[bit // 8] ^= 1 << bit % 8
    assembler = Assembler()
    assert _run(assembler, [*SIX[:2], (identifier, bytes(flipped)), *SIX[3:]]) == []
    assert assembler.errors == 1


def test_what_is_no_transfer_is_counted() -> None:
    assembler = Assembler()
    assert assembler.receive(0, 0x100BB90A, b"", False) is None  # no tail byte
    assert assembler.receive(0, 0x18015544, b"\x00\xc0", False) is None  # NodeStatus has 7 bytes
    assert assembler.errors == 2
    assert assembler.receive(0, Header(60_000, 10).identifier, b"\x00\xc0", False) is None
    assert assembler.unknown == 1


def test_anonymous_source_has_a_type_of_two_bits() -> None:
    # Allocation (type 1), discriminator 0x2ABC, priority 30.
    header = parse_identifier(30 << 24 | 0x2ABC << 10 | 1 << 8)
    assert (header.source, header.type_id, header.priority) == (0, 1, 30)
