# SPDX-License-Identifier: Apache-2.0
"""COMPONENT_INFORMATION_BASIC (396) and ILLUMINATOR_STATUS (440)."""

from __future__ import annotations

import math
import re
from typing import Any

from ..light import COMMAND_REQUEST_MESSAGE, MESSAGE_INFORMATION, MESSAGE_STATUS
from .bench import DIM, OBSERVATION_US, Bench, unpacked
from .presence import ILLUMINATOR_PAGE
from .spec import COMMON, Level, NotOffered, expect, group, requirement

INFORMATION = "COMPONENT_INFORMATION_BASIC"
STATUS = "ILLUMINATOR_STATUS"
# Offsets and lengths in the payload as it is sent.
TEXTS = {
    "vendor_name": (16, 32),
    "model_name": (48, 32),
    "software_version": (80, 24),
    "hardware_version": (104, 24),
    "serial_number": (128, 32),
}
WAIT_US = 1_500_000
PROMPT_US = 400_000
# How far two clocks may disagree over WAIT_US, with an answer's way on top [ms].
CLOCK_MS = 250
SEMVER = re.compile(r"\d+\.\d+\.\d+([-+.][0-9A-Za-z.+-]+)?")

group("INF", "COMPONENT_INFORMATION_BASIC")
group("ST", "ILLUMINATOR_STATUS")


def information(bench: Bench) -> Any:
    return bench.request(MESSAGE_INFORMATION, INFORMATION)


def elapses(bench: Bench, number: int, kind: str, field: str) -> None:
    """A time in ms that runs with the host's."""
    first, start = getattr(bench.request(number, kind), field), bench.now()
    bench.listen(WAIT_US)
    second, end = getattr(bench.request(number, kind), field), bench.now()
    passed = (end - start) / 1000
    expect(
        abs(second - first - passed) <= CLOCK_MS,
        f"{field} went from {first} to {second} while {passed:.0f} ms passed",
    )


# --- 396 ------------------------------------------------------------------------------------------
@requirement(
    "INF-1",
    Level.MUST,
    "tells on request who made it",
    "Illuminator Protocol, COMPONENT_INFORMATION_BASIC",
    ILLUMINATOR_PAGE,
)
def is_sent(bench: Bench) -> None:
    """MAV_CMD_REQUEST_MESSAGE(396) is ACCEPTED, and the message comes."""
    information(bench)


@requirement(
    "INF-2",
    Level.MUST,
    "ends each of its texts with a zero",
    "COMPONENT_INFORMATION_BASIC: needs to be zero terminated",
    COMMON + "COMPONENT_INFORMATION_BASIC",
)
def texts_end(bench: Bench) -> None:
    """A text that fills its field has lost its end, and a reader in C goes on into the next one."""
    message = information(bench)
    payload = unpacked(bytes(message.get_msgbuf())).ljust(160, b"\0")
    for name, (at, size) in TEXTS.items():
        text = payload[at : at + size]
        expect(b"\0" in text, f"{name} has no zero in its {size} bytes: {text!r}")
        expect(
            not text.partition(b"\0")[2].strip(b"\0"), f"{name} goes on after its zero: {text!r}"
        )


@requirement(
    "INF-3",
    Level.MUST,
    "tells since when it runs",
    "COMPONENT_INFORMATION_BASIC.time_boot_ms",
    COMMON + "COMPONENT_INFORMATION_BASIC",
)
def boot_time(bench: Bench) -> None:
    """Two requests, 1.5 s apart: time_boot_ms has grown by as many milliseconds."""
    elapses(bench, MESSAGE_INFORMATION, INFORMATION, "time_boot_ms")


@requirement(
    "INF-4",
    Level.SHOULD,
    "numbers its software and hardware major.minor.patch",
    "COMPONENT_INFORMATION_BASIC.software_version",
    COMMON + "COMPONENT_INFORMATION_BASIC",
)
def versions(bench: Bench) -> None:
    """The recommended format; an empty text is allowed."""
    message = information(bench)
    for name in ("software_version", "hardware_version"):
        text = str(getattr(message, name)).rstrip("\0")
        expect(not text or bool(SEMVER.fullmatch(text)), f"{name} is '{text}'")


@requirement(
    "INF-5",
    Level.SHOULD,
    "says which protocols it has",
    "Heartbeat, Component Capabilities",
    "services/heartbeat.html",
)
def capabilities(bench: Bench) -> None:
    """MAV_PROTOCOL_CAPABILITY_MAVLINK2 (8192) at least: this very message needs MAVLink 2."""
    flags = int(information(bench).capabilities)
    expect(flags & 8192 != 0, f"capabilities {flags:#x} lack MAVLINK2 (8192)")


@requirement(
    "INF-6",
    Level.MUST,
    "sends it once for each request",
    "MAV_CMD_REQUEST_MESSAGE: a single instance",
    COMMON + "MAV_CMD_REQUEST_MESSAGE",
)
def once(bench: Bench) -> None:
    """A request, then 1.5 s of listening: one message."""
    bench.listen(0)
    bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_INFORMATION))
    count = sum(h.message.get_type() == INFORMATION for h in bench.listen(WAIT_US))
    expect(count == 1, f"{count} messages came for one request")


@requirement(
    "INF-7",
    Level.SHOULD,
    "does not send it unasked",
    "COMPONENT_INFORMATION_BASIC: should be requested",
    COMMON + "COMPONENT_INFORMATION_BASIC",
)
def not_unasked(bench: Bench) -> None:
    """None came while nobody asked."""
    count = sum(h.message.get_type() == INFORMATION for h in bench.observation())
    expect(count == 0, f"{count} came unasked in {OBSERVATION_US / 1e6:g} s")


# --- 440 ------------------------------------------------------------------------------------------
def field(name: str) -> str:
    return f"{STATUS}.{name}"


PAGE = COMMON + STATUS


@requirement(
    "ST-1",
    Level.MUST,
    "tells its state on request",
    "Illuminator Protocol, STATUS",
    ILLUMINATOR_PAGE,
)
def status_is_sent(bench: Bench) -> None:
    """MAV_CMD_REQUEST_MESSAGE(440), right after a status that came unasked, so that the answer
    is not taken for the next of these: ACCEPTED, and the message comes within 0.4 s."""
    bench.wait_for(STATUS, WAIT_US)
    bench.request(MESSAGE_STATUS, STATUS)
    bench.wait_for(STATUS, WAIT_US)
    bench.listen(0)
    bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS))
    came = [h.message.get_type() for h in bench.listen(PROMPT_US)]
    expect("COMMAND_ACK" in came, "no COMMAND_ACK within 0.4 s")
    expect(STATUS in came, f"ACCEPTED, but no {STATUS} within 0.4 s")


@requirement(
    "ST-2",
    Level.SHOULD,
    "publishes its state at a regular rate",
    "Illuminator Protocol, Message Summary: recommended",
    ILLUMINATOR_PAGE,
)
def status_streams(bench: Bench) -> None:
    """Unasked. Listens for 6 s: at least two, and no two further apart than twice the mean."""
    times = [h.time_us for h in bench.observation() if h.message.get_type() == STATUS]
    expect(len(times) >= 2, f"{len(times)} came unasked in {OBSERVATION_US / 1e6:g} s")
    gaps = [b - a for a, b in zip(times, times[1:], strict=False)]
    mean = sum(gaps) / len(gaps)
    expect(
        max(gaps) <= 2 * mean + 50_000, f"gaps of {min(gaps) / 1e6:.2f} … {max(gaps) / 1e6:.2f} s"
    )


@requirement(
    "ST-3", Level.MUST, "tells in milliseconds since when it runs", field("uptime_ms"), PAGE
)
def uptime(bench: Bench) -> None:
    """Two requests, 1.5 s apart: uptime_ms has grown by as many milliseconds."""
    elapses(bench, MESSAGE_STATUS, STATUS, "uptime_ms")


@requirement("ST-4", Level.MUST, "says 0 for off and 1 for on", field("enable"), PAGE)
def enable(bench: Bench) -> None:
    """Off, then on: enable has no other values."""
    seen = [bench.dim().enable, bench.dim(True).enable]
    bench.switch(0)
    expect(set(seen) <= {0, 1}, f"enable is {' and '.join(map(str, seen))}")


@requirement("ST-5", Level.MUST, "says which modes it has", field("mode_bitmask"), PAGE)
def mode_bitmask(bench: Bench) -> None:
    """At least one of ILLUMINATOR_MODE, and none that is not defined: 1, 2, or 3 for both."""
    bitmask = bench.known_status().mode_bitmask
    expect(bitmask in (1, 2, 3), f"mode_bitmask {bitmask}")


@requirement("ST-6", Level.MUST, "is in a mode that it has", field("mode"), PAGE)
def mode(bench: Bench) -> None:
    """mode is 0 (unknown), or one of those in mode_bitmask."""
    status = bench.status()
    expect(
        status.mode in (0, 1, 2) and (status.mode == 0 or bool(status.mode & status.mode_bitmask)),
        f"mode {status.mode}, mode_bitmask {status.mode_bitmask}",
    )


@requirement(
    "ST-7",
    Level.MUST,
    "reports errors that are defined",
    "ILLUMINATOR_ERROR_FLAGS",
    COMMON + "ILLUMINATOR_ERROR_FLAGS",
)
def errors(bench: Bench) -> None:
    """error_status is a sum of 1 (throttling), 2 (over temperature) and 4 (thermistor)."""
    flags = bench.status().error_status
    expect(flags & ~7 == 0, f"error_status {flags:#x}")


@requirement(
    "ST-8",
    Level.MUST,
    "reports brightness and duty cycle in percent",
    f"{field('brightness')}, strobe_duty_cycle",
    PAGE,
)
def percent(bench: Bench) -> None:
    """Numbers from 0 to 100; after 37.5 % and 62.5 % were set, these, and no fractions of one."""
    status = bench.status()
    for name in ("brightness", "strobe_duty_cycle"):
        value = getattr(status, name)
        expect(0 <= value <= 100, f"{name} is {value:g}")
    low, high = bench.periods()
    period = min(max(low, 1.0), high)
    bench.dim()
    answer = bench.configure(37.5, period, 62.5)
    if answer is None or answer.result != 0:
        raise NotOffered("the light takes no such settings")
    now = bench.settings()
    expect(abs(now.brightness - 37.5) <= 1, f"37.5 % set, brightness is {now.brightness:g}")
    expect(
        abs(now.strobe_duty_cycle - 62.5) <= 1,
        f"62.5 % set, strobe_duty_cycle is {now.strobe_duty_cycle:g}",
    )


@requirement(
    "ST-9",
    Level.MUST,
    "reports periods in seconds, from the shortest to the longest",
    f"{field('min_strobe_period')}, max_strobe_period",
    PAGE,
)
def period_range(bench: Bench) -> None:
    """min_strobe_period and max_strobe_period are numbers, not negative, in this order; a period
    that was set is between them."""
    status = bench.status()
    low, high = status.min_strobe_period, status.max_strobe_period
    expect(
        math.isfinite(low) and math.isfinite(high) and 0 <= low <= high,
        f"periods from {low:g} to {high:g} s",
    )
    bench.dim()
    bench.configure(DIM, max(low, (low + high) / 2), 50)
    now = bench.status().strobe_period
    expect(
        now == 0 or low * 0.999 <= now <= high * 1.001,
        f"strobe_period {now:g} s outside {low:g} … {high:g} s",
    )


@requirement("ST-10", Level.MUST, "reports its temperature in °C", field("temp_c"), PAGE)
def temperature(bench: Bench) -> None:
    """A place where a light may be: −60 to 200 °C. NaN where it is not known."""
    value = bench.status().temp_c
    expect(math.isnan(value) or -60 <= value <= 200, f"temp_c is {value:g}")


@requirement(
    "ST-11",
    Level.MUST,
    "reports the same whether asked or not",
    "Illuminator Protocol, STATUS",
    ILLUMINATOR_PAGE,
)
def stream_agrees(bench: Bench) -> None:
    """The next status of the stream has the settings of the one on request."""
    asked = bench.dim()
    streamed = bench.wait_for(STATUS, 3_000_000)
    if streamed is None:
        raise NotOffered("no stream of ILLUMINATOR_STATUS")
    same = type(asked).of(streamed) == asked
    expect(same, f"asked: {asked}; streamed: {type(asked).of(streamed)}")
