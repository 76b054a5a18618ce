# SPDX-License-Identifier: Apache-2.0
"""The gimbal device that a light may be as well. Nothing is moved."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

from ..connection import Target
from ..light import COMMAND_REQUEST_MESSAGE
from .bench import Bench
from .spec import COMMON, Level, NotOffered, expect, group, requirement

TYPE_GIMBAL = 26
GIMBAL_HEARTBEAT_US = 2_500_000
PAGE = "services/gimbal_v2.html"
DEVICE = "Gimbal Protocol v2, Gimbal Device"

group("GB", "Gimbal device")


def _gimbals(bench: Bench) -> set[int]:
    """Components of its system that have said so."""
    return {
        m.get_srcComponent()
        for m in bench.connection.history
        if m.get_type() == "HEARTBEAT"
        and m.type == TYPE_GIMBAL
        and m.get_srcSystem() == bench.target.system
    }


@contextmanager
def gimbal(bench: Bench) -> Iterator[Bench]:
    """The bench talks to the gimbal of the light's system meanwhile."""
    found = _gimbals(bench)
    if not found:
        bench.listen(GIMBAL_HEARTBEAT_US)
    if not (found := _gimbals(bench)):
        raise NotOffered("no gimbal device was heard in its system")
    light = bench.connection.target
    bench.connection.target = Target(light.system, min(found))
    try:
        yield bench
    finally:
        bench.connection.target = light


@requirement("GB-1", Level.MUST, "tells on request what it is", f"{DEVICE}: discovery", PAGE)
def information(bench: Bench) -> None:
    """MAV_CMD_REQUEST_MESSAGE(283): ACCEPTED, and GIMBAL_DEVICE_INFORMATION comes."""
    with gimbal(bench):
        bench.request(283, "GIMBAL_DEVICE_INFORMATION")


@requirement("GB-2", Level.MUST, "has limits in order, in radians", "GIMBAL_DEVICE_INFORMATION",
             COMMON + "GIMBAL_DEVICE_INFORMATION")  # fmt: skip
def limits(bench: Bench) -> None:
    """Of roll, pitch and yaw: the lowest angle is not above the highest; both within ±2π,
    infinite, or NaN where unknown."""
    with gimbal(bench):
        message = bench.request(283, "GIMBAL_DEVICE_INFORMATION")
    for axis in ("roll", "pitch", "yaw"):
        low, high = getattr(message, f"{axis}_min"), getattr(message, f"{axis}_max")
        expect(not low > high, f"{axis} from {low:g} to {high:g}")
        for value in (low, high):
            expect(
                not math.isfinite(value) or abs(value) <= 2 * math.pi + 0.01,
                f"{axis} {value:g} rad: are these degrees?",
            )


@requirement("GB-3", Level.MUST, "streams its attitude", f"{DEVICE}: at a regular rate", PAGE)
def streams(bench: Bench) -> None:
    """GIMBAL_DEVICE_ATTITUDE_STATUS at least once a second: an autopilot takes an older one for a
    gimbal that is gone."""
    with gimbal(bench):
        count = len(attitudes(bench, 3_000_000))
    expect(count >= 3, f"{count} in 3 s")


def attitudes(bench: Bench, us: int) -> list[object]:
    came = [h.message for h in bench.listen(us)]
    return [m for m in came if m.get_type() == "GIMBAL_DEVICE_ATTITUDE_STATUS"]


@requirement("GB-4", Level.MUST, "sends quaternions of length 1", "GIMBAL_DEVICE_ATTITUDE_STATUS.q",
             COMMON + "GIMBAL_DEVICE_ATTITUDE_STATUS")  # fmt: skip
def quaternion(bench: Bench) -> None:
    """w, x, y, z of an attitude: the sum of their squares is 1."""
    with gimbal(bench):
        came = attitudes(bench, 2_000_000)
    if not came:
        raise NotOffered("no GIMBAL_DEVICE_ATTITUDE_STATUS came")
    for message in came:
        q = message.q  # type: ignore[attr-defined]
        length = math.sqrt(sum(value * value for value in q))
        expect(abs(length - 1) <= 0.01, f"length {length:g}: {list(q)}")


@requirement("GB-5", Level.MUST, "answers commands under its own id", "Command Protocol",
             "services/command.html")  # fmt: skip
def answers(bench: Bench) -> None:
    """A request for a message that no gimbal has (24), addressed to it: one refusal, from its own
    component id."""
    with gimbal(bench):
        bench.refused(COMMAND_REQUEST_MESSAGE, 24)
