#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Generate the MAVLink dialect for C and Python from pymavlink's definitions and our additions.

Writes below --out:
  include/pharos/, include/common/, ...  C headers, wire protocol 2.0
  include/pharos_crc_extra.h             id and CRC_EXTRA of every message that the wheel knows
  include/pharos_targets.h               where their target ids lie
  python/pharos_dialect.py               the same dialect for pymavlink's users
Reads no network: the definitions come from the installed pymavlink wheel.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import shutil
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, NamedTuple

# id: (name, CRC_EXTRA, length without extensions); from MAVLink's common.xml as of mid 2026.
EXPECTED = {
    80: ("COMMAND_CANCEL", 14, 4),
    300: ("PROTOCOL_VERSION", 217, 22),
    345: ("PARAM_ERROR", 209, 21),
    396: ("COMPONENT_INFORMATION_BASIC", 50, 160),
    397: ("COMPONENT_METADATA", 182, 108),
    440: ("ILLUMINATOR_STATUS", 66, 35),
}

# A payload has at most 255 bytes, so no field is there.
NO_TARGET = 255
# In pharos_targets[].
TARGET_AT = 0x7F
TARGET_COMPONENT = 0x80


class GenerateError(Exception):
    """The dialect can't be generated; the text says why."""


def wheel_definitions() -> tuple[Path, str]:
    """Folder of the wheel's dialect XML files, and the wheel's version."""
    try:
        import pymavlink  # type: ignore[import-untyped]
    except ImportError as error:
        raise GenerateError(
            f"pymavlink is not installed for {sys.executable}; "
            "run `make setup`, or `pip install pymavlink`"
        ) from error
    folder = Path(pymavlink.__file__).parent / "dialects" / "v20"
    if not (folder / "common.xml").is_file():
        raise GenerateError(f"{folder}/common.xml is missing: is the pymavlink wheel complete?")
    from importlib.metadata import version

    return folder, version("pymavlink")


def with_includes(path: Path) -> list[Path]:
    """path and every file that it includes, itself first."""
    found = [path]
    for current in found:
        for include in ElementTree.parse(current).getroot().iter("include"):
            target = (current.parent / (include.text or "").strip()).resolve()
            if target not in [known.resolve() for known in found]:
                found.append(target)
    return found


def present_in(files: list[Path]) -> tuple[dict[int, str], dict[str, set[str]]]:
    """Messages by id, and names of the entries of each enum, defined in these files."""
    messages: dict[int, str] = {}
    enums: dict[str, set[str]] = {}
    for path in files:
        root = ElementTree.parse(path).getroot()
        for message in root.iter("message"):
            messages[int(message.attrib["id"])] = message.attrib["name"]
        for enum in root.iter("enum"):
            entries = enums.setdefault(enum.attrib["name"], set())
            entries.update(entry.attrib["name"] for entry in enum.iter("entry"))
    return messages, enums


def drop_present(dialect: ElementTree.Element, files: list[Path]) -> list[str]:
    """Remove from our dialect what the wheel defines itself. Returns what was dropped."""
    messages, enums = present_in(files)
    dropped: list[str] = []
    for parent in dialect.iter("messages"):
        for message in list(parent):
            number, name = int(message.attrib["id"]), message.attrib["name"]
            theirs = messages.get(number)
            if theirs is None:
                continue
            if theirs != name:
                raise GenerateError(f"message {number} is {name} here but {theirs} in the wheel")
            parent.remove(message)
            dropped.append(name)
    for parent in dialect.iter("enums"):
        for enum in list(parent):
            known = enums.get(enum.attrib["name"], set())
            for entry in [entry for entry in enum.iter("entry") if entry.attrib["name"] in known]:
                enum.remove(entry)
                dropped.append(entry.attrib["name"])
            if enum.find("entry") is None:
                parent.remove(enum)
    return dropped


def stage(dialect_xml: Path, wheel: Path, staging: Path) -> tuple[Path, list[str]]:
    """Our dialect, reduced, beside copies of the wheel's files that it includes."""
    staging.mkdir(parents=True, exist_ok=True)
    files = with_includes(wheel / "common.xml")
    for path in files:
        shutil.copyfile(path, staging / path.name)
    try:
        tree = ElementTree.parse(dialect_xml)
    except ElementTree.ParseError as error:
        raise GenerateError(f"{dialect_xml}: {error}") from error
    dropped = drop_present(tree.getroot(), files)
    staged = staging / dialect_xml.name
    tree.write(staged, encoding="utf-8", xml_declaration=True)
    return staged, dropped


def run_mavgen(staged: Path, output: Path, language: str) -> None:
    """One run of mavgen, quiet unless it fails. The schema check is off: it may want a network."""
    from pymavlink.generator import mavgen, mavparse  # type: ignore[import-untyped]

    said = io.StringIO()
    options: Any = mavgen.Opts(
        str(output), wire_protocol=mavparse.PROTOCOL_2_0, language=language, validate=False
    )
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            done = mavgen.mavgen(options, [str(staged)])
    except (Exception, SystemExit) as error:
        raise GenerateError(f"mavgen ({language}) failed: {error}\n{said.getvalue()}") from error
    if not done:
        raise GenerateError(f"mavgen ({language}) refused the dialect:\n{said.getvalue()}")


def drop_functions(include: Path) -> None:
    """Leave types and constants in the messages' headers: nobody calls what packs and unpacks, and
    most of the time to compile a file that includes them all would go there."""
    for path in include.rglob("mavlink_msg_*.h"):
        types, found, _ = path.read_text(encoding="utf-8").partition("/**\n * @brief Pack a ")
        if not found:
            raise GenerateError(f"{path}: no function that packs {path.stem}")
        path.write_text(types, encoding="utf-8")


class Message(NamedTuple):
    """What others understand a message by. Offsets of its target ids, NO_TARGET: it has none."""

    name: str
    crc_extra: int
    min_length: int  # without extensions
    target_system: int = NO_TARGET
    target_component: int = NO_TARGET

    def targets(self) -> str:
        """In a byte: the offset behind the target system's, 0: none; and whether the target
        component is there."""
        if self.target_system == NO_TARGET and self.target_component == NO_TARGET:
            return "0"
        behind = self.target_system + 1
        if self.target_component not in (behind, NO_TARGET) or behind > TARGET_AT:
            raise GenerateError(f"{self.name}: target ids at offsets that are not known")
        return f"{behind | (0 if self.target_component == NO_TARGET else TARGET_COMPONENT):#04x}"


def parse_messages(files: list[Path]) -> dict[int, Message]:
    """Messages by id. Earlier files win."""
    from pymavlink.generator import mavparse

    found: dict[int, Message] = {}
    for path in files:
        with contextlib.redirect_stdout(io.StringIO()):
            parsed = mavparse.MAVXML(str(path), mavparse.PROTOCOL_2_0)
        for message in parsed.message:
            offsets = {field.name: field.wire_offset for field in message.fields}
            row = Message(
                message.name,
                message.crc_extra,
                message.wire_min_length,
                offsets.get("target_system", NO_TARGET),
                offsets.get("target_component", NO_TARGET),
            )
            found.setdefault(message.id, row)
    return found


def check(messages: dict[int, Message]) -> None:
    """The messages that decide whether others understand us have the values known to be right."""
    for number, expected in EXPECTED.items():
        found = messages.get(number)
        if found is None or found[:3] != expected:
            raise GenerateError(
                f"message {number}: expected (name, CRC_EXTRA, length) {expected}, "
                f"the definitions give {found}"
            )


def write_table(
    path: Path,
    guard: str,
    arrays: list[tuple[str, str, list[str]]],
    constants: dict[str, int] | None = None,
) -> None:
    """A header of constant arrays, (type, name, elements), and constants."""
    lines = [
        "/* Generated by app/proto/mavlink/generate.py: every message that pymavlink knows. */",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        "#include <stdint.h>",
        "",
        *(f"#define {name} {value:#04x}u" for name, value in (constants or {}).items()),
    ]
    for kind, name, elements in arrays:
        lines += [f"static const {kind} {name}[] = {{", *(f"\t{e}," for e in elements), "};", ""]
    path.write_text("\n".join([*lines, "#endif", ""]), encoding="utf-8")


def write_tables(include: Path, messages: dict[int, Message]) -> None:
    """Arrays sorted by id, so that frames of any dialect can be verified, and routed."""
    numbers = sorted(number for number in messages if number <= 0xFFFF)
    rows = [messages[number] for number in numbers]
    write_table(
        include / "pharos_crc_extra.h",
        "PHAROS_CRC_EXTRA_H",
        [
            ("uint16_t", "pharos_crc_extra_ids", [str(number) for number in numbers]),
            ("uint8_t", "pharos_crc_extra", [str(row.crc_extra) for row in rows]),
        ],
    )
    write_table(
        include / "pharos_targets.h",
        "PHAROS_TARGETS_H",
        [("uint8_t", "pharos_targets", [row.targets() for row in rows])],
        {"PHAROS_TARGET_AT": TARGET_AT, "PHAROS_TARGET_COMPONENT": TARGET_COMPONENT},
    )


def generate(dialect_xml: Path, out: Path) -> list[str]:
    """Everything, into out. Returns lines worth telling."""
    if not dialect_xml.is_file():
        raise GenerateError(f"no dialect file {dialect_xml}")
    wheel, version = wheel_definitions()
    staged, dropped = stage(dialect_xml, wheel, out / "xml")
    said = []
    if dropped:
        said.append(
            f"pymavlink {version} has come to include {', '.join(dropped)}: "
            f"using the wheel's, please drop them from {dialect_xml.name}"
        )
    ours = parse_messages([staged, *with_includes(staged)[1:]])
    check(ours)
    include = out / "include"
    run_mavgen(staged, include, "C")
    drop_functions(include)
    (out / "python").mkdir(parents=True, exist_ok=True)
    run_mavgen(staged, out / "python" / "pharos_dialect.py", "Python3")
    everything = wheel / "all.xml"
    others = with_includes(everything) if everything.is_file() else []
    write_tables(include, parse_messages(others) | ours)
    return said


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    default_xml = Path(__file__).parent / "dialect" / "pharos.xml"
    parser.add_argument("--dialect", type=Path, default=default_xml, help="our dialect XML")
    parser.add_argument("--out", type=Path, required=True, help="folder to write into")
    parser.add_argument("--stamp", type=Path, help="file to touch when done")
    arguments = parser.parse_args()
    try:
        for line in generate(arguments.dialect, arguments.out):
            print(f"note: {line}")
        if arguments.stamp is not None:
            arguments.stamp.touch()
    except (GenerateError, OSError) as error:
        print(f"generate.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
