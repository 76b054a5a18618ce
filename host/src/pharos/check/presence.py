# SPDX-License-Identifier: Apache-2.0
"""Discovery and heartbeat."""

from __future__ import annotations

from ..light import TYPE_ILLUMINATOR
from .bench import OBSERVATION_US, Bench, Heard
from .spec import COMMON, Level, NotOffered, expect, group, requirement

CONNECTION = "Illuminator Protocol, Illuminator Connection"
ILLUMINATOR_PAGE = "services/illuminator.html"
HEARTBEAT_PAGE = "services/heartbeat.html"

group("HB", "Discovery and heartbeat")


def beats(bench: Bench) -> list[Heard]:
    found = [h for h in bench.observation() if h.message.get_type() == "HEARTBEAT"]
    expect(bool(found), f"no HEARTBEAT within {OBSERVATION_US / 1e6:g} s")
    return found


@requirement("HB-1", Level.MUST, "sends heartbeats all the time", CONNECTION, ILLUMINATOR_PAGE)
def constant_flow(bench: Bench) -> None:
    """A component is there as long as its heartbeats come; other systems count it as lost after
    four or five that are missing. Listens for 6 s: no gap of more than 2.5 s."""
    times = [h.time_us for h in beats(bench)]
    start = bench.observation()[0].time_us
    gaps = [b - a for a, b in zip([start, *times], [*times, start + OBSERVATION_US], strict=False)]
    longest = max(gaps[:-1] + [gaps[-1] - 10_000])
    expect(longest <= 2_500_000, f"a gap of {longest / 1e6:.1f} s between heartbeats")


@requirement("HB-2", Level.SHOULD, "sends a heartbeat a second", CONNECTION, ILLUMINATOR_PAGE)
def once_a_second(bench: Bench) -> None:
    """Nominally 1 Hz. Listens for 6 s: 5 to 7 of them."""
    count = len(beats(bench))
    expect(5 <= count <= 7, f"{count} heartbeats in {OBSERVATION_US / 1e6:g} s")


@requirement(
    "HB-3",
    Level.MUST,
    "says that it is an illuminator",
    "Illuminator Protocol: identified via MAV_TYPE_ILLUMINATOR",
    ILLUMINATOR_PAGE,
)
def type_is_illuminator(bench: Bench) -> None:
    """HEARTBEAT.type is how lights are found: 44. The component id says nothing about the type."""
    kind = beats(bench)[0].message.type
    expect(kind == TYPE_ILLUMINATOR, f"type {kind}, expected 44 (MAV_TYPE_ILLUMINATOR)")


@requirement(
    "HB-4",
    Level.SHOULD,
    "says that it is no autopilot",
    "Heartbeat, Component Identity",
    HEARTBEAT_PAGE,
)
def no_autopilot(bench: Bench) -> None:
    """HEARTBEAT.autopilot is MAV_AUTOPILOT_INVALID (8): who has another one is taken for a
    vehicle."""
    autopilot = beats(bench)[0].message.autopilot
    expect(autopilot == 8, f"autopilot {autopilot}, expected 8 (MAV_AUTOPILOT_INVALID)")


@requirement(
    "HB-5",
    Level.SHOULD,
    "has an illuminator's component id by default",
    CONNECTION,
    ILLUMINATOR_PAGE,
)
def component_id(bench: Bench) -> None:
    """MAV_COMP_ID_ILLUMINATOR, 243. Any other is allowed."""
    component = bench.target.component
    expect(component == 243, f"component {component}, by default 243")


@requirement("HB-6", Level.MUST, "has ids from 1 to 255", "Routing, Overview", "guide/routing.html")
def ids(bench: Bench) -> None:
    """Zero as a target means everybody, so nobody can be called 0."""
    target = bench.target
    expect(
        min(target.system, target.component) >= 1,
        f"it calls itself {target.system}/{target.component}",
    )


@requirement(
    "HB-7", Level.MUST, "says version 3", "HEARTBEAT.mavlink_version", COMMON + "HEARTBEAT"
)
def minor_version(bench: Bench) -> None:
    """The version of the definitions, which the library fills in: 3 for common.xml."""
    version = beats(bench)[0].message.mavlink_version
    expect(version == 3, f"mavlink_version {version}, expected 3")


@requirement("HB-8", Level.SHOULD, "says in which state it is", "MAV_STATE", COMMON + "MAV_STATE")
def state(bench: Bench) -> None:
    """HEARTBEAT.system_status is other than MAV_STATE_UNINIT (0, "state is unknown"), and
    defined."""
    state = beats(bench)[-1].message.system_status
    expect(1 <= state <= 8, f"system_status {state}")


@requirement(
    "HB-9",
    Level.MUST,
    "has a heartbeat of one identity",
    "Heartbeat, Component Identity",
    HEARTBEAT_PAGE,
)
def one_identity(bench: Bench) -> None:
    """Type and autopilot stay the same from heartbeat to heartbeat."""
    kinds = {(h.message.type, h.message.autopilot) for h in beats(bench)}
    if len(beats(bench)) < 2:
        raise NotOffered("only one heartbeat came")
    expect(len(kinds) == 1, f"type and autopilot change: {sorted(kinds)}")
