# SPDX-License-Identifier: Apache-2.0
"""The user-space CAN bus as a python-can interface."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import can
import pytest

from pharos import UrlError
from pharos.can_udp import DEFAULT_CHANNEL, PharosUdpBus, decode, encode, parse_channel


@pytest.fixture
def channel() -> str:
    """A broadcast address on a port that is free now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return f"127.255.255.255:{probe.getsockname()[1]}"


@pytest.fixture
def pair(channel: str) -> Iterator[tuple[PharosUdpBus, PharosUdpBus]]:
    with PharosUdpBus(channel, fd=True) as one, PharosUdpBus(channel, fd=True) as other:
        yield one, other


# The framing's published vector: FD, id 0x1ABCDE, data 00 … 0B.
VECTOR = bytes.fromhex("3429F8640100DEBC1A80000102030405060708090A0B")
VECTOR_FRAME = can.Message(
    arbitration_id=0x1ABCDE, is_extended_id=True, is_fd=True, data=bytes(range(12))
)


def test_vector_is_encoded() -> None:
    assert encode(VECTOR_FRAME) == VECTOR


def test_vector_is_decoded() -> None:
    frame = decode(VECTOR)
    assert frame is not None
    assert frame.equals(VECTOR_FRAME, timestamp_delta=None, check_direction=False)


@pytest.mark.parametrize("cut", range(len(VECTOR)))
def test_truncated_datagram_is_no_frame(cut: int) -> None:
    assert decode(VECTOR[:cut]) is None


@pytest.mark.parametrize("bit", range(len(VECTOR) * 8))
def test_datagram_with_one_flipped_bit_is_no_frame(bit: int) -> None:
    damaged = bytearray(VECTOR)
    damaged[bit // 8] ^= 1 << bit % 8
    assert decode(bytes(damaged)) is None


@pytest.mark.parametrize(
    "frame",
    [
        can.Message(arbitration_id=0x123, is_extended_id=False, data=b""),
        can.Message(arbitration_id=0x7FF, is_extended_id=False, data=b"12345678"),
        can.Message(arbitration_id=0x1FFFFFFF, data=b"\x00"),
        can.Message(arbitration_id=0x18042E0A, data=bytes.fromhex("000100C0")),
        can.Message(arbitration_id=5, is_extended_id=False, is_remote_frame=True),
        can.Message(arbitration_id=0x1ABCDE, is_fd=True, data=bytes(64)),
    ],
    ids=str,
)
def test_frame_arrives_as_it_was_sent(
    pair: tuple[PharosUdpBus, PharosUdpBus], frame: can.Message
) -> None:
    pair[0].send(frame)
    got = pair[1].recv(5.0)
    assert got is not None
    assert got.equals(frame, timestamp_delta=None, check_channel=False, check_direction=False)


def test_own_frames_are_not_heard(pair: tuple[PharosUdpBus, PharosUdpBus]) -> None:
    pair[0].send(can.Message(arbitration_id=1))
    assert pair[1].recv(5.0) is not None  # it went over the bus
    assert pair[0].recv(0) is None


def test_own_frames_are_heard_when_asked_for(channel: str) -> None:
    with PharosUdpBus(channel, receive_own_messages=True) as bus:
        bus.send(can.Message(arbitration_id=1))
        got = bus.recv(5.0)
        assert got is not None
        assert not got.is_rx


def test_every_node_hears_every_frame_in_order(channel: str) -> None:
    buses = [PharosUdpBus(channel) for _ in range(5)]
    for number in range(1000):
        buses[0].send(can.Message(arbitration_id=number))
    for bus in buses[1:]:
        heard = [bus.recv(5.0) for _ in range(1000)]
        assert [m.arbitration_id for m in heard if m] == list(range(1000))
    for bus in buses:
        bus.shutdown()


def test_filters_are_applied(pair: tuple[PharosUdpBus, PharosUdpBus]) -> None:
    pair[1].set_filters([{"can_id": 0x100, "can_mask": 0x700, "extended": True}])
    for identifier in (0x001, 0x123, 0x200):
        pair[0].send(can.Message(arbitration_id=identifier))
    got = pair[1].recv(5.0)
    assert got is not None
    assert got.arbitration_id == 0x123
    assert pair[1].recv(0) is None


def test_malformed_datagrams_are_counted_and_skipped(
    pair: tuple[PharosUdpBus, PharosUdpBus], channel: str
) -> None:
    host, _, port = channel.rpartition(":")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        for junk in (b"", b"hello", VECTOR[:-1], VECTOR + b"\0", bytes(200)):
            stranger.sendto(junk, (host, int(port)))
    pair[0].send(can.Message(arbitration_id=7))
    got = pair[1].recv(5.0)
    assert got is not None
    assert got.arbitration_id == 7
    assert pair[1].malformed == 5


def test_classic_node_does_not_hear_fd_frames(channel: str) -> None:
    with PharosUdpBus(channel, fd=True) as modern, PharosUdpBus(channel) as classic:
        modern.send(VECTOR_FRAME)
        modern.send(can.Message(arbitration_id=7))
        got = classic.recv(5.0)
        assert got is not None
        assert got.arbitration_id == 7
        assert classic.unexpected_fd == 1


def test_fd_frame_on_a_classic_bus_is_refused(channel: str) -> None:
    with PharosUdpBus(channel) as bus, pytest.raises(can.CanOperationError, match="fd=True"):
        bus.send(VECTOR_FRAME)


def test_classic_frame_of_more_than_8_bytes_is_refused(channel: str) -> None:
    with PharosUdpBus(channel, fd=True) as bus, pytest.raises(can.CanOperationError, match="9 b"):
        bus.send(can.Message(arbitration_id=1, data=bytes(9)))


def test_multicast_group_carries_frames() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        group = f"239.65.82.7:{probe.getsockname()[1]}"
        with PharosUdpBus(group, fd=True) as one, PharosUdpBus(group, fd=True) as other:
            one.send(VECTOR_FRAME)
            got = other.recv(5.0)
            assert got is not None
            assert bytes(got.data) == bytes(VECTOR_FRAME.data)
            assert one.recv(0) is None


def test_length_that_is_no_fd_length_is_refused(channel: str) -> None:
    with PharosUdpBus(channel, fd=True) as bus, pytest.raises(can.CanOperationError, match="pad"):
        bus.send(can.Message(arbitration_id=1, is_fd=True, data=bytes(13)))


@pytest.mark.parametrize(
    "channel",
    ["nonsense", "127.0.0.1", "127.0.0.1:0", "127.0.0.1:99999", "256", "-1", "٣", "9" * 5000]
    + ["a" * 300 + ":1", "192.0.2.1:57732"],
)
def test_bad_channel_is_said_in_one_line(channel: str) -> None:
    """To users of this package and to users of python-can."""
    for root in (UrlError, can.CanInitializationError):
        with pytest.raises(root) as caught:
            PharosUdpBus(channel)
        assert channel in str(caught.value)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("channel", "name", "address"),
    [
        ("0", "0", ("239.65.82.0", 57732)),
        ("5", "5", ("239.65.82.5", 57732)),
        ("pharos-udp/5", "5", ("239.65.82.5", 57732)),
        ("udp:5", "5", ("239.65.82.5", 57732)),
        ("mcast:5", "5", ("239.65.82.5", 57732)),
        ("udp:127.255.255.255:23010", "127.255.255.255:23010", ("127.255.255.255", 23010)),
        ("007", "7", ("239.65.82.7", 57732)),
        ("255", "255", ("239.65.82.255", 57732)),
        ("239.65.82.5:57732", "5", ("239.65.82.5", 57732)),
        ("239.65.82.5:57733", "239.65.82.5:57733", ("239.65.82.5", 57733)),
        ("127.255.255.255:57732", "127.255.255.255:57732", ("127.255.255.255", 57732)),
    ],
)
def test_channel_has_one_name(channel: str, name: str, address: tuple[str, int]) -> None:
    assert parse_channel(channel) == (name, address)


# --- all that python-can's BusABC promises --------------------------------------------------------
def test_names_have_no_spaces_and_open_the_bus_again(
    pair: tuple[PharosUdpBus, PharosUdpBus],
) -> None:
    pair[0].send(can.Message(arbitration_id=1))
    got = pair[1].recv(5.0)
    assert got is not None
    assert got.channel == pair[1].channel_info == str(pair[1])
    kind, _, channel = pair[1].channel_info.partition("/")
    with can.Bus(interface=kind, channel=channel) as third:
        pair[0].send(can.Message(arbitration_id=2))
        got = third.recv(5.0)
        assert got is not None
        assert got.arbitration_id == 2


def test_nothing_is_queued_for_sending(pair: tuple[PharosUdpBus, PharosUdpBus]) -> None:
    pair[0].send(can.Message(arbitration_id=1))
    pair[0].flush_tx_buffer()
    assert pair[1].recv(5.0) is not None


def test_passive_node_only_listens(pair: tuple[PharosUdpBus, PharosUdpBus]) -> None:
    assert pair[0].state == can.BusState.ACTIVE
    pair[0].state = can.BusState.PASSIVE
    assert pair[0].state == can.BusState.PASSIVE
    with pytest.raises(can.CanOperationError, match="passive"):
        pair[0].send(can.Message(arbitration_id=1))
    pair[1].send(can.Message(arbitration_id=2))
    assert pair[0].recv(5.0) is not None
    pair[0].state = can.BusState.ACTIVE
    pair[0].send(can.Message(arbitration_id=3))
    assert pair[1].recv(5.0) is not None
    with pytest.raises(can.CanOperationError, match="error"):
        pair[0].state = can.BusState.ERROR


def test_protocol_says_whether_fd_frames_go(channel: str) -> None:
    for fd, protocol in ((False, can.CanProtocol.CAN_20), (True, can.CanProtocol.CAN_FD)):
        with can.Bus(interface="pharos-udp", channel=channel, fd=fd, bitrate=500_000) as bus:
            assert bus.protocol == protocol


def test_shut_down_twice_and_used_afterwards(channel: str) -> None:
    bus = PharosUdpBus(channel)
    for _ in range(2):
        bus.shutdown()
    with pytest.raises(can.CanOperationError, match="shut down"):
        bus.send(can.Message(arbitration_id=1))
    with pytest.raises(can.CanOperationError, match="shut down"):
        bus.recv(0)
    assert bus.fileno() == -1


def test_periodic_frames_go_until_they_are_stopped(
    pair: tuple[PharosUdpBus, PharosUdpBus],
) -> None:
    task = pair[0].send_periodic(can.Message(arbitration_id=1, data=b"a"), 0.002)
    assert isinstance(task, can.broadcastmanager.ThreadBasedCyclicSendTask)
    for _ in range(3):
        assert pair[1].recv(5.0) is not None
    task.modify_data(can.Message(arbitration_id=1, data=b"b"))
    while (got := pair[1].recv(5.0)) is not None and got.data != b"b":
        pass
    assert got is not None
    pair[0].stop_all_periodic_tasks()
    assert task.thread is not None
    task.thread.join(5.0)
    assert not task.thread.is_alive()
    while pair[1].recv(0) is not None:
        pass
    pair[0].send_periodic(can.Message(arbitration_id=2), 0.002)
    assert pair[1].recv(5.0) is not None
    pair[0].shutdown()  # ends its tasks


def test_frames_come_by_iteration_and_by_notifier(
    pair: tuple[PharosUdpBus, PharosUdpBus],
) -> None:
    pair[0].send(can.Message(arbitration_id=1))
    assert next(iter(pair[1])).arbitration_id == 1
    reader = can.BufferedReader()
    notifier = can.Notifier(pair[1], [reader], timeout=0.01)
    pair[0].send(can.Message(arbitration_id=2))
    got = reader.get_message(5.0)
    notifier.stop()
    assert got is not None
    assert got.arbitration_id == 2


def test_filters_are_taken_at_the_opening_and_taken_off(channel: str) -> None:
    only = [{"can_id": 0x100, "can_mask": 0x7FF, "extended": False}]
    with (
        PharosUdpBus(channel) as one,
        can.Bus(interface="pharos-udp", channel=channel, can_filters=only) as other,
    ):
        for identifier in (0x101, 0x100):
            one.send(can.Message(arbitration_id=identifier, is_extended_id=False))
        got = other.recv(5.0)
        assert got is not None
        assert got.arbitration_id == 0x100
        other.filters = None
        one.send(can.Message(arbitration_id=0x101, is_extended_id=False))
        assert other.recv(5.0) is not None


def test_the_default_bus_is_offered() -> None:
    configs = can.detect_available_configs(["pharos-udp"])
    assert [(c["interface"], c["channel"]) for c in configs] == [("pharos-udp", DEFAULT_CHANNEL)]
