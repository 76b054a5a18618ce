# SPDX-License-Identifier: Apache-2.0
"""A CAN bus without kernel CAN, as a python-can interface: `interface="pharos-udp"`.

One UDP datagram per frame, broadcast on loopback; many nodes, no broker, no root. The framing is
that of ArduPilot's multicast CAN, little endian: magic u16 0x2934, CRC16-CCITT (seed 0xFFFF) u16
over the rest, flags u16 (bit 0: FD), id u32 (bit 31: extended; bit 30: remote frame; bit 29: error
frame, as SocketCAN's), data 0 … 64 bytes.

channel: "HOST:PORT" or "" for the default. A host in 224.0.0.0/4 is a multicast group, joined and
kept on loopback (239.65.82.B:57732 is what the simulator uses).
"""

from __future__ import annotations

import binascii
import select
import socket
import struct
import time
from collections.abc import Sequence
from typing import Any

import can
from can.typechecking import CanFilters

from .errors import UrlError

DEFAULT_CHANNEL = "127.255.255.255:57732"
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


class PharosUdpBus(can.BusABC):
    """A node on the user-space bus. fd=True lets it send and receive CAN FD frames.

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
        self._target = _parse_channel(str(channel or DEFAULT_CHANNEL))
        self._fd = fd
        self._receive_own = receive_own_messages
        self.received = 0
        self.malformed = 0
        self.unexpected_fd = 0
        self._receiver, self._sender = _open(self._target)
        self._own_port = self._sender.getsockname()[1]
        self.channel_info = f"pharos-udp {self._target[0]}:{self._target[1]}"
        self._can_protocol = can.CanProtocol.CAN_FD if fd else can.CanProtocol.CAN_20
        super().__init__(channel=channel, can_filters=can_filters, **kwargs)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
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

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            if not select.select([self._receiver], [], [], left)[0]:
                return None, False
            message = self._read()
            if message is not None:
                return message, False

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
        datagram, source = self._receiver.recvfrom(FRAME_MAX + 1)
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
        return [{"interface": "pharos-udp", "channel": DEFAULT_CHANNEL}]


def _refuse(reason: str) -> None:
    raise can.CanOperationError(reason)


def _parse_channel(channel: str) -> tuple[str, int]:
    host, colon, port = channel.rpartition(":")
    if not colon or not port.isdecimal() or not 0 < int(port) < 65536:
        raise UrlError(f"'{channel}' is no channel of pharos-udp: expected HOST:PORT")
    try:
        return socket.gethostbyname(host), int(port)
    except OSError as error:
        raise UrlError(f"'{host}' in channel '{channel}': {error.strerror}") from error


def _open(target: tuple[str, int]) -> tuple[socket.socket, socket.socket]:
    """The socket that hears the bus and the one that speaks, both on loopback."""
    multicast = 224 <= int(target[0].partition(".")[0]) < 240
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        receiver.bind(target)
        if multicast:
            loopback = socket.inet_aton("127.0.0.1")
            group = socket.inet_aton(target[0]) + loopback
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, loopback)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        else:
            sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        sender.bind(("127.0.0.1", 0))
    except OSError as error:
        receiver.close()
        sender.close()
        raise UrlError(f"pharos-udp {target[0]}:{target[1]}: {error.strerror}") from error
    return receiver, sender
