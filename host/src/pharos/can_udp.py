# SPDX-License-Identifier: Apache-2.0
"""A CAN bus without kernel CAN, as a python-can interface: `interface="pharos-udp"`.

One UDP datagram per frame, multicast on loopback; many nodes, no broker, no root. Groups, port and
framing are those of `mcast:N` in PyPI's dronecan, the DroneCAN GUI Tool and ArduPilot's simulator.
Little endian: magic u16 0x2934, CRC16-CCITT (seed 0xFFFF) u16 over the rest, flags u16 (bit 0: FD),
id u32 (bit 31: extended; bit 30: remote frame; bit 29: error frame, as SocketCAN's), data 0 … 64
bytes.

channel: a bus number, 0 … 255 ("": 0), which is the group 239.65.82.N on port 57732; or HOST:PORT,
another group or loopback's broadcast address. It sends on loopback, and hears this machine only.
"""

from __future__ import annotations

import binascii
import ctypes
import socket
import struct
import sys
import time
from collections.abc import Sequence
from typing import Any

import can
from can.typechecking import CanFilters

from .errors import UrlError
from .link import parse_address, parse_number, wait_readable

GROUP = "239.65.82."
PORT = 57732
DEFAULT_CHANNEL = "0"
NAME = "pharos-udp"
# What stands before a channel in this bus's own name, and on the light's command line.
PREFIXES = (f"{NAME}/", "udp:", "mcast:")
MAGIC = 0x2934
FLAG_FD = 0x0001
ID_EXTENDED = 1 << 31
ID_REMOTE = 1 << 30
ID_ERROR = 1 << 29
ID_MASK = ID_ERROR - 1
# magic, CRC, flags, id
HEADER = struct.Struct("<HHHI")
FRAME_MAX = HEADER.size + 64
RECEIVE_BUFFER = 4 << 20
FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)


def encode(message: can.Message) -> bytes:
    """The datagram that carries `message`."""
    identifier = message.arbitration_id
    identifier |= ID_EXTENDED if message.is_extended_id else 0
    identifier |= ID_REMOTE if message.is_remote_frame else 0
    identifier |= ID_ERROR if message.is_error_frame else 0
    body = struct.pack("<HI", FLAG_FD if message.is_fd else 0, identifier) + bytes(message.data)
    return struct.pack("<HH", MAGIC, binascii.crc_hqx(body, 0xFFFF)) + body


def decode(datagram: bytes) -> can.Message | None:
    """The frame in `datagram`; None if it is none: too short, other magic, bad CRC, bad length."""
    if not HEADER.size <= len(datagram) <= FRAME_MAX:
        return None
    magic, crc, flags, identifier = HEADER.unpack_from(datagram)
    if magic != MAGIC or crc != binascii.crc_hqx(datagram[4:], 0xFFFF):
        return None
    data = datagram[HEADER.size :]
    fd = bool(flags & FLAG_FD)
    if len(data) not in FD_LENGTHS or (not fd and len(data) > 8):
        return None
    extended = bool(identifier & ID_EXTENDED)
    if not extended and identifier & ID_MASK > 0x7FF:
        return None
    return can.Message(
        arbitration_id=identifier & ID_MASK,
        is_extended_id=extended,
        is_remote_frame=bool(identifier & ID_REMOTE) and not fd,
        is_error_frame=bool(identifier & ID_ERROR),
        is_fd=fd,
        data=data,
        is_rx=True,
    )


class ChannelError(UrlError, can.CanInitializationError):
    """The channel is malformed or cannot be opened: an error of this package and of python-can."""


class PharosUdpBus(can.BusABC):
    """A node on the user-space bus. fd=True lets it send and receive CAN FD frames.

    A frame is on the bus once send() returns, so nothing is ever queued. `state` PASSIVE only
    listens. What else an interface is usually opened with (bitrate, timing) is of no account.

    Counters: `received`, `malformed` (datagrams that were no frame), `unexpected_fd` (FD frames
    that a classic node cannot hear).
    """

    def __init__(
        self,
        channel: Any = "",
        can_filters: CanFilters | None = None,
        *,
        fd: bool = False,
        receive_own_messages: bool = False,
        **kwargs: object,
    ) -> None:
        self._channel, self._target = parse_channel(str("" if channel is None else channel))
        self._fd = fd
        self._receive_own = receive_own_messages
        self._state = can.BusState.ACTIVE
        self.received = 0
        self.malformed = 0
        self.unexpected_fd = 0
        self.channel_info = f"{NAME}/{self._channel}"
        try:
            self._receiver, self._sender = _open(self._target)
        except OSError as error:
            raise ChannelError(f"{self.channel_info}: {error.strerror}") from error
        self._own_port = self._sender.getsockname()[1]
        self._can_protocol = can.CanProtocol.CAN_FD if fd else can.CanProtocol.CAN_20
        super().__init__(channel=channel, can_filters=can_filters, **kwargs)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if self._is_shutdown:
            _refuse(f"{self.channel_info} is shut down")
        if self._state != can.BusState.ACTIVE:
            _refuse(f"{self.channel_info} is passive: it only listens")
        if msg.is_fd and not self._fd:
            _refuse("a CAN FD frame on a classic bus: open it with fd=True")
        if len(msg.data) > 8 and not msg.is_fd:
            _refuse(f"{len(msg.data)} bytes do not fit into a classic frame")
        if len(msg.data) not in FD_LENGTHS:
            _refuse(f"{len(msg.data)} bytes is no length of a CAN FD frame: pad it")
        try:
            self._sender.sendto(encode(msg), self._target)
        except OSError as error:
            raise can.CanOperationError(f"{self.channel_info}: {error.strerror}") from error

    def flush_tx_buffer(self) -> None:
        """Nothing to discard: what was sent is on the bus."""

    @property
    def state(self) -> can.BusState:
        return self._state

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        if new_state == can.BusState.ERROR:
            _refuse("no node is put into the state of error")
        self._state = new_state

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        deadline = None if timeout is None else time.monotonic() + timeout
        while not self._is_shutdown:
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            if not wait_readable(self._receiver.fileno(), left):
                return None, False
            message = self._read()
            if message is not None:
                return message, False
        raise can.CanOperationError(f"{self.channel_info} is shut down")

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """The next frame that passes the filters. timeout 0: only what is already there, however
        little host time has passed; so it suits a bus whose time is simulated."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            message, _ = self._recv_internal(left)
            if message is None or self._matches_filters(message):
                return message

    def _read(self) -> can.Message | None:
        try:
            datagram, source = self._receiver.recvfrom(FRAME_MAX + 1)
        except BlockingIOError:
            return None
        except OSError as error:
            raise can.CanOperationError(f"{self.channel_info}: {error.strerror}") from error
        if source[1] == self._own_port and not self._receive_own:
            return None
        message = decode(datagram)
        if message is None:
            self.malformed += 1
            return None
        if message.is_fd and not self._fd:
            self.unexpected_fd += 1
            return None
        self.received += 1
        message.timestamp = time.time()
        message.channel = self.channel_info
        message.is_rx = source[1] != self._own_port
        return message

    def fileno(self) -> int:
        return self._receiver.fileno()

    def shutdown(self) -> None:
        super().shutdown()
        self._receiver.close()
        self._sender.close()

    @staticmethod
    def _detect_available_configs() -> Sequence[can.typechecking.AutoDetectedConfig]:
        return [{"interface": NAME, "channel": DEFAULT_CHANNEL}]


def _refuse(reason: str) -> None:
    raise can.CanOperationError(reason)


def parse_channel(channel: str) -> tuple[str, tuple[str, int]]:
    """Its shortest name and its address. ChannelError says what is wrong in one line."""
    for prefix in PREFIXES:
        channel = channel.removeprefix(prefix)
    channel = channel or DEFAULT_CHANNEL
    bus = parse_number(channel)
    if bus is not None and bus <= 255:
        return str(bus), (f"{GROUP}{bus}", PORT)
    try:
        host, port = parse_address(channel, channel)
        if port == 0:
            raise UrlError("no bus is on port 0")
        address = socket.gethostbyname(host)
    except UrlError as error:
        raise ChannelError(
            f"'{channel}' is no channel of {NAME}: expected 0 … 255 or HOST:PORT"
        ) from error
    except OSError as error:
        raise ChannelError(f"'{host}' in channel '{channel}': {error.strerror}") from error
    number = address.removeprefix(GROUP)
    if port == PORT and number != address:
        return number, (address, port)
    return f"{address}:{port}", (address, port)


def _open(target: tuple[str, int]) -> tuple[socket.socket, socket.socket]:
    """The socket that hears the bus and the one that speaks, which speaks on loopback only."""
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        receiver.setblocking(False)
        receiver.bind(target)
        if 224 <= int(target[0].partition(".")[0]) < 240:
            loopback = socket.inet_aton("127.0.0.1")
            group = socket.inet_aton(target[0]) + loopback
            _hear_this_machine_only(receiver)
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, loopback)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        else:
            sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        sender.bind(("127.0.0.1", 0))
    except OSError:
        receiver.close()
        sender.close()
        raise
    return receiver, sender


def _hear_this_machine_only(receiver: socket.socket) -> None:
    """Programs here that join the group on the network's interface (`mcast:0` does, where that has
    the route) are heard, other machines on that network are not: the kernel drops what came in as
    multicast from outside. On loopback, a packet comes as one to this host."""
    if sys.platform != "linux":
        return
    attach_filter, packet_type, multicast = 26, -0x1000 + 4, 2  # <linux/filter.h>, <if_packet.h>
    code = struct.pack("=HBBI", 0x30, 0, 0, packet_type & 0xFFFFFFFF)  # load byte
    code += struct.pack("=HBBI", 0x15, 0, 1, multicast)  # jump if equal
    code += struct.pack("=HBBI", 0x06, 0, 0, 0)  # drop
    code += struct.pack("=HBBI", 0x06, 0, 0, 0xFFFFFFFF)  # take
    buffer = ctypes.create_string_buffer(code)
    program = struct.pack("@HP", len(code) // 8, ctypes.addressof(buffer))
    receiver.setsockopt(socket.SOL_SOCKET, attach_filter, program)
