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

Every value is in the unit that people use, and alike over every protocol. A value between two steps
becomes the nearer one and is answered as it was taken; where there is no unit (a choice, an id, a
count) a fraction is refused. A value out of its range, one that does not go with a related one
(`THR_RECOVER` < `THR_THROTTLE` < `THR_SHUTDOWN`, …), and a set of a read-only one are refused and
change nothing. What is set is stored: a power cut leaves the old or the new value.

- **MAVLink**: PARAM_REQUEST_LIST, PARAM_REQUEST_READ and PARAM_SET. The gimbal's component has the
  gimbal's parameters but for `GMB_ENABLE` and `GMB_COMPID`, the light's has these and all others;
  each list is complete in itself. All of the light's come in one file over MAVLink FTP as well,
  `@PARAM/param.pck`. Type REAL32, which every ground station reads alike; sets of integer types are
  taken too, bytewise, as that number of the unit. A refused set is answered by PARAM_ERROR
  (not over MAVLink 1, which has none) and by PARAM_VALUE with what is in force. A list takes 46 %
  of its link.
- **DroneCAN**: `uavcan.protocol.param.GetSet`; what has a step below 1 as a real value, the rest as
  an integer. Sets of either kind are taken.
- **IMC**: EntityParameters, as text such as `80.5`.
- **Shell**: `param list`, `param get NAME`, `param set NAME VALUE`, `param reset`.

Files of MAVProxy, Mission Planner and QGroundControl load and save.
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


def text_of(value: float | int) -> str:
    """Without an exponent."""
    return str(value) if isinstance(value, int) else f"{value:.6f}".rstrip("0")


def page_of(expanded: str) -> str:
    lines = [INTRODUCTION]
    group = ""
    for row in metadata.calls(expanded, "PHAROS_ROW"):
        entry = metadata.parameter(row)
        if entry["group"] != group:
            group = entry["group"]
            lines += ["", f"## {TITLES.get(group, group.capitalize())}", ""]
            lines += ["| name | default | range | unit | step | in force | meaning |"]
            lines += ["|---|---|---|---|---|---|---|"]
        cells = (
            f"`{entry['name']}`",
            text_of(entry["default"]),
            f"{text_of(entry['min'])} … {text_of(entry['max'])}",
            entry.get("units", ""),
            text_of(entry["increment"]),
            in_force(entry),
            metadata.text_of(row[8]),
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
