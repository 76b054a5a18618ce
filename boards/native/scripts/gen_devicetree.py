# SPDX-License-Identifier: Apache-2.0
"""Write devicetree_generated.h, which the native port's <zephyr/devicetree.h> reads.

A node's identifier is DT_N<ordinal>. Everything known about it is a macro whose name starts with
that identifier, so that a missing node, property or cell is an undeclared name in C: a build error.
"""

from __future__ import annotations

import argparse
import logging
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from devicetree import edtlib  # type: ignore[import-untyped]

PATH_SEPARATORS = re.compile(r"[^A-Za-z0-9_]")
INCLUDE_DIR = Path(__file__).resolve().parent.parent / "include" / "zephyr"


class GeneratorError(Exception):
    """The devicetree cannot be turned into a header; the message is one line for the user."""


def token(name: str) -> str:
    """The name as part of a C identifier, by Zephyr's rule."""
    return PATH_SEPARATORS.sub("_", name.lower())


def c_string(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def node_id(node: edtlib.Node) -> str:
    return f"DT_N{node.dep_ordinal}"


def preprocess(dts: Path) -> str:
    """The devicetree source after #include and #if."""
    command = [
        "cpp", "-x", "assembler-with-cpp", "-nostdinc", "-undef", "-D__DTS__",
        "-I", str(INCLUDE_DIR), "-I", str(INCLUDE_DIR.parent), str(dts),
    ]  # fmt: skip
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    except FileNotFoundError as error:
        raise GeneratorError("the C preprocessor 'cpp' is missing: install gcc") from error
    except subprocess.CalledProcessError as error:
        raise GeneratorError(error.stderr.strip()) from error
    return done.stdout


def load(dts: Path, bindings: list[Path]) -> edtlib.EDT:
    """Parse; a warning of edtlib's is an error here."""
    for path in [dts, *bindings]:
        if not path.exists():
            raise GeneratorError(f"{path}: no such file or folder")
    logging.basicConfig(level=logging.WARNING, format="devicetree: %(message)s")
    with tempfile.NamedTemporaryFile("w", suffix=".dts") as source:
        source.write(preprocess(dts))
        source.flush()
        try:
            return edtlib.EDT(source.name, [str(path) for path in bindings], werror=True)
        except edtlib.EDTError as error:
            raise GeneratorError(str(error).replace(source.name, str(dts))) from error
        except Exception as error:  # dtlib raises its own DTError, which edtlib doesn't export
            if type(error).__name__ != "DTError":
                raise
            raise GeneratorError(str(error).replace(source.name, str(dts))) from error


def check_bound(edt: edtlib.EDT) -> None:
    """A compatible without a binding would silently lose its properties."""
    for node in edt.nodes:
        if node.compats and node.path != "/" and node.matching_compat is None:
            raise GeneratorError(f"{node.path}: no binding for compatible {node.compats[0]!r}")


def phandle_array_lines(prefix: str, entries: list[Any]) -> Iterator[str]:
    for index, entry in enumerate(entries):
        if entry is None:
            continue
        at = f"{prefix}_IDX_{index}"
        yield f"{at}_EXISTS 1"
        yield f"{at}_PH {node_id(entry.controller)}"
        for cell, value in entry.data.items():
            yield f"{at}_VAL_{token(cell)} {value}"
            yield f"{at}_VAL_{token(cell)}_EXISTS 1"
    yield f"{prefix}_LEN {len(entries)}"


def list_lines(prefix: str, items: list[str], suffix: str = "") -> Iterator[str]:
    for index, item in enumerate(items):
        yield f"{prefix}_IDX_{index}{suffix} {item}"
        yield f"{prefix}_IDX_{index}_EXISTS 1"
    yield f"{prefix}_LEN {len(items)}"


def property_lines(prefix: str, prop: edtlib.Property) -> Iterator[str]:
    value, kind = prop.val, prop.type
    yield f"{prefix}_EXISTS 1"
    if kind == "phandle-array":
        yield from phandle_array_lines(prefix, value)
    elif kind in ("phandle", "path"):
        yield from list_lines(prefix, [node_id(value)], "_PH")
    elif kind == "phandles":
        yield from list_lines(prefix, [node_id(node) for node in value], "_PH")
    elif kind in ("array", "uint8-array"):
        items = [str(item) for item in value]
        yield f"{prefix} {{{', '.join(items)}}}"
        yield from list_lines(prefix, items)
    elif kind == "string-array":
        items = [c_string(item) for item in value]
        yield f"{prefix} {{{', '.join(items)}}}"
        yield from list_lines(prefix, items)
    elif kind == "string":
        yield f"{prefix} {c_string(value)}"
        yield f"{prefix}_STRING_TOKEN {PATH_SEPARATORS.sub('_', value)}"
    elif kind in ("int", "boolean"):
        yield f"{prefix} {int(value)}"
    else:
        raise GeneratorError(
            f"{prop.node.path}: property {prop.name}: type {kind} is not supported"
        )
    if prop.enum_index is not None:
        yield f"{prefix}_ENUM_IDX {prop.enum_index}"


def foreach_lines(prefix: str, items: list[str]) -> Iterator[str]:
    yield f"{prefix}(fn) " + " ".join(f"fn({item})" for item in items)
    yield f"{prefix}_VARGS(fn, ...) " + " ".join(f"fn({item}, __VA_ARGS__)" for item in items)


def node_lines(node: edtlib.Node) -> Iterator[str]:
    me = node_id(node)
    yield f"{me}_EXISTS 1"
    yield f"{me}_ORD {node.dep_ordinal}"
    yield f"{me}_PATH {c_string(node.path)}"
    yield f"{me}_FULL_NAME {c_string(node.name)}"
    yield f"{me}_STATUS_{token(node.status)} 1"
    if node.parent is not None:
        yield f"{me}_PARENT {node_id(node.parent)}"
    for compat in node.compats:
        yield f"{me}_COMPAT_MATCHES_{token(compat)} 1"
    yield f"{me}_REG_NUM {len(node.regs)}"
    for index, reg in enumerate(node.regs):
        yield f"{me}_REG_IDX_{index}_ADDRESS {reg.addr}"
        if reg.size is not None:
            yield f"{me}_REG_IDX_{index}_SIZE {reg.size}"
    children = list(node.children.values())
    for child in children:
        if child.regs:
            yield f"{me}_CHILD_AT_{child.regs[0].addr} {node_id(child)}"
    yield from foreach_lines(f"{me}_FOREACH_CHILD", [node_id(child) for child in children])
    okay = [node_id(child) for child in children if child.status == "okay"]
    yield from foreach_lines(f"{me}_FOREACH_CHILD_STATUS_OKAY", okay)
    for prop in node.props.values():
        if prop.name not in ("compatible", "reg", "status"):
            yield from property_lines(f"{me}_P_{token(prop.name)}", prop)


def compat_lines(compat: str, nodes: list[edtlib.Node]) -> Iterator[str]:
    """Instances are numbered with the enabled ones first, each group in source order."""
    prefix = f"DT_COMPAT_{token(compat)}"
    okay = [node for node in nodes if node.status == "okay"]
    for index, node in enumerate(okay + [node for node in nodes if node.status != "okay"]):
        yield f"{prefix}_I{index} {node_id(node)}"
    yield f"{prefix}_NUM_OKAY {len(okay)}"
    if okay:
        yield f"{prefix}_HAS_OKAY 1"
        yield from foreach_lines(f"{prefix}_FOREACH_OKAY", [node_id(node) for node in okay])
        yield from foreach_lines(f"{prefix}_FOREACH_OKAY_INST", [str(i) for i in range(len(okay))])


def header(edt: edtlib.EDT, dts: Path) -> str:
    lines = [
        "/* SPDX-License-Identifier: Apache-2.0 */",
        f"/* Generated by gen_devicetree.py from {dts.name}. */",
        "#ifndef DEVICETREE_GENERATED_H_",
        "#define DEVICETREE_GENERATED_H_",
    ]
    for node in sorted(edt.nodes, key=lambda node: node.dep_ordinal):
        lines += ["", f"/* {node.path} */"]
        lines += [f"#define {line}" for line in node_lines(node)]
    okay = [node_id(node) for node in edt.nodes if node.status == "okay"]
    lines += ["", "/* instances */"]
    lines += [f"#define NATIVE_DT_FOREACH_OKAY_NODE(fn) {' '.join(f'fn({me})' for me in okay)}"]
    for compat, nodes in edt.compat2nodes.items():
        lines += [f"#define {line}" for line in compat_lines(compat, nodes)]
    lines += ["", "/* names */"]
    for label, node in edt.label2node.items():
        lines.append(f"#define DT_NODELABEL_{token(label)} {node_id(node)}")
    for node in edt.nodes:
        lines += [f"#define DT_ALIAS_{token(alias)} {node_id(node)}" for alias in node.aliases]
    for name, node in edt.chosen_nodes.items():
        lines.append(f"#define DT_CHOSEN_{token(name)} {node_id(node)}")
    return "\n".join([*lines, "", "#endif", ""])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dts", type=Path, required=True, help="devicetree source")
    parser.add_argument("--bindings", type=Path, nargs="+", required=True, help="binding folders")
    parser.add_argument("--out", type=Path, required=True, help="header to write")
    args = parser.parse_args()
    try:
        edt = load(args.dts, args.bindings)
        check_bound(edt)
        text = header(edt, args.dts)
    except GeneratorError as error:
        print(f"devicetree: {error}", file=sys.stderr)
        return 1
    args.out.parent.mkdir(parents=True, exist_ok=True)
    if not args.out.exists() or args.out.read_text() != text:
        args.out.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
