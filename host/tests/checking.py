# SPDX-License-Identifier: Apache-2.0
"""What the tests of `pharos check` share."""

from __future__ import annotations

from typing import Any

from model_light import ModelLight
from pharos import MavlinkConnection, Simulator
from pharos.check import (
    Level,
    Report,
    check,
    find,
    selected,
)

# What a fault of the lamp breaks that a light sensor sees.
OPTICAL_FAULTS: dict[str, tuple[str, ...]] = {
    "is dark for good": ("OP-1", "OP-2", "OP-3", "OP-4"),
    "stays lit when it is off": ("OP-1", "OP-2", "OP-3", "OP-4"),
    "strobes 10 % too slowly": ("OP-2",),
    "takes lit for dark": ("OP-3",),
    "flashes where it should be steady": ("OP-4",),
}


def checked(light: ModelLight, *only: str, **options: Any) -> Report:
    connection = MavlinkConnection(light, light, light.d)
    connection.target = find(connection, None)
    return check(connection, selected(only), **options)


def failing(report: Report, level: Level) -> list[str]:
    return [
        r.requirement.id
        for r in report.results
        if r.outcome == "failed" and r.requirement.level == level
    ]


def on_simulator(sim: Simulator, connection: MavlinkConnection, **options: Any) -> Report:
    sim.advance(s=2)
    connection.target = find(connection, None)
    report = check(connection, **options)
    assert sim.outputs()["enable"] == 0
    return report
