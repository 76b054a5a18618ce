# SPDX-License-Identifier: Apache-2.0
"""Write docs/parameters.md from the firmware's parameter table (app/core/params_table.h), with the
native build's defaults. `make parameters` runs this; --check only compares."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "app" / "threads"))

import metadata  # noqa: E402

PAGE = Path(__file__).with_name("parameters.md")

INTRODUCTION = """# Parameters

Made by `make parameters` from `app/core/params_table.h`; defaults are those of the native build.

Every value is a whole number of 32 bits. A value out of its range, one that does not go with a
related one (`THR_RECOVER` < `THR_THROTTLE` < `THR_SHUTDOWN`, …), and a set of a read-only one are
refused and change nothing. What is set is stored: a power cut leaves the old or the new value.

- **MAVLink**: PARAM_REQUEST_LIST, PARAM_REQUEST_READ and PARAM_SET to the illuminator's component,
  which serves the whole table; the gimbal's serves none. Type INT32, bytewise; other integer types
  and whole REAL32 numbers are taken. A refused set is answered by PARAM_ERROR and by PARAM_VALUE
  with what is in force. A list takes 45 % of its link.
- **DroneCAN**: `uavcan.protocol.param.GetSet`, as integers; whole real values are taken as well.
- **Shell**: `param list`, `param get NAME`, `param set NAME VALUE`, `param reset`.

Units: `ppm` parts per million (10 000 ppm = 1 %), `mdegC` thousandths of a degree Celsius, `mdeg`
thousandths of a degree.
"""

TITLES = {
    "LIGHT": "Light, programs and beacon",
    "ARBITER": "Who commands, and link loss",
    "THERMAL": "Heat",
    "SYNC": "External sync",
    "MAVLINK": "MAVLink",
    "DRONECAN": "CAN and DroneCAN",
    "IMC": "IMC and what the UARTs speak",
    "GIMBAL": "Gimbal",
}


def in_force(entry: dict[str, Any]) -> str:
    if entry.get("readOnly"):
        return "read-only"
    return "after a reset" if entry.get("rebootRequired") else "at once"


def page_of(expanded: str) -> str:
    lines = [INTRODUCTION]
    group = ""
    for row in metadata.calls(expanded, "PHAROS_ROW"):
        entry = metadata.parameter(row)
        if entry["group"] != group:
            group = entry["group"]
            lines += ["", f"## {TITLES.get(group, group.capitalize())}", ""]
            lines += ["| name | default | range | unit | in force | meaning |"]
            lines += ["|---|---|---|---|---|---|"]
        cells = (
            f"`{entry['name']}`",
            str(entry["default"]),
            f"{entry['min']} … {entry['max']}",
            entry.get("units", ""),
            in_force(entry),
            metadata.text_of(row[7]),
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines).replace("\n\n\n", "\n\n") + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "native")
    parser.add_argument("--check", action="store_true", help="only compare with the page there")
    arguments = parser.parse_args()
    try:
        expanded = metadata.preprocess("cc", arguments.build / "generated" / "autoconf.h")
        page = page_of(expanded)
    except metadata.MetadataError as error:
        print(f"parameters.py: {error}", file=sys.stderr)
        return 1
    if arguments.check:
        if not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != page:
            print(f"{PAGE} is stale: run `make parameters`", file=sys.stderr)
            return 1
        return 0
    PAGE.write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
