#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Make mavlink_frames.h: frames that pymavlink packs, for tests that must agree with it.

    python tests/vectors/make_mavlink.py --dialect build/native/generated/mavlink/python

Each frame's comment is the call that made it. The numbers in the calls are those that the tests
command, and those that the messages must then carry.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path
from typing import Any

GROUND = (255, 190)
LIGHT = (1, 243)
KEY = bytes(range(32))

# name, sender, version 1?, sequence, signed?, message, arguments
FRAMES: list[tuple[str, tuple[int, int], bool, int, bool, str, tuple[Any, ...]]] = [
    (
        "COMMAND_ON_V2",
        GROUND,
        False,
        7,
        False,
        "command_long",
        (1, 243, 405, 0, 1, 0, 0, 0, 0, 0, 0),
    ),
    (
        "COMMAND_ON_V1",
        GROUND,
        True,
        7,
        False,
        "command_long",
        (1, 243, 405, 0, 1, 0, 0, 0, 0, 0, 0),
    ),
    (
        "COMMAND_INT_ON",
        GROUND,
        False,
        8,
        False,
        "command_int",
        (1, 243, 0, 405, 0, 0, 1, 0, 0, 0, 0, 0, 0),
    ),
    (
        "COMMAND_CONFIGURE",
        GROUND,
        False,
        9,
        False,
        "command_long",
        (1, 243, 406, 0, 1, 33.3, 0.05, 12.5, 0, 0, 0),
    ),
    ("ACK_ON_V2", LIGHT, False, 0, False, "command_ack", (405, 0, 0, 0, 255, 190)),
    ("ACK_ON_V1", LIGHT, True, 0, False, "command_ack", (405, 0)),
    ("HEARTBEAT", LIGHT, False, 0, False, "heartbeat", (44, 8, 0, 0, 4)),
    ("HEARTBEAT_SIGNED", GROUND, False, 3, True, "heartbeat", (6, 8, 0, 0, 4)),
    (
        "STATUS_CONFIGURED",
        LIGHT,
        False,
        1,
        False,
        "illuminator_status",
        (1500, 0, 3, 0, 1, 33.3, 0.05, 12.5, 41.25, 0.01, 10.0),
    ),
    (
        "BASIC",
        LIGHT,
        False,
        1,
        False,
        "component_information_basic",
        (2000, 8248, 1700000000, b"Pharos", b"Light", b"1.2.3", b"4.5.6", b"SN-0042"),
    ),
    ("INTERVAL_OF_STATUS", LIGHT, False, 1, False, "message_interval", (440, 1000000)),
    (
        "VERSION_1_2_3",
        LIGHT,
        False,
        1,
        False,
        "autopilot_version",
        (8248, 0x010203FF, 0, 0, 0, bytes(8), bytes(8), bytes(8), 0, 0, 0x42),
    ),
    ("PROTOCOL", LIGHT, False, 1, False, "protocol_version", (200, 100, 200, bytes(8), bytes(8))),
    ("PING_QUESTION", GROUND, False, 10, False, "ping", (123456789, 77, 0, 0)),
    ("PING_ANSWER", LIGHT, False, 0, False, "ping", (123456789, 77, 255, 190)),
    ("TIMESYNC_QUESTION", GROUND, False, 11, False, "timesync", (0, 555666777888)),
    ("PARAM_READ_UNKNOWN", GROUND, False, 12, False, "param_request_read", (1, 243, b"NONE", -1)),
    ("PARAM_ERROR_UNKNOWN", LIGHT, False, 0, False, "param_error", (255, 190, b"NONE", -1, 1)),
    ("PARAM_LIST", GROUND, False, 13, False, "param_request_list", (1, 243)),
    ("PARAM_SET_CURVE", GROUND, False, 14, False, "param_set", (1, 243, b"LGT_CURVE", 0.0, 6)),
    ("TEXT_THROTTLING", LIGHT, False, 0, False, "statustext", (4, b"Thermal throttling begins")),
]


def frame_of(dialect: Any, row: tuple[Any, ...]) -> bytes:
    _, sender, version_1, sequence, signed, message, arguments = row
    # Packed for version 1 by pymavlink's version 2 dialects, extensions would be sent; the
    # specification and the version 1 dialects leave them out.
    module = importlib.import_module("pymavlink.dialects.v10.common") if version_1 else dialect
    link = module.MAVLink(None, srcSystem=sender[0], srcComponent=sender[1])
    link.seq = sequence
    if signed:
        link.signing.secret_key = KEY
        link.signing.link_id = 1
        link.signing.timestamp = 0x0123456789AB
        link.signing.sign_outgoing = True
    packed = getattr(link, f"{message}_encode")(*arguments)
    return bytes(packed.pack(link))


def comment_of(row: tuple[Any, ...]) -> str:
    _, sender, version_1, sequence, signed, message, arguments = row
    extra = ", MAVLink 1" if version_1 else ""
    extra += ", signed" if signed else ""
    values = ", ".join(str(value) for value in arguments)
    return f"/* {sender[0]}/{sender[1]} seq {sequence}{extra}: {message}_encode({values}) */"


def text_of(dialect: Any) -> str:
    lines = [
        "/* SPDX-License-Identifier: Apache-2.0 */",
        "/* Made by make_mavlink.py: frames that pymavlink packs. */",
        "/* clang-format off */",
        "#ifndef PHAROS_TESTS_VECTORS_MAVLINK_FRAMES_H",
        "#define PHAROS_TESTS_VECTORS_MAVLINK_FRAMES_H",
        "",
        "#include <stdint.h>",
        "",
    ]
    for row in FRAMES:
        data = frame_of(dialect, row)
        lines.append(comment_of(row))
        lines.append(f"static const uint8_t {row[0]}[] = {{")
        for at in range(0, len(data), 12):
            lines.append("\t" + " ".join(f"0x{byte:02X}," for byte in data[at : at + 12]))
        lines += ["};", ""]
    lines += ["#endif", ""]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--dialect", type=Path, required=True, help="folder of pharos_dialect.py")
    default = Path(__file__).parent / "mavlink_frames.h"
    parser.add_argument("--out", type=Path, default=default, help="header to write")
    parser.add_argument("--check", action="store_true", help="only compare with the header there")
    arguments = parser.parse_args()
    sys.path.insert(0, str(arguments.dialect))
    try:
        dialect = importlib.import_module("pharos_dialect")
    except ImportError as error:
        print(f"make_mavlink.py: {error}; build first", file=sys.stderr)
        return 1
    text = text_of(dialect)
    if arguments.check:
        if arguments.out.read_text(encoding="utf-8") != text:
            print(f"make_mavlink.py: {arguments.out} differs", file=sys.stderr)
            return 1
        return 0
    arguments.out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
