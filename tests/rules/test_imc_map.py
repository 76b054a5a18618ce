# SPDX-License-Identifier: Apache-2.0
"""docs/imc.md tells people what the code's table of IMC names and ids has."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NAMED = {"power", "led", "gpio"}
# How the page says what a row of the code is; {} is its number.
THINGS = {
    "POWER_CHANNEL": "power channel {}",
    "LAMP": "the lamp",
    "LED": "indicator LED {}",
    "GPIO_OUTPUT": "output {}",
    "GPIO_INPUT": "input {}",
    "PWM": "auxiliary output {}",
    "PAN": "pan",
    "TILT": "tilt",
    "THRUSTER": "the thruster",
    "FOCUS": "the beam's zoom",
}


def _of_code() -> list[tuple[str, str, str]]:
    source = (ROOT / "app/proto/imc/actuation_map.c").read_text()
    rows = re.findall(
        r'\{IMC_MAP_(\w+), (\d+), "(\w+)", IMC_THING_(\w+), (\w+)\}',
        source.replace("POWER_CHANNEL_LAMP", "0"),
    )
    assert len(rows) == source.count("{IMC_MAP_")
    return [
        (space.lower(), name if space.lower() in NAMED else number, THINGS[thing].format(which))
        for space, number, name, thing, which in rows
    ]


def _of_page() -> list[tuple[str, str, str]]:
    page = (ROOT / "docs/imc.md").read_text(encoding="utf-8")
    table = page.split("| messages | address | is |\n|---|---|---|\n")[1].split("\n\n")[0]
    rows = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in table.split("\n")]
    return [(space, address, what.split(",")[0]) for space, address, what in rows]


def test_the_page_has_the_rows_of_the_code() -> None:
    assert _of_page() == _of_code()


def test_the_page_names_every_message_of_the_group() -> None:
    ids = dict(
        re.findall(
            r"IMC_(\w+) = (\d+),",
            (ROOT / "app/proto/imc/messages.h").read_text(),
        )
    )
    group = {number for number in ids.values() if 300 <= int(number) <= 316 or int(number) >= 2000}
    group -= {ids["VERSION_INFO"]}
    page = (ROOT / "docs/imc.md").read_text(encoding="utf-8")
    named = {number for number, _ in re.findall(r"^\| (\d+) \| ([A-Z]\w+) \|", page, re.MULTILINE)}
    assert len(group) == 20
    assert group <= named


def test_the_page_names_the_aliases_of_the_board() -> None:
    source = (ROOT / "app/threads/devices.c").read_text()
    aliases = re.findall(r"(?:GPIO|PWM)_OR_NONE\((\w+)\)", source.split("actuator_devices = {")[1])
    page = (ROOT / "docs/imc.md").read_text(encoding="utf-8")
    assert len(aliases) == 15
    for alias in [name.replace("_", "-") for name in aliases]:
        assert f"`{alias}`" in page, alias
