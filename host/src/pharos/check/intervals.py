# SPDX-License-Identifier: Apache-2.0
"""MAV_CMD_SET_MESSAGE_INTERVAL and MESSAGE_INTERVAL, for ILLUMINATOR_STATUS."""

from __future__ import annotations

from ..light import ACCEPTED, MESSAGE_STATUS
from .bench import DENIED, UNSUPPORTED, Bench, result_name
from .commands import NO_MESSAGE
from .information import STATUS
from .spec import COMMON, Failed, Level, NotOffered, expect, group, requirement

SET_INTERVAL = 511
GET_INTERVAL = 510
MESSAGE_INTERVAL = 244
NAME = "MAV_CMD_SET_MESSAGE_INTERVAL"
PAGE = COMMON + NAME
LISTEN_US = 3_000_000

group("IV", "Message intervals")


def set_interval(bench: Bench, interval: float) -> None:
    answer = bench.command(SET_INTERVAL, MESSAGE_STATUS, interval)
    expect(answer is not None, "no COMMAND_ACK to SET_MESSAGE_INTERVAL within 1 s")
    if answer.result == UNSUPPORTED:
        raise NotOffered("the light has no SET_MESSAGE_INTERVAL")
    expect(answer.result == ACCEPTED, f"interval {interval:g} µs: {result_name(answer)}")


def count(bench: Bench, us: int = LISTEN_US) -> int:
    """How many of the stream come within `us`."""
    return sum(h.message.get_type() == STATUS for h in bench.listen(us))


def default(bench: Bench) -> None:
    bench.command(SET_INTERVAL, MESSAGE_STATUS, 0)


@requirement("IV-1", Level.SHOULD, "lets its status be asked for at a rate", NAME, PAGE)
def offered(bench: Bench) -> None:
    """SET_MESSAGE_INTERVAL(440, 0), the default rate, is ACCEPTED."""
    answer = bench.command(SET_INTERVAL, MESSAGE_STATUS, 0)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    expect(answer.result == ACCEPTED, f"{result_name(answer)}")


@requirement("IV-2", Level.MUST, "sends at the rate that it accepted", f"{NAME}, param 2", PAGE)
def rate(bench: Bench) -> None:
    """200000 µs: 3 s bring 12 to 18 of ILLUMINATOR_STATUS, or it is refused."""
    answer = bench.command(SET_INTERVAL, MESSAGE_STATUS, 200_000)
    if answer is None or answer.result != ACCEPTED:
        raise NotOffered("the light does not take this interval")
    seen = count(bench)
    default(bench)
    expect(12 <= seen <= 18, f"{seen} in 3 s, expected 15")


@requirement("IV-3", Level.MUST, "stops a stream", f"{NAME}, param 2: −1", PAGE)
def stop(bench: Bench) -> None:
    """Interval −1: 3 s bring none."""
    try:
        set_interval(bench, -1)
        bench.listen(100_000)
        seen = count(bench)
    finally:
        default(bench)
    expect(seen == 0, f"{seen} in 3 s after it was stopped")


@requirement("IV-4", Level.MUST, "goes back to its default rate", f"{NAME}, param 2: 0", PAGE)
def back(bench: Bench) -> None:
    """Interval 0 after −1: as many come as before anybody asked."""
    before = sum(h.message.get_type() == STATUS for h in bench.observation()) / 2
    set_interval(bench, -1)
    set_interval(bench, 0)
    seen = count(bench)
    expect(abs(seen - before) <= 1 + before / 5, f"{seen} in 3 s, unasked it were {before:g}")


@requirement("IV-5", Level.MUST, "refuses what is no interval", f"{NAME}, param 2: minValue", PAGE)
def no_interval(bench: Bench) -> None:
    """−2: any answer but ACCEPTED."""
    set_interval(bench, 0)
    try:
        bench.refused(SET_INTERVAL, MESSAGE_STATUS, -2)
    finally:
        default(bench)


@requirement("IV-6", Level.MUST, "refuses a rate for what it does not have", NAME, PAGE)
def no_stream(bench: Bench) -> None:
    """A second's interval for GPS_RAW_INT (24): any answer but ACCEPTED."""
    set_interval(bench, 0)
    bench.refused(SET_INTERVAL, NO_MESSAGE, 1_000_000)


@requirement(
    "IV-7",
    Level.SHOULD,
    "says DENIED of such a message",
    "MAV_RESULT_DENIED",
    COMMON + "MAV_RESULT",
)
def no_stream_denied(bench: Bench) -> None:
    """The command is known; its parameter is what is wrong."""
    set_interval(bench, 0)
    answer = bench.refused(SET_INTERVAL, NO_MESSAGE, 1_000_000)
    expect(answer.result == DENIED, f"{result_name(answer)}, expected DENIED")


@requirement(
    "IV-8",
    Level.MUST,
    "tells the interval that is in force",
    "MESSAGE_INTERVAL.interval_us",
    COMMON + "MESSAGE_INTERVAL",
)
def reported(bench: Bench) -> None:
    """If it has MESSAGE_INTERVAL (244): 500000 after that was set, −1 after −1, in µs, for 440."""
    set_interval(bench, 0)
    try:
        for interval in (500_000, -1):
            set_interval(bench, interval)
            try:
                message = bench.request(MESSAGE_INTERVAL, "MESSAGE_INTERVAL", MESSAGE_STATUS)
            except Failed as error:
                raise NotOffered(f"the light has no MESSAGE_INTERVAL: {error}") from None
            expect(message.message_id == MESSAGE_STATUS, f"it is about {message.message_id}")
            expect(
                message.interval_us == interval,
                f"interval_us {message.interval_us} after {interval} was set",
            )
    finally:
        default(bench)
