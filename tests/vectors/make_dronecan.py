#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes dronecan_vectors.h: messages as C literals beside what PyPI's `dronecan` makes of them.

For each type that app/proto/dronecan/generate.py serialises: one message of zeros, one of all
largest values, and three random ones (fixed seed), each as a payload and as frames, classic and FD.
Only the C names come from generate.py; every byte comes from the independent implementation.

Usage: make_dronecan.py > dronecan_vectors.h
"""

from __future__ import annotations

import random
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import dronecan
from dronecan import dsdl, transport

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "app" / "proto" / "dronecan"))
import generate  # noqa: E402

FD_LENGTHS = {*range(9), 12, 16, 20, 24, 32, 48, 64}
PRIORITY, SOURCE, TARGET, TRANSFER_ID = 20, 10, 68, 5


class Maker:
    """One way to choose values: zero, largest or random."""

    def __init__(self, mode: str, rng: random.Random) -> None:
        self.mode = mode
        self.rng = rng

    def scalar(self, kind: Any) -> int | float | bool:
        low, high = kind.value_range
        if kind.kind == dsdl.PrimitiveType.KIND_FLOAT:
            if self.mode == "zero":
                return 0.0
            half = 0x7BFF if self.mode == "max" else self.rng.randrange(0x7C00)
            value = struct.unpack("<e", struct.pack("<H", half))[0]
            return float(value if self.mode == "max" or self.rng.random() < 0.5 else -value)
        if kind.kind == dsdl.PrimitiveType.KIND_SIGNED_INT:
            low, high = -(1 << (kind.bitlen - 1)), (1 << (kind.bitlen - 1)) - 1
        value = {"zero": 0, "max": high}.get(self.mode, self.rng.randint(int(low), int(high)))
        return bool(value) if kind.kind == dsdl.PrimitiveType.KIND_BOOLEAN else int(value)

    def length(self, kind: Any) -> int:
        if not generate.is_dynamic(kind):
            return int(kind.max_size)
        maximum = int(kind.max_size)
        return {"zero": 0, "max": maximum}.get(self.mode, self.rng.randint(0, min(maximum, 40)))

    def value(self, kind: Any) -> Any:
        if generate.is_array(kind):
            return [self.value(kind.value_type) for _ in range(self.length(kind))]
        if generate.is_compound(kind):
            return self.compound(generate.shape_of(kind))
        return self.scalar(kind)

    def compound(self, shape: Any) -> dict[str, Any]:
        fields = [field for field in shape.fields if not generate.is_void(field.type)]
        if shape.union:
            choice = {"zero": fields[0], "max": fields[-1]}.get(self.mode)
            fields = [choice or self.rng.choice(fields)]
        return {field.name: self.value(field.type) for field in fields}


def fill(target: Any, shape: Any, value: dict[str, Any]) -> None:
    """Puts the value into the other implementation's object."""
    for field in shape.fields:
        if field.name not in value:
            continue
        item = value[field.name]
        if shape.union:
            dronecan.switch_union_field(target, field.name)
        if generate.is_array(field.type) and generate.is_compound(field.type.value_type):
            inner = generate.shape_of(field.type.value_type)
            for element in item:
                entry = getattr(target, field.name).new_item()
                fill(entry, inner, element)
                getattr(target, field.name).append(entry)
        elif generate.is_compound(field.type):
            fill(getattr(target, field.name), generate.shape_of(field.type), item)
        else:
            setattr(target, field.name, item)


def scalar_literal(kind: Any, value: Any) -> str:
    if kind.kind == dsdl.PrimitiveType.KIND_BOOLEAN:
        return "true" if value else "false"
    if kind.kind == dsdl.PrimitiveType.KIND_FLOAT:
        return f"{value.hex()}f"
    if kind.kind == dsdl.PrimitiveType.KIND_SIGNED_INT and kind.bitlen > 32:
        return "INT64_MIN" if value == -(1 << 63) else f"{value}ll"
    return f"{value}ull" if value > 0x7FFFFFFF else str(value)


def literal(kind: Any, value: Any) -> str:
    if generate.is_array(kind):
        return "{" + ", ".join(literal(kind.value_type, item) for item in value) + "}"
    if generate.is_compound(kind):
        return shape_literal(generate.shape_of(kind), value)
    return scalar_literal(kind, value)


def shape_literal(shape: Any, value: dict[str, Any]) -> str:
    parts = []
    for field in shape.fields:
        if field.name not in value:
            continue
        if shape.union:
            parts.append(f".tag = {generate.tag_name(shape, field)}")
        if generate.is_empty(field.type):
            continue
        item = value[field.name]
        if generate.is_dynamic(field.type):
            parts.append(f".{field.name}_len = {len(item)}")
            if not item:
                continue
        parts.append(f".{field.name} = {literal(field.type, item)}")
    return "{" + (", ".join(parts) or "0") + "}"


def array(data: bytes) -> str:
    return "{" + ", ".join(f"0x{byte:02X}" for byte in data or b"\0") + "}"


def frames_of(payload: Any, fd: bool, kind: str) -> tuple[int, bytes]:
    """Id of the frames, and the frames one after the other, each with its length before it."""
    message = kind == "MESSAGE"
    transfer = transport.Transfer(
        transfer_id=TRANSFER_ID,
        source_node_id=SOURCE,
        dest_node_id=None if message else TARGET,
        payload=payload,
        transfer_priority=PRIORITY,
        service_not_message=not message,
        request_not_response=kind == "REQUEST",
        canfd=fd,
    )
    frames = transfer.to_frames()
    # Its padding forgets that a frame of 63 bytes does not exist: leave those out.
    if fd and any(len(frame.bytes) not in FD_LENGTHS for frame in frames):
        return transfer.message_id, b""
    return transfer.message_id, b"".join(bytes([len(f.bytes)]) + bytes(f.bytes) for f in frames)


def objects(name: str) -> list[tuple[str, Any, Any]]:
    kind = dronecan.TYPENAMES[name]
    shapes = generate.shapes_of(kind)
    if len(shapes) == 1:
        return [("MESSAGE", kind, shapes[0])]
    return [("REQUEST", kind.Request, shapes[0]), ("RESPONSE", kind.Response, shapes[1])]


def vector_lines() -> Iterator[str]:
    rng = random.Random(3001)
    table = []
    names = []
    for name in generate.TYPES:
        for kind, make, shape in objects(name):
            names.append(shape.name)
            type_name = generate.c_name(name) + "_type"
            modes = ["zero", "max", "random", "random", "random"] if shape.fields else ["zero"]
            for number, mode in enumerate(modes):
                value = Maker(mode, rng).compound(shape)
                payload = make()
                fill(payload, shape, value)
                label = f"{shape.name}_{number}"
                yield f"static const struct {shape.name} {label} = {shape_literal(shape, value)};"
                for fd in (False, True):
                    suffix = "fd" if fd else "classic"
                    bits = payload._pack(not fd)
                    data = bytes(transport.bytes_from_bits(bits))
                    frame_id, frames = frames_of(payload, fd, kind)
                    yield f"static const uint8_t {label}_{suffix}[] = {array(data)};"
                    yield f"static const uint8_t {label}_{suffix}_frames[] = {array(frames)};"
                    table.append(
                        f"\t{{&{type_name}, DRONECAN_{kind}, {'true' if fd else 'false'}, "
                        f"VECTOR_{shape.name}, &{label}, {label}_{suffix}, {len(data)}, "
                        f"0x{frame_id:08X}, {label}_{suffix}_frames, {len(frames)}}},"
                    )
    yield ""
    yield "#define DRONECAN_VECTOR_TYPES(X) \\"
    yield " \\\n".join(f"\tX({name})" for name in names)
    yield ""
    yield "#define VECTOR_ENUM(name) VECTOR_##name,"
    yield "enum dronecan_vector_type { DRONECAN_VECTOR_TYPES(VECTOR_ENUM) };"
    yield ""
    yield "static const struct dronecan_vector {"
    yield "\tconst struct dronecan_type *type;"
    yield "\tenum dronecan_kind kind;"
    yield "\tbool fd;"
    yield "\tenum dronecan_vector_type codec;"
    yield "\tconst void *message;"
    yield "\tconst uint8_t *payload;"
    yield "\tsize_t size;"
    yield "\tuint32_t frame_id;"
    yield "\tconst uint8_t *frames; /* each with its length before it */"
    yield "\tsize_t frames_size;    /* 0: the other implementation pads wrongly here */"
    yield "} dronecan_vectors[] = {"
    yield from table
    yield "};"


def half_lines() -> Iterator[str]:
    """Single precision -> half precision, by the other implementation."""
    rng = random.Random(16)
    yield ""
    yield "static const struct { uint32_t single; uint16_t half; } dronecan_halves[] = {"
    singles = [0x00000000, 0x80000000, 0x3F800000, 0xBF800000, 0x477FE000, 0x33800000, 0x387FC000]
    # Rounding at 2^-24 and below differs between implementations by its steps; stay above.
    singles += [
        rng.randrange(0x38800000, 0x47800000) | rng.choice((0, 1 << 31)) for _ in range(200)
    ]
    for single in singles:
        value = struct.unpack("<f", struct.pack("<I", single))[0]
        field = transport.PrimitiveValue(dsdl.PrimitiveType(dsdl.PrimitiveType.KIND_FLOAT, 16, 0))
        field.value = value
        yield f"\t{{0x{single:08X}u, 0x{int(field._bits, 2):04X}u}},"
    yield "};"


def main() -> None:
    print("/* SPDX-License-Identifier: Apache-2.0 */")
    print("/* Written by make_dronecan.py with PyPI's dronecan; do not edit. */")
    print("/* clang-format off */")
    print(f"#define DRONECAN_VECTOR_PRIORITY {PRIORITY}")
    print(f"#define DRONECAN_VECTOR_SOURCE {SOURCE}")
    print(f"#define DRONECAN_VECTOR_TARGET {TARGET}")
    print(f"#define DRONECAN_VECTOR_TRANSFER_ID {TRANSFER_ID}")
    print()
    for line in (*vector_lines(), *half_lines()):
        print(line)


if __name__ == "__main__":
    main()
