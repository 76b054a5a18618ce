#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes imc_vectors.h: the golden packets of imc.json and imc_malformed.json as C.

imc.json holds packets of three independent IMC implementations: their values, and their bytes in
both byte orders. Here the values become literals of the firmware's structs; only the names of
structs and members come from it.

Usage: make_imc.py > imc_vectors.h
"""

from __future__ import annotations

import json
import math
import re
import struct
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent

# Messages with the same fields share a struct.
SHARED = {
    "SetEntityParameters": "entity_parameters",
    "SetLedBrightness": "led_brightness",
    "SetPWM": "pwm",
    "PWM": "pwm",
    "GpioStateSet": "gpio_state",
}
EMPTY = {"QueryEntityState", "QueryEntityActivationState", "Heartbeat", "QueryPowerChannelState"}
# Whose f32 is no f64: the literal has to be of the field's type.
SINGLE = {"value", "angle", "time_remain", "height"}


def snake(name: str) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def text(data: bytes) -> str:
    escaped = "".join(
        chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in data
    )
    return f'{{"{escaped}", {len(data)}}}'


def number(name: str, value: Any, bits: str | None) -> str:
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):  # "NaN", "Infinity", "-Infinity"
        value = float(value)
    suffix = "f" if name in SINGLE else ""
    code = ("<f", "<I") if name in SINGLE else ("<d", "<Q")
    if bits is not None:
        assert struct.unpack(code[1], struct.pack(code[0], value))[0] == int(bits, 16), name
    if math.isnan(value):
        return f'__builtin_nan{suffix}("")'
    if math.isinf(value):
        return f"{'-' if value < 0 else ''}__builtin_inf{suffix}()"
    if name in SINGLE:
        value = struct.unpack("<f", struct.pack("<f", value))[0]
    return f"{float(value).hex()}{suffix}"


def parameters(items: list[dict[str, str]]) -> str:
    """A list as the firmware builds one, little endian."""
    data = b""
    for item in items:
        data += struct.pack("<H", 801)
        for part in (item["name"].encode(), item["value"].encode()):
            data += struct.pack("<H", len(part)) + part
    body = "".join(f"\\{byte:03o}" for byte in data)
    return f'{{(const uint8_t *)"{body}", {len(data)}, {len(items)}, false}}'


def literal(vector: dict[str, Any]) -> str:
    header = vector["header"]
    parts = [
        f".timestamp_s = {number('', float(header['timestamp']), None)}",
        *(f".{name} = {header[name]}" for name in ("src", "src_ent", "dst", "dst_ent")),
    ]
    fields = []
    for name, value in vector["fields"].items():
        raw = vector["raw"].get(name)
        if isinstance(value, list):
            fields.append(f".{name} = {parameters(value)}")
        elif isinstance(value, str) and (raw is None or not raw.startswith("0x")):
            fields.append(f".{name} = {text(bytes.fromhex(raw) if raw else value.encode())}")
        else:
            fields.append(f".{name} = {number(name, value, raw)}")
    member = SHARED.get(vector["name"], snake(vector["name"]))
    body = "" if vector["name"] in EMPTY else f", .{member} = {{{', '.join(fields)}}}"
    return f"{{.header = {{{', '.join(parts)}}}, .message = {{.id = {vector['id']}{body}}}}}"


def array(name: str, data: bytes) -> str:
    return f"static const uint8_t {name}[] = {{{', '.join(f'0x{b:02X}' for b in data) or '0'}}};"


def good() -> None:
    rows = []
    vectors = json.loads((FOLDER / "imc.json").read_text())
    pairs: dict[tuple[str, str], dict[str, Any]] = {}
    for vector in vectors:
        pairs.setdefault((vector["name"], vector["case"]), {})[vector["endian"]] = vector
    for index, ((name, case), both) in enumerate(pairs.items()):
        little, big = (bytes.fromhex(both[order]["hex"]) for order in ("little", "big"))
        print(array(f"imc_vector_{index}_little", little))
        print(array(f"imc_vector_{index}_big", big))
        rows.append(
            f'\t{{"{name} {case}", imc_vector_{index}_little, imc_vector_{index}_big, '
            f"{len(little)}, {literal(both['little'])}}},"
        )
    print("\nstatic const struct imc_vector imc_vectors[] = {")
    print("\n".join(rows))
    print("};\n")


def malformed() -> None:
    rows = []
    vectors = json.loads((FOLDER / "imc_malformed.json").read_text())
    for index, vector in enumerate(vectors):
        data = bytes.fromhex(vector["hex"])
        accepted = "true" if vector["peer_verdict"].startswith("accept") else "false"
        print(array(f"imc_malformed_{index}", data))
        name = f"{vector['case']} {vector['endian']}"
        rows.append(f'\t{{"{name}", imc_malformed_{index}, {len(data)}, {accepted}}},')
    print("\nstatic const struct imc_malformed imc_malformed[] = {")
    print("\n".join(rows))
    print("};")


def main() -> None:
    print("/* SPDX-License-Identifier: Apache-2.0 */")
    print("/* Written by make_imc.py from imc.json and imc_malformed.json; do not edit. */")
    print("/* clang-format off */")
    print(
        "struct imc_vector {\n\tconst char *name;\n\tconst uint8_t *little;\n"
        "\tconst uint8_t *big;\n\tsize_t length;\n\tstruct imc_packet packet;\n};\n"
    )
    print(
        "struct imc_malformed {\n\tconst char *name;\n\tconst uint8_t *bytes;\n"
        "\tsize_t length;\n\tbool accepted;\n};\n"
    )
    good()
    malformed()


if __name__ == "__main__":
    main()
