# SPDX-License-Identifier: Apache-2.0
"""IMC packets to and from bytes, in either byte order, and a stream of bytes into packets."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from typing import Any

from ..errors import PharosError
from .table import BY_ID, BY_NAME, Field, Kind

SYNC = 0xFE54
HEADER_SIZE = 20
FOOTER_SIZE = 2
# A stream waits for no longer payload than this: what claims more is a false start.
STREAM_PAYLOAD_MAX = 8192
EVERYONE = 0xFFFF
ALL_ENTITIES = 255

_HEADER = "HHHdHBHB"
_SCALARS = {"u8": "B", "u16": "H", "u32": "I", "f32": "f", "f64": "d"}
_RANGES = {"u8": 0xFF, "u16": 0xFFFF, "u32": 0xFFFFFFFF}


class ImcError(PharosError):
    """Bytes that are no IMC packet, or values that no packet can hold."""


@dataclass
class Message:
    """A message by its name, and its fields; texts are bytes."""

    name: str
    fields: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:
        return self.fields[name]

    @property
    def kind(self) -> Kind:
        return BY_NAME[self.name]


@dataclass
class Packet:
    """A message and whatever its header says."""

    message: Message
    src: int = 0x4001
    src_ent: int = ALL_ENTITIES
    dst: int = EVERYONE
    dst_ent: int = ALL_ENTITIES
    timestamp: float = 0.0
    raw: bytes = field(default=b"", compare=False, repr=False)  # as it came

    @property
    def name(self) -> str:
        return self.message.name

    def __getitem__(self, name: str) -> Any:
        return self.message[name]


def message(name: str, /, **fields: Any) -> Message:
    """A message; str becomes UTF-8, fields not given are zero, empty or none."""
    kind = BY_NAME.get(name)
    if kind is None:
        raise ImcError(f"'{name}' is no IMC message of this light")
    unknown = fields.keys() - {f.name for f in kind.fields}
    if unknown:
        raise ImcError(f"{name} has no field {', '.join(sorted(unknown))}")
    empty = {"text": b"", "list": []}
    values = {f.name: fields.get(f.name, empty.get(f.kind, 0)) for f in kind.fields}
    return Message(name, {n: v.encode() if isinstance(v, str) else v for n, v in values.items()})


def _crc_table() -> list[int]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
        table.append(value)
    return table


_CRC = _crc_table()


def checksum(data: bytes) -> int:
    """CRC-16/ARC: 0xBB3D for b"123456789"."""
    crc = 0
    for byte in data:
        crc = crc >> 8 ^ _CRC[(crc ^ byte) & 0xFF]
    return crc


# --- to bytes ---------------------------------------------------------------------------------


def _put_field(order: str, what: Field, value: Any) -> bytes:
    if what.kind == "text":
        if len(value) > 0xFFFF:
            raise ImcError(f"{what.name}: longer than 65535 bytes")
        return struct.pack(order + "H", len(value)) + bytes(value)
    if what.kind == "list":
        items = [struct.pack(order + "H", m.kind.id) + _put_fields(order, m) for m in value]
        return struct.pack(order + "H", len(items)) + b"".join(items)
    if what.kind in _RANGES and not 0 <= value <= _RANGES[what.kind]:
        raise ImcError(f"{what.name}: {value} is not within 0…{_RANGES[what.kind]}")
    try:
        return struct.pack(order + _SCALARS[what.kind], value)
    except (struct.error, OverflowError) as error:
        raise ImcError(f"{what.name}: {value!r}: {error}") from None


def _put_fields(order: str, what: Message) -> bytes:
    return b"".join(_put_field(order, f, what.fields[f.name]) for f in what.kind.fields)


def encode(packet: Packet, *, big_endian: bool = False) -> bytes:
    """The packet's bytes, little endian unless asked otherwise."""
    order = ">" if big_endian else "<"
    body = _put_fields(order, packet.message)
    if len(body) > 0xFFFF:
        raise ImcError(f"{packet.name}: longer than 65535 bytes")
    try:
        header = struct.pack(
            order + _HEADER, SYNC, packet.message.kind.id, len(body), packet.timestamp,
            packet.src, packet.src_ent, packet.dst, packet.dst_ent,
        )  # fmt: skip
    except struct.error as error:
        raise ImcError(f"{packet.name}: header: {error}") from None
    data = header + body
    return data + struct.pack(order + "H", checksum(data))


# --- from bytes -------------------------------------------------------------------------------


class _Reader:
    def __init__(self, order: str, data: bytes) -> None:
        self.order = order
        self.data = data
        self.at = 0

    def take(self, count: int) -> bytes:
        if count > len(self.data) - self.at:
            raise ImcError("the payload is too short")
        self.at += count
        return self.data[self.at - count : self.at]

    def scalar(self, code: str) -> Any:
        return struct.unpack(self.order + code, self.take(struct.calcsize("<" + code)))[0]

    def field(self, what: Field) -> Any:
        if what.kind == "text":
            return self.take(self.scalar("H"))
        if what.kind == "list":
            return [self.message(self.scalar("H")) for _ in range(self.scalar("H"))]
        return self.scalar(_SCALARS[what.kind])

    def message(self, number: int) -> Message:
        kind = BY_ID.get(number)
        if kind is None:
            raise ImcError(f"message {number} is not known")
        return Message(kind.name, {f.name: self.field(f) for f in kind.fields})


def order_of(data: bytes) -> str:
    """struct's sign for the byte order of a packet; ImcError: no packet begins like that."""
    for order in "<>":
        if data[:2] == struct.pack(order + "H", SYNC):
            return order
    raise ImcError("no sync number")


def decode(data: bytes) -> Packet:
    """A whole packet. Bytes behind its payload's last field, and behind it, are ignored."""
    order = order_of(data)
    if len(data) < HEADER_SIZE + FOOTER_SIZE:
        raise ImcError("shorter than header and checksum")
    _, number, size, timestamp, src, src_ent, dst, dst_ent = struct.unpack_from(
        order + _HEADER, data
    )
    end = HEADER_SIZE + size
    if len(data) < end + FOOTER_SIZE:
        raise ImcError("shorter than its header says")
    if struct.unpack_from(order + "H", data, end)[0] != checksum(data[:end]):
        raise ImcError("the checksum is wrong")
    what = _Reader(order, data[HEADER_SIZE:end]).message(number)
    return Packet(what, src, src_ent, dst, dst_ent, timestamp, data[: end + FOOTER_SIZE])


class Stream:
    """Bytes of a stream into packets. What is no packet is skipped, byte by byte."""

    def __init__(self) -> None:
        self._bytes = b""
        self.skipped = 0

    def feed(self, data: bytes) -> list[Packet]:
        """The packets that are whole now."""
        self._bytes += data
        packets: list[Packet] = []
        while (used := self._take(packets)) > 0:
            self._bytes = self._bytes[used:]
        return packets

    def _take(self, packets: list[Packet]) -> int:
        """How many bytes at the front are done with; 0: more are needed."""
        data = self._bytes
        if len(data) < 2:
            return 0
        try:
            order = order_of(data)
            if len(data) < HEADER_SIZE:
                return 0
            size = struct.unpack_from(order + "H", data, 4)[0]
            length = HEADER_SIZE + size + FOOTER_SIZE
            if size <= STREAM_PAYLOAD_MAX and len(data) < length:
                return 0
            packets.append(decode(data[:length]))
        except ImcError:
            self.skipped += 1
            return 1
        return int(length)
