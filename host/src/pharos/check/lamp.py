# SPDX-License-Identifier: Apache-2.0
"""MAV_CMD_ILLUMINATOR_ON_OFF (405) and MAV_CMD_DO_ILLUMINATOR_CONFIGURE (406)."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any

from ..light import ACCEPTED, COMMAND_CONFIGURE, COMMAND_ON_OFF, MODE_EXTERNAL_SYNC, MODE_INTERNAL
from .bench import DENIED, DIM, NAN, Bench, Settings, result_name, shown
from .presence import ILLUMINATOR_PAGE
from .spec import COMMON, Failed, Level, NotOffered, expect, group, requirement

ON_OFF = "MAV_CMD_ILLUMINATOR_ON_OFF"
CONFIGURE = "MAV_CMD_DO_ILLUMINATOR_CONFIGURE"
ON_OFF_PAGE = COMMON + ON_OFF
CONFIGURE_PAGE = COMMON + CONFIGURE
SWITCHING = "Illuminator Protocol, ON/OFF"
CONFIGURING = "Illuminator Protocol, CONFIGURE"

group("SW", "MAV_CMD_ILLUMINATOR_ON_OFF")
group("CF", "MAV_CMD_DO_ILLUMINATOR_CONFIGURE")


def f32(value: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def denied(bench: Bench, command: int, *params: float) -> None:
    answer = bench.command(command, *params)
    expect(answer is not None, f"no COMMAND_ACK to {command} {shown(params)} within 1 s")
    expect(
        answer.result == DENIED,
        f"{command} {shown(params)}: {result_name(answer)}, expected DENIED",
    )


def unchanged(bench: Bench, before: Settings, what: str) -> None:
    now = bench.settings()
    expect(now == before, f"after {what}: {now}, before it: {before}")


# --- 405 ------------------------------------------------------------------------------------------
@requirement("SW-1", Level.MUST, "is switched on", SWITCHING, ILLUMINATOR_PAGE)
def on(bench: Bench) -> None:
    """param1 1 is ACCEPTED, and the first status after it says enable 1: ACCEPTED means that it was
    executed. At 5 % brightness."""
    bench.dim()
    answer = bench.switch(1)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    if answer.result != ACCEPTED and bench.status().error_status & 2:
        raise NotOffered("the light is too hot to be switched on")
    expect(answer.result == ACCEPTED, f"on: {result_name(answer)}")
    enable = bench.status().enable
    expect(enable != 0, "ACCEPTED, but the next status says enable 0")


@requirement("SW-2", Level.MUST, "is switched off", SWITCHING, ILLUMINATOR_PAGE)
def off(bench: Bench) -> None:
    """param1 0 is ACCEPTED, and the first status after it says enable 0."""
    bench.lit()
    bench.accepted(COMMAND_ON_OFF, 0)
    enable = bench.status().enable
    expect(enable == 0, f"ACCEPTED, but the next status says enable {enable}")


@requirement(
    "SW-3", Level.MUST, "takes only 0 and 1", f"{ON_OFF}, param 1: others are invalid", ON_OFF_PAGE
)
def only_0_and_1(bench: Bench) -> None:
    """2, −1, 0.5 and NaN as param1 are DENIED, while it is off and while it is on."""
    for lit in (False, True):
        if lit:
            bench.lit()
        else:
            bench.dim()
        for value in (2.0, -1.0, 0.5, NAN):
            denied(bench, COMMAND_ON_OFF, value)


@requirement(
    "SW-4",
    Level.MUST,
    "changes nothing when it refuses to switch",
    "MAV_RESULT_DENIED",
    COMMON + "MAV_RESULT",
)
def refusal_changes_nothing(bench: Bench) -> None:
    """Whatever it answers to 2, −1 and NaN: unless that is ACCEPTED, the status is as before."""
    for lit in (False, True):
        for value in (2.0, -1.0, NAN):
            before = bench.lit() if lit else bench.dim()
            answer = bench.switch(value)
            if answer is not None and answer.result != ACCEPTED:
                unchanged(bench, before, f"on/off {value:g} was refused")


@requirement(
    "SW-5",
    Level.MUST,
    "stays on when it is switched on again",
    "Command Protocol: re-sent when unacknowledged",
    "services/command.html",
)
def idempotent(bench: Bench) -> None:
    """A command whose acknowledgement was lost is sent again. On, on: ACCEPTED twice, enable 1.
    Off, off: the same with 0."""
    for value in (1, 0):
        bench.lit()
        for _ in range(2):
            bench.accepted(COMMAND_ON_OFF, value)
            enable = bench.status().enable
            expect(bool(enable) == bool(value), f"{value} sent again: enable {enable}")


@requirement(
    "SW-6", Level.MUST, "keeps its settings when it is switched", SWITCHING, ILLUMINATOR_PAGE
)
def keeps_settings(bench: Bench) -> None:
    """Switching enables and disables. Mode, brightness and strobe are the same before and after."""
    before = bench.dim()
    bench.switch(1)
    bench.switch(0)
    unchanged(bench, before, "on and off")


@requirement(
    "SW-7",
    Level.SHOULD,
    "does not mind unused parameters",
    "Defining XML: reserved parameters, 0 or NaN",
    "guide/define_xml_element.html",
)
def unused(bench: Bench) -> None:
    """params 2 to 7 NaN, which many clients send for what they do not use: ACCEPTED."""
    bench.dim()
    bench.accepted(COMMAND_ON_OFF, 0, *[NAN] * 6)


# --- 406 ------------------------------------------------------------------------------------------
def modes(bench: Bench) -> list[int]:
    bitmask = bench.known_status().mode_bitmask
    return [mode for mode in (MODE_INTERNAL, MODE_EXTERNAL_SYNC) if bitmask & mode]


def tried(bench: Bench, params: Sequence[float]) -> Any:
    answer = bench.command(COMMAND_CONFIGURE, *params)
    expect(answer is not None, f"no COMMAND_ACK to 406 {shown(params)} within 1 s")
    return answer


def taken(bench: Bench, *params: float) -> Settings:
    """Configures; the status then, which must have been ACCEPTED."""
    answer = tried(bench, params)
    expect(answer.result == ACCEPTED, f"406 {shown(params)}: {result_name(answer)}")
    return bench.settings()


def near(reported: float, wanted: float) -> bool:
    return math.isclose(reported, wanted, rel_tol=0.01, abs_tol=0.01)


@requirement("CF-1", Level.MUST, "takes each mode that it says it has", CONFIGURING, CONFIGURE_PAGE)
def each_mode(bench: Bench) -> None:
    """Each bit of mode_bitmask as param1: ACCEPTED, and the next status has that mode."""
    bench.dim()
    for mode in modes(bench):
        now = taken(bench, mode, DIM, 0, 0)
        expect(now.mode == mode, f"mode {mode} set, the next status says {now.mode}")


@requirement("CF-2", Level.MUST, "refuses what is no mode", f"{CONFIGURE}, param 1", CONFIGURE_PAGE)
def no_mode(bench: Bench) -> None:
    """3, 255, −1, 1.5, and what mode_bitmask lacks: DENIED."""
    bench.dim()
    lacking = [mode for mode in (1, 2) if mode not in modes(bench)]
    for mode in [3.0, 255.0, -1.0, 1.5, *lacking]:
        denied(bench, COMMAND_CONFIGURE, mode, DIM, 0, 0)


@requirement(
    "CF-3", Level.SHOULD, "refuses the unknown mode", f"{CONFIGURE}, param 1", CONFIGURE_PAGE
)
def unknown_mode(bench: Bench) -> None:
    """ILLUMINATOR_MODE_UNKNOWN (0) is something to report, nothing to be put into."""
    bench.dim()
    denied(bench, COMMAND_CONFIGURE, 0, DIM, 0, 0)


@requirement(
    "CF-4",
    Level.MUST,
    "takes a brightness from 0 to 100 %",
    f"{CONFIGURE}, param 2",
    CONFIGURE_PAGE,
)
def brightness(bench: Bench) -> None:
    """0, 1, 37.5 and 100, while it is off: ACCEPTED, and reported to within 1 %."""
    bench.dim()
    for value in (0.0, 1.0, 37.5, 100.0):
        now = taken(bench, MODE_INTERNAL, value, 0, 0)
        expect(abs(now.brightness - value) <= 1, f"{value:g} % set, reported {now.brightness:g}")


@requirement(
    "CF-5",
    Level.MUST,
    "refuses a brightness outside 0 to 100 %",
    f"{CONFIGURE}, param 2: minValue, maxValue",
    CONFIGURE_PAGE,
)
def no_brightness(bench: Bench) -> None:
    """−0.1, 100.1, 1000: DENIED."""
    bench.dim()
    for value in (-0.1, 100.1, 1000.0):
        denied(bench, COMMAND_CONFIGURE, MODE_INTERNAL, value, 0, 0)


@requirement(
    "CF-6", Level.MUST, "takes periods from the shortest to the longest, and 0",
    f"{CONFIGURE}, param 3", CONFIGURE_PAGE,
)  # fmt: skip
def period(bench: Bench) -> None:
    """0 (no strobe), and both ends and the middle of what the status reports, at a duty cycle of
    50 %: ACCEPTED, and reported to within 1 %."""
    bench.dim()
    low, high = bench.periods()
    for value in (0.0, low, (low + high) / 2, high):
        now = taken(bench, MODE_INTERNAL, DIM, value, 50)
        expect(near(now.strobe_period, value), f"{value:g} s set, reported {now.strobe_period:g} s")


@requirement(
    "CF-7", Level.MUST, "refuses a period that it cannot keep",
    f"{CONFIGURE}, param 3; {'ILLUMINATOR_STATUS'}.min/max_strobe_period", CONFIGURE_PAGE,
)  # fmt: skip
def no_period(bench: Bench) -> None:
    """−1 s, half of the shortest, 1.5 times the longest: DENIED."""
    bench.dim()
    low, high = bench.periods()
    for value in [-1.0, 1.5 * high] + ([low / 2] if low > 0 else []):
        denied(bench, COMMAND_CONFIGURE, MODE_INTERNAL, DIM, value, 50)


@requirement(
    "CF-8",
    Level.MUST,
    "takes a duty cycle from 0 to 100 %",
    f"{CONFIGURE}, param 4",
    CONFIGURE_PAGE,
)
def duty(bench: Bench) -> None:
    """0, 25 and 100 at a period that it can keep: ACCEPTED, and reported to within 1 %."""
    bench.dim()
    low, high = bench.periods()
    period = min(max(low, 1.0), high)
    for value in (0.0, 25.0, 100.0):
        now = taken(bench, MODE_INTERNAL, DIM, period, value)
        expect(
            abs(now.strobe_duty_cycle - value) <= 1,
            f"{value:g} % set, reported {now.strobe_duty_cycle:g}",
        )


@requirement(
    "CF-9",
    Level.MUST,
    "refuses a duty cycle outside 0 to 100 %",
    f"{CONFIGURE}, param 4: minValue, maxValue",
    CONFIGURE_PAGE,
)
def no_duty(bench: Bench) -> None:
    """−0.1, 100.1, 1000: DENIED."""
    bench.dim()
    low, high = bench.periods()
    for value in (-0.1, 100.1, 1000.0):
        denied(bench, COMMAND_CONFIGURE, MODE_INTERNAL, DIM, min(max(low, 1.0), high), value)


@requirement(
    "CF-10",
    Level.MUST,
    "takes over no NaN",
    f"{CONFIGURE}, params 2 to 4: minValue, maxValue",
    CONFIGURE_PAGE,
)
def no_nan(bench: Bench) -> None:
    """NaN lies in no range. Each of the four: DENIED, or at least the status has the value from
    before."""
    before = bench.dim()
    low, high = bench.periods()
    for at in range(4):
        params = [float(MODE_INTERNAL), 50.0, min(max(low, 1.0), high), 50.0]
        params[at] = NAN
        tried(bench, params)
        now = bench.settings()
        old = (before.mode, before.brightness, before.strobe_period, before.strobe_duty_cycle)[at]
        new = (now.mode, now.brightness, now.strobe_period, now.strobe_duty_cycle)[at]
        expect(new == old, f"406 {shown(params)}: the status has {new:g}, before it {old:g}")
        bench.dim()


@requirement("CF-11", Level.SHOULD, "refuses NaN", "MAV_RESULT_DENIED", COMMON + "MAV_RESULT")
def nan_denied(bench: Bench) -> None:
    """common.xml gives NaN no meaning here, so it is an invalid value: DENIED."""
    bench.dim()
    for at in range(4):
        params = [float(MODE_INTERNAL), DIM, 0.0, 0.0]
        params[at] = NAN
        denied(bench, COMMAND_CONFIGURE, *params)


@requirement(
    "CF-12",
    Level.MUST,
    "changes nothing when it refuses settings",
    "MAV_RESULT_DENIED",
    COMMON + "MAV_RESULT",
)
def whole_or_nothing(bench: Bench) -> None:
    """Each value out of range, the others in range and new: if it is refused, the status is as
    before in all of them."""
    before = bench.dim()
    low, high = bench.periods()
    good = [float(MODE_INTERNAL), 50.0, min(max(low, 1.0), high), 50.0]
    for at, bad in enumerate((77.0, 150.0, -5.0, 150.0)):
        params = [*good[:at], bad, *good[at + 1 :]]
        if tried(bench, params).result != ACCEPTED:
            unchanged(bench, before, f"406 {shown(params)} was refused")
        else:
            bench.dim()


@requirement("CF-13", Level.MUST, "is not switched by settings", CONFIGURING, ILLUMINATOR_PAGE)
def does_not_switch(bench: Bench) -> None:
    """They adjust how the light behaves when it is enabled: while off it stays off, while on,
    on."""
    for lit in (False, True):
        before = bench.lit() if lit else bench.dim()
        now = taken(bench, MODE_INTERNAL, 4, 0, 0)
        expect(
            bool(now.enable) == bool(before.enable),
            f"configured while {'on' if before.enable else 'off'}: enable {now.enable}",
        )


@requirement("CF-14", Level.MUST, "keeps settings for when it is on", CONFIGURING, ILLUMINATOR_PAGE)
def settings_wait(bench: Bench) -> None:
    """Configured while off, then switched on: the status has these settings."""
    bench.dim()
    low, high = bench.periods()
    wanted = min(max(low, 1.0), high)
    taken(bench, MODE_INTERNAL, 3, wanted, 20)
    bench.switch(1)
    now = bench.settings()
    bench.switch(0)
    seen = (now.brightness, now.strobe_period, now.strobe_duty_cycle)
    kept = all(near(value, want) for value, want in zip(seen, (3, wanted, 20), strict=True))
    expect(kept, f"3 %, {wanted:g} s, 20 % were set; on, it reports {now}")


@requirement(
    "CF-15",
    Level.MUST,
    "takes the same settings again",
    "Command Protocol: re-sent when unacknowledged",
    "services/command.html",
)
def again(bench: Bench) -> None:
    """Twice the same, while on: ACCEPTED twice, and the status stays."""
    bench.lit()
    first = taken(bench, MODE_INTERNAL, 4, 0, 0)
    second = taken(bench, MODE_INTERNAL, 4, 0, 0)
    expect(first == second, f"once: {first}; again: {second}")


@requirement(
    "CF-16",
    Level.SHOULD,
    "reports settings exactly as they were set",
    CONFIGURING,
    ILLUMINATOR_PAGE,
)
def exact(bench: Bench) -> None:
    """A client compares what it sent with what comes back: the same 32-bit floats."""
    bench.dim()
    low, high = bench.periods()
    wanted = min(max(low, 0.7654321), high)
    now = taken(bench, MODE_INTERNAL, 33.3, wanted, 12.3456)
    sent = (f32(33.3), f32(wanted), f32(12.3456))
    seen = (now.brightness, now.strobe_period, now.strobe_duty_cycle)
    expect(seen == sent, f"set {shown(sent)}, reported {shown(seen)}")


@requirement(
    "CF-17",
    Level.SHOULD,
    "does not mind unused parameters",
    "Defining XML: reserved parameters, 0 or NaN",
    "guide/define_xml_element.html",
)
def configure_unused(bench: Bench) -> None:
    """params 5 to 7 NaN: ACCEPTED."""
    bench.dim()
    params = (MODE_INTERNAL, DIM, 0, 0, NAN, NAN, NAN)
    answer = tried(bench, params)
    if answer.result != ACCEPTED:
        raise Failed(f"406 {shown(params)}: {result_name(answer)}")
