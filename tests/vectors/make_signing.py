#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Make signing_frames.h: the frames of tests/system/signing_attacks.py, signed by pymavlink, and
what each gets.

    python tests/vectors/make_signing.py --dialect build/native/generated/mavlink/python
"""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "system"))

from signing_attacks import ATTACKS, KEY, Forge

# 2024-07-01, in units of 10 µs since 2015.
LAST = 29_972_160_000_000


def array(name: str, data: bytes) -> list[str]:
    rows = [data[at : at + 12] for at in range(0, len(data), 12)]
    lines = ["\t" + " ".join(f"0x{byte:02X}," for byte in row) for row in rows]
    return [f"static const uint8_t {name}[] = {{", *lines, "};", ""]


def text_of(forge: Forge) -> str:
    lines = [
        "/* SPDX-License-Identifier: Apache-2.0 */",
        "/* Made by make_signing.py: frames that pymavlink signs, and what each gets. */",
        "/* clang-format off */",
        "#ifndef PHAROS_TESTS_VECTORS_SIGNING_FRAMES_H",
        "#define PHAROS_TESTS_VECTORS_SIGNING_FRAMES_H",
        "",
        "#include <stdbool.h>",
        "#include <stddef.h>",
        "#include <stdint.h>",
        "",
        f"#define SIGNING_LAST UINT64_C({forge.last})",
        "",
        *array("SIGNING_KEY", KEY),
        *array("SIGNING_RECORDED", forge.recorded),
    ]
    for index, attack in enumerate(ATTACKS):
        lines += array(f"SIGNING_{index}", attack.make(forge))
    lines += [
        '/* counter "": none, there is no whole frame. acted: the command is carried out. */',
        "static const struct signing_attack {",
        "\tconst char *name;",
        "\tconst char *counter;",
        "\tbool acted;",
        "\tconst uint8_t *bytes;",
        "\tsize_t length;",
        "} SIGNING_ATTACKS[] = {",
    ]
    for index, attack in enumerate(ATTACKS):
        acted = "true" if attack.acted else "false"
        lines += [
            f'\t{{"{attack.name}", "{attack.counter}",',
            f"\t {acted}, SIGNING_{index}, sizeof(SIGNING_{index})}},",
        ]
    return "\n".join([*lines, "};", "", "#endif", ""])


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--dialect", type=Path, required=True, help="folder of pharos_dialect.py")
    default = Path(__file__).parent / "signing_frames.h"
    parser.add_argument("--out", type=Path, default=default, help="header to write")
    parser.add_argument("--check", action="store_true", help="only compare with the header there")
    arguments = parser.parse_args()
    sys.path.insert(0, str(arguments.dialect))
    text = text_of(Forge(importlib.import_module("pharos_dialect"), LAST))
    if arguments.check:
        if arguments.out.read_text(encoding="utf-8") != text:
            print(f"make_signing.py: {arguments.out} differs", file=sys.stderr)
            return 1
        return 0
    arguments.out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
