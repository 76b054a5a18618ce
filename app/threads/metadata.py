#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Generate the illuminator's metadata, MAVLink's general and parameter JSON, from the table.

The C preprocessor reads the table (core/params_table.h) with the build's configuration, so a row is
what the firmware has. Writes --out: a C file with both, for threads/metadata.h.
Spec: mavlink.io/en/services/component_metadata.html and the schemas of mavlink/component_metadata.
"""

from __future__ import annotations

import argparse
import ast
import json
import lzma
import operator
import re
import subprocess
import sys
import zlib
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

APP = Path(__file__).resolve().parents[1]

GENERAL_NAME = "general.json"
PARAMETERS_NAME = "parameters.json.xz"
GENERAL_VERSION = 1
PARAMETERS_VERSION = 3
COMP_METADATA_TYPE_PARAMETER = 1

SNIPPET = """
#include "core/limits.h"
#include "core/params_table.h"
#include "version.h"
#define ROW(name, group, unit, decimals, min, max, fallback, flags, meaning) \\
    PHAROS_ROW(#name, #group, unit, decimals, min, max, fallback, flags, meaning)
PARAMS_TABLE(ROW)
PHAROS_ABOUT(CONFIG_PHAROS_VENDOR_NAME, CONFIG_PHAROS_MODEL_NAME, PHAROS_VERSION,
             CONFIG_PHAROS_HARDWARE_MAJOR, CONFIG_PHAROS_HARDWARE_MINOR)
"""

FLAGS = {"PARAM_FLAG_REBOOT": "rebootRequired", "PARAM_FLAG_READ_ONLY": "readOnly"}

OPERATORS: dict[type, Callable[..., int]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.USub: operator.neg,
}


class MetadataError(Exception):
    """The metadata can't be generated; the text says why."""


def preprocess(compiler: str, autoconf: Path) -> str:
    """The snippet, expanded."""
    command = [compiler, "-E", "-P", "-ffreestanding", "-imacros", str(autoconf)]
    command += ["-I", str(APP), "-x", "c", "-"]
    done = subprocess.run(command, input=SNIPPET, capture_output=True, text=True)
    if done.returncode != 0:
        raise MetadataError(f"{' '.join(command)}:\n{done.stderr}")
    return done.stdout


def calls(text: str, name: str) -> list[list[str]]:
    """Arguments of every name(…) in text, as they are written."""
    found = []
    for match in re.finditer(rf"\b{name}\(", text):
        arguments, depth = [""], 0
        for token in re.finditer(r'"(?:\\.|[^"\\])*"|.', text[match.end() :], re.DOTALL):
            if token[0] == "," and depth == 0:
                arguments.append("")
                continue
            depth += (token[0] == "(") - (token[0] == ")")
            if depth < 0:
                break
            arguments[-1] += token[0]
        found.append([argument.strip() for argument in arguments])
    return found


def text_of(literals: str) -> str:
    """The value of one or several C string literals."""
    parts = re.findall(r'"(?:\\.|[^"\\])*"', literals)
    if not parts or re.sub(r'"(?:\\.|[^"\\])*"', "", literals).strip():
        raise MetadataError(f"not a string: {literals}")
    return "".join(json.loads(part) for part in parts)


def number_of(expression: str) -> int:
    """The value of a constant expression of integers."""
    plain = re.sub(r"\b(\d\w*?)[uUlL]+\b", r"\1", expression)

    def value(node: ast.expr) -> int:
        if isinstance(node, ast.Constant) and isinstance(node.value, int):
            return node.value
        if isinstance(node, ast.UnaryOp) and type(node.op) in OPERATORS:
            return OPERATORS[type(node.op)](value(node.operand))
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
            return OPERATORS[type(node.op)](value(node.left), value(node.right))
        raise MetadataError(f"not a whole number: {expression}")

    try:
        return value(ast.parse(plain, mode="eval").body)
    except SyntaxError as error:
        raise MetadataError(f"not a whole number: {expression}") from error


def choices(meaning: str, low: int, high: int) -> tuple[str, dict[str, Any]]:
    """Splits "Curve: 0 linear, 1 perceptual" into "Curve" and its values, when these are all of
    low…high; "Sources: sum of 1 MAVLink, 2 IMC" into "Sources" and its bits."""
    what, _, rest = meaning.partition(": ")
    bits = rest.startswith("sum of ")
    parts = rest.removeprefix("sum of ").split(", ")
    pairs = [re.fullmatch(r"(-?\d+) (.+)", part) for part in parts]
    known = [(int(pair[1]), pair[2]) for pair in pairs if pair is not None]
    numbers = [number for number, _ in known]
    if len(known) != len(pairs):
        return meaning, {}
    if bits and low == 0 and sum(numbers) == high:
        listed = [{"index": n.bit_length() - 1, "description": text} for n, text in known]
        return what, {"bitmask": listed}
    if not bits and numbers == list(range(low, high + 1)):
        return what, {"values": [{"value": n, "description": text} for n, text in known]}
    return meaning, {}


def natural(value: int, decimals: int) -> float | int:
    """What people read for the core's integer."""
    exact = Fraction(value, 10**decimals)
    return int(exact) if exact.denominator == 1 else float(exact)


def parameter(row: list[str]) -> dict[str, Any]:
    """A row of the table as the schema has it."""
    name, group, unit = (text_of(cell) for cell in row[:3])
    decimals, low, high, fallback = (number_of(cell) for cell in row[3:7])
    flags = [word.strip(" ()") for word in row[7].split("|")]
    unknown = [flag for flag in flags if flag not in FLAGS and flag != "0"]
    if unknown:
        raise MetadataError(f"{name}: no such flag: {', '.join(unknown)}")
    what, listed = choices(text_of(row[8]), low, high)
    said: dict[str, Any] = {"name": name, "type": "Float", "group": group, "shortDesc": what}
    if unit:
        said["units"] = unit
    said |= {"decimalPlaces": decimals, "increment": natural(1, decimals)}
    said |= {"default": natural(fallback, decimals)}
    said |= {"min": natural(low, decimals), "max": natural(high, decimals)} | listed
    said |= {FLAGS[flag]: True for flag in flags if flag in FLAGS}
    if "readOnly" in said:
        said["volatile"] = True
    return said


def is_illuminators(entry: dict[str, Any]) -> bool:
    """Whether the illuminator's component lists it: mavlink_params_is() in param_service.c."""
    return entry["group"] != "GIMBAL" or entry["name"] in ("GMB_ENABLE", "GMB_COMPID")


def crc32(data: bytes) -> int:
    """MAVLink's: from 0, not inverted at the end (mavlink.io/en/guide/crc.html)."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def as_json(content: dict[str, Any]) -> bytes:
    return json.dumps(content, separators=(",", ":"), ensure_ascii=False).encode()


def compress(plain: bytes) -> bytes:
    """xz with CRC-32, the one check that every embedded unpacker knows."""
    how = {"preset": 9 | lzma.PRESET_EXTREME, "dict_size": 1 << 16, "pb": 0}
    filters = [{"id": lzma.FILTER_LZMA2, **how}]
    return lzma.compress(plain, lzma.FORMAT_XZ, lzma.CHECK_CRC32, filters=filters)


def metadata(text: str) -> dict[str, bytes]:
    """Files by name, the general one first."""
    rows = calls(text, "PHAROS_ROW")
    if not rows or any(len(row) != 9 for row in rows):
        raise MetadataError(f"the table does not have rows of 9 cells: {rows[:1]}")
    vendor, model, version, major, minor = calls(text, "PHAROS_ABOUT")[0]
    table = [entry for entry in map(parameter, rows) if is_illuminators(entry)]
    parameters = compress(as_json({"version": PARAMETERS_VERSION, "parameters": table}))
    general = as_json(  # too short to become shorter
        {
            "version": GENERAL_VERSION,
            "vendorName": text_of(vendor),
            "modelName": text_of(model),
            "firmwareVersion": text_of(version),
            "hardwareVersion": f"{number_of(major)}.{number_of(minor)}.0",
            "metadataTypes": [
                {
                    "type": COMP_METADATA_TYPE_PARAMETER,
                    "uri": f"mftp://{PARAMETERS_NAME}",
                    "fileCrc": crc32(parameters),
                }
            ],
        }
    )
    return {GENERAL_NAME: general, PARAMETERS_NAME: parameters}


def c_source(files: dict[str, bytes]) -> str:
    lines = ["/* Generated by app/threads/metadata.py. */", '#include "threads/metadata.h"', ""]
    rows = []
    for name, data in files.items():
        symbol = name.partition(".")[0]
        lines.append(f"static const uint8_t {symbol}[] = {{")
        for at in range(0, len(data), 16):
            lines.append("\t" + " ".join(f"0x{byte:02x}," for byte in data[at : at + 16]))
        lines += ["};", ""]
        rows.append(f'\t{{"{name}", {symbol}, sizeof({symbol}), 0x{crc32(data):08x}u}},')
    lines += ["static const struct mavlink_file files[] = {", *rows, "};", ""]
    lines += [f"const struct mavlink_files metadata_files = {{files, {len(files)}}};", ""]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--compiler", required=True, help="C compiler of the build")
    parser.add_argument("--autoconf", required=True, type=Path, help="the build's autoconf.h")
    parser.add_argument("--out", required=True, type=Path, help="C file to write")
    args = parser.parse_args()
    try:
        files = metadata(preprocess(args.compiler, args.autoconf))
    except (MetadataError, OSError) as error:
        print(f"metadata.py: {error}", file=sys.stderr)
        return 1
    args.out.parent.mkdir(parents=True, exist_ok=True)
    args.out.write_text(c_source(files), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
