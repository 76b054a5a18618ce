# SPDX-License-Identifier: Apache-2.0
"""docs/parameters.md is what the table says."""

from __future__ import annotations

import re
import subprocess
import sys

from harness import BUILD, COMPONENTS, ROOT, Light
from parameters import ask_list
from pharos import Target


def test_the_page_is_not_stale() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "docs" / "parameters.py", "--build", BUILD, "--check"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


def test_the_page_has_every_parameter_of_the_light_and_its_default(udp_light: Light) -> None:
    page = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (-?[\d.]+) \|", page, re.MULTILINE))
    if 154 not in COMPONENTS:  # no servos: the light has these two of the gimbal
        mine = ("GMB_ENABLE", "GMB_COMPID")
        rows = {n: value for n, value in rows.items() if n in mine or not n.startswith("GMB_")}
    udp_light.mav.inbox.clear()
    ask_list(udp_light.mav, Target(1, 0))  # the light and its gimbal
    came = [m for m in udp_light.collect(5) if m.get_type() == "PARAM_VALUE"]
    assert {m.param_id for m in came} == set(rows)
    assert rows["THR_SHUTDOWN"] == "100"  # CONFIG_PHAROS_THERMAL_SHUTDOWN_MDEGC
