# SPDX-License-Identifier: Apache-2.0
"""DroneCAN transfers from and to CAN frames, classic and FD, without a bus or a clock.

The payloads are those of the official DSDL definitions, packed and unpacked by PyPI's `dronecan`.
Its own framing is not used: it gives some FD transfers a last frame of a length that CAN FD does
not have, and takes frames whose toggle bit is wrong.
"""

from __future__ import annotations

import binascii
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import dronecan
from dronecan import transport

from .can_udp import FD_LENGTHS

START, END, TOGGLE = 0x80, 0x40, 0x20
TID_MASK = 0x1F
# A transfer whose next frame is later than this is given up [µs].
TIMEOUT_US = 2_000_000
PAYLOAD_MAX = 1024


@dataclass(frozen=True)
class Header:
    """What a 29-bit id says. destination: services only; source 0: anonymous."""

    type_id: int
    source: int
    priority: int = 20
    destination: int | None = None
    is_request: bool = False

    @property
    def is_service(self) -> bool:
        return self.destination is not None

    @property
    def identifier(self) -> int:
        if self.destination is None:
            return self.priority << 24 | self.type_id << 8 | self.source
        request = 0x8000 if self.is_request else 0
        service = self.type_id << 16 | request | self.destination << 8 | 0x80
        return self.priority << 24 | service | self.source


def parse_identifier(identifier: int) -> Header:
    priority, source = identifier >> 24 & 0x1F, identifier & 0x7F
    if identifier & 0x80:
        return Header(
            identifier >> 16 & 0xFF,
            source,
            priority,
            identifier >> 8 & 0x7F,
            bool(identifier & 0x8000),
        )
    # Anonymous: only the two lowest bits are the type, the others tell senders apart.
    type_id = identifier >> 8 & (0xFFFF if source else 0x3)
    return Header(type_id, source, priority)


@dataclass(frozen=True)
class Transfer:
    """A complete transfer; `message` is an object of PyPI's dronecan."""

    header: Header
    transfer_id: int
    message: Any
    fd: bool

    @property
    def kind(self) -> Any:
        """The DSDL type."""
        return transport.get_dronecan_data_type(self.message)


def data_type(type_id: int, is_service: bool) -> Any | None:
    kinds = dronecan.dsdl.CompoundType
    kind = kinds.KIND_SERVICE if is_service else kinds.KIND_MESSAGE
    return dronecan.DATATYPES.get((type_id, kind))


def pack(message: Any, fd: bool) -> bytes:
    """The payload. CAN FD has no tail array optimisation."""
    bits = message._pack(tao=not fd)
    return bytes(transport.bytes_from_bits(bits + "0" * (-len(bits) % 8)))


def unpack(kind: Any, header: Header, payload: bytes, fd: bool) -> Any:
    """ValueError: the payload is not of that type."""
    mode = ("request" if header.is_request else "response") if header.is_service else None
    message = kind(_mode=mode) if mode else kind()
    try:
        message._unpack(transport.bits_from_bytes(bytearray(payload)), tao=not fd)
    except (IndexError, ValueError, dronecan.UAVCANException) as error:
        raise ValueError(f"not a {kind.full_name}: {error}") from error
    return message


def split(payload: bytes, crc_seed: int, transfer_id: int, fd: bool) -> Iterator[bytes]:
    """The data of each frame. crc_seed: CRC over the type's signature (its `base_crc`)."""
    room = 63 if fd else 7
    if len(payload) > room:
        # The last frame's data, its tail byte included, must be of a length that CAN FD has; what
        # fills it up counts for the CRC.
        last = (len(payload) + 2) % room or room
        padded = next(n for n in FD_LENGTHS if n > last) - 1 if fd else last
        payload += bytes(padded - last)
        payload = binascii.crc_hqx(payload, crc_seed).to_bytes(2, "little") + payload
    elif fd:
        payload += bytes(next(n for n in FD_LENGTHS if n > len(payload)) - 1 - len(payload))
    pieces = [payload[at : at + room] for at in range(0, len(payload), room)] or [b""]
    for index, piece in enumerate(pieces):
        tail = transfer_id & TID_MASK
        tail |= START if index == 0 else 0
        tail |= END if index == len(pieces) - 1 else 0
        tail |= TOGGLE if index % 2 else 0
        yield piece + bytes([tail])


@dataclass
class _Session:
    """What one source sends of one type to one destination."""

    transfer_id: int = 0
    expects_toggle: int = 0
    active: bool = False
    payload: bytes = b""
    updated_us: int = 0
    first: bytes = b""  # the first frame's data, its tail byte included
    finished: tuple[bytes, int] | None = None  # first frame, time


class Assembler:
    """Frames to transfers. Counts what it drops: `errors` (broken transfers: lost or reordered
    frames, CRC, payload), `repeated`, `unknown` (types without a definition)."""

    def __init__(self) -> None:
        self.errors = 0
        self.repeated = 0
        self.unknown = 0
        self._sessions: dict[int, _Session] = {}

    def receive(self, now_us: int, identifier: int, data: bytes, fd: bool) -> Transfer | None:
        """The transfer that this frame completes."""
        if not data:
            self.errors += 1
            return None
        tail = data[-1]
        session = self._sessions.setdefault(identifier, _Session())
        if session.active and now_us - session.updated_us > TIMEOUT_US:
            self._drop(session)
        if tail & START:
            if session.active:
                self._drop(session)
            if not self._begin(session, now_us, data):
                return None
        elif (
            not session.active
            or session.transfer_id != tail & TID_MASK
            or session.expects_toggle != tail & TOGGLE
        ):
            # A frame that came twice is no harm; anything else is a hole. Where the toggle bit
            # cannot tell, the CRC does.
            if session.transfer_id == tail & TID_MASK:
                self.repeated += 1
            else:
                self._drop(session)
            return None
        session.updated_us = now_us
        session.expects_toggle ^= TOGGLE
        session.payload += data[:-1]
        if len(session.payload) > PAYLOAD_MAX:
            self._drop(session)
            return None
        if not tail & END:
            return None
        session.active = False
        session.finished = (session.first, now_us)
        return self._finish(session, parse_identifier(identifier), bool(tail & START), fd)

    def _drop(self, session: _Session) -> None:
        session.active = False
        self.errors += 1

    def _begin(self, session: _Session, now_us: int, data: bytes) -> bool:
        tail = data[-1]
        if tail & TOGGLE:
            self.errors += 1
            return False
        # With other data (its CRC is among them) it is another's: two nodes have one id.
        last, last_us = session.finished or (b"", 0)
        if last == data and now_us - last_us <= TIMEOUT_US:
            self.repeated += 1
            return False
        session.active = True
        session.first = data
        session.transfer_id = tail & TID_MASK
        session.expects_toggle = 0
        session.payload = b""
        return True

    def _finish(
        self, session: _Session, header: Header, is_single: bool, fd: bool
    ) -> Transfer | None:
        kind = data_type(header.type_id, header.is_service)
        if kind is None:
            self.unknown += 1
            return None
        payload = session.payload
        if not is_single:
            crc, payload = int.from_bytes(payload[:2], "little"), payload[2:]
            if crc != binascii.crc_hqx(payload, kind.base_crc):
                self.errors += 1
                return None
        try:
            message = unpack(kind, header, payload, fd)
        except ValueError:
            self.errors += 1
            return None
        return Transfer(header, session.transfer_id, message, fd)
