# SPDX-License-Identifier: Apache-2.0
"""The wire: versions, truncation, checksums, flags, garbage, pieces."""

from __future__ import annotations

from collections.abc import Callable

from ..light import ACCEPTED, COMMAND_ON_OFF, COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS
from .bench import (
    ANSWER_US,
    Bench,
    repacked,
    result_name,
    unpacked,
)
from .commands import acks
from .information import STATUS
from .spec import Level, NotOffered, expect, group, requirement

SERIALIZATION = "guide/serialization.html"
VERSIONS = "guide/mavlink_version.html"
START_1, START_2 = 0xFE, 0xFD
AT_INCOMPATIBLE, AT_COMPATIBLE = 2, 3
# No incompatibility flag but 1 (signed) is defined, and no compatibility flag.
UNKNOWN_FLAG = 0x40
# Two false starts of the longest frame, whatever version, and noise. Fixed, so a run is repeated.
GARBAGE = bytes([START_2, 255, 0, 0, 7, 1, 1, 9, 9, 9]) + bytes(
    (n * 73 + 41) % 251 for n in range(90)
)

group("WR", "The wire")


def frames(bench: Bench) -> list[bytes]:
    return [bytes(h.message.get_msgbuf()) for h in bench.observation()]


def on(bench: Bench) -> tuple[bytes, int]:
    """A frame that says "on", and its CRC_EXTRA."""
    message = bench.command_message(COMMAND_ON_OFF, 1)
    return bench.frame(message), int(message.crc_extra)


@requirement(
    "WR-1", Level.MUST, "speaks MAVLink 2 to who does", "MAVLink Versions, Negotiating", VERSIONS
)
def version_2(bench: Bench) -> None:
    """Once it has heard MAVLink 2 on a link it sends that: its status exists only there (id
    440)."""
    answer = bench.command(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    start = bytes(answer.get_msgbuf())[0]
    expect(start == START_2, f"COMMAND_ACK came in a frame that starts with {start:#x}")


@requirement(
    "WR-2",
    Level.SHOULD,
    "understands MAVLink 1",
    "MAVLink Versions: backwards compatible",
    VERSIONS,
)
def version_1(bench: Bench) -> None:
    """A request for its status in MAVLink 1 is acknowledged, in either version."""
    answer = bench.command(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS, version=1)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    expect(answer.result == ACCEPTED, result_name(answer))


@requirement(
    "WR-3",
    Level.SHOULD,
    "sends what only MAVLink 2 carries in MAVLink 2",
    "MAVLink Versions, Version Handshaking",
    VERSIONS,
)
def handshake(bench: Bench) -> None:
    """A request in MAVLink 1 for ILLUMINATOR_STATUS, whose id is above 255: ACCEPTED, and the
    message in a MAVLink 2 frame; a refusal would say that the light has no MAVLink 2."""
    bench.listen(0)
    message = bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS)
    bench.send(message, version=1)
    came = bench.listen(2 * ANSWER_US, lambda m: m.get_type() == STATUS)
    expect(any(h.message.get_type() == STATUS for h in came), f"no {STATUS} within 2 s")


@requirement(
    "WR-4",
    Level.MUST,
    "cuts zeros off the end of its payloads",
    "Serialization, Empty-Byte Payload Truncation",
    SERIALIZATION,
)
def truncates(bench: Bench) -> None:
    """In MAVLink 2 no payload of more than one byte ends with a zero, that of
    COMPONENT_INFORMATION_BASIC, which most lights end with zeros, among them."""
    bench.listen(0)
    bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, 396))
    answers = [bytes(h.message.get_msgbuf()) for h in bench.listen(ANSWER_US)]
    for frame in frames(bench) + answers:
        payload = unpacked(frame)
        expect(
            frame[0] != START_2 or len(payload) == 1 or payload[-1:] != b"\0",
            f"a payload of {len(payload)} bytes ends with a zero: {frame.hex()}",
        )


@requirement(
    "WR-5",
    Level.MUST,
    "takes payloads whether cut or not",
    "Serialization, Empty-Byte Payload Truncation",
    SERIALIZATION,
)
def takes_both(bench: Bench) -> None:
    """'On' and 'off', their zeros cut off (as libraries send them) and not: all are carried out."""
    bench.dim()
    for whole in (False, True):
        for value in (1, 0):
            message = bench.command_message(COMMAND_ON_OFF, value)
            frame = bench.frame(message)
            if whole:
                payload = unpacked(frame).ljust(33, b"\0")
                frame = bench.sealed(repacked(frame, payload), int(message.crc_extra))
            bench.listen(0)
            bench.send_raw(frame, f"COMMAND_LONG 405 ({value}) in {frame[1]} bytes")
            answer = bench.acknowledgement(COMMAND_ON_OFF)
            expect(answer is not None, f"no COMMAND_ACK to a payload of {frame[1]} bytes")


@requirement(
    "WR-6", Level.MUST, "counts its frames", "Serialization: packet sequence number", SERIALIZATION
)
def sequence(bench: Bench) -> None:
    """The sequence number goes up by one with each message of the component; a number that is
    lost on the way is no fault, one that comes twice in a row is."""
    numbers = [h.message.get_seq() for h in bench.observation()]
    if len(numbers) < 3:
        raise NotOffered("too few messages came unasked")
    twice = sum(a == b for a, b in zip(numbers, numbers[1:], strict=False))
    expect(twice == 0, f"the same number twice in a row, {twice} times: {numbers[:12]}")
    back = sum((b - a) % 256 > 128 for a, b in zip(numbers, numbers[1:], strict=False))
    expect(back == 0, f"it goes back, {back} times: {numbers[:12]}")


@requirement(
    "WR-7",
    Level.MUST,
    "sends frames with the right checksum",
    "Serialization, Checksum",
    SERIALIZATION,
)
def right_checksums(bench: Bench) -> None:
    """Nothing of what came since the beginning was malformed, status and information among it."""
    bench.observation()
    for number in (MESSAGE_STATUS, 396):
        bench.command(COMMAND_REQUEST_MESSAGE, number)
        bench.listen(200_000)
    bad = [m for m in bench.connection.malformed if "CRC" in str(m.reason)]
    expect(not bad, f"{len(bad)} frames, the first: {bad[0].reason if bad else ''}")


@requirement(
    "WR-8",
    Level.MUST,
    "drops frames with a wrong checksum",
    "Serialization, Checksum",
    SERIALIZATION,
)
def wrong_checksum(bench: Bench) -> None:
    """'On', with one bit of its checksum changed: no answer, and it stays off."""
    frame, crc_extra = on(bench)
    _dropped(bench, lambda: bench.sealed(frame, crc_extra, wrong=1), "with a wrong checksum")


@requirement(
    "WR-9",
    Level.MUST,
    "drops frames with flags that it does not know",
    "Serialization, Incompatibility Flags: must discard",
    SERIALIZATION,
)
def incompatible(bench: Bench) -> None:
    """'On', with incompatibility flag 0x40 and a right checksum: no answer, and it stays off."""
    frame, crc_extra = on(bench)
    changed = bytearray(frame)
    changed[AT_INCOMPATIBLE] |= UNKNOWN_FLAG
    made = bytes(changed)
    _dropped(bench, lambda: bench.sealed(made, crc_extra), "with incompatibility flag 0x40")


def _dropped(bench: Bench, make: Callable[[], bytes], what: str) -> None:
    bench.dim()
    bench.listen(0)
    bench.send_raw(make(), f"COMMAND_LONG 405 (1) {what}")
    answers = acks(bench, COMMAND_ON_OFF, ANSWER_US)
    bench.alive(f"after a frame {what}")
    enable = bench.status().enable
    bench.switch(0)
    expect(not answers, f"it answered a frame {what}")
    expect(enable == 0, f"it carried out a frame {what}")


@requirement(
    "WR-10",
    Level.MUST,
    "takes frames with compatibility flags that it does not know",
    "Serialization, Compatibility Flags",
    SERIALIZATION,
)
def compatible(bench: Bench) -> None:
    """A request with compatibility flag 0x40: such a frame can still be handled, so ACCEPTED."""
    message = bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS)
    changed = bytearray(bench.frame(message))
    changed[AT_COMPATIBLE] |= UNKNOWN_FLAG
    bench.listen(0)
    frame = bench.sealed(bytes(changed), int(message.crc_extra))
    bench.send_raw(frame, "COMMAND_LONG 512 (440) with compatibility flag 0x40")
    answer = bench.acknowledgement(COMMAND_REQUEST_MESSAGE)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    expect(answer.result == ACCEPTED, result_name(answer))


@requirement(
    "WR-11",
    Level.MUST,
    "goes on after garbage",
    "Serialization: packets start with a marker and end with a checksum",
    SERIALIZATION,
)
def garbage(bench: Bench) -> None:
    """100 bytes of noise that begin like the longest of frames, then ten requests: one is answered,
    though the noise may have taken the first of them with it."""
    bench.send_raw(GARBAGE, f"{len(GARBAGE)} bytes of garbage")
    bench.alive("after garbage")


@requirement("WR-12", Level.MUST, "goes on after half a frame", "Serialization", SERIALIZATION)
def half_frame(bench: Bench) -> None:
    """The first half of 'on' three times, then commands: one of the next ten is answered, and
    the light is off."""
    bench.dim()
    frame, _ = on(bench)
    for _ in range(3):
        bench.send_raw(frame[: len(frame) // 2], "the first half of a frame")
    bench.alive("after half a frame")
    expect(bench.status().enable == 0, "half a command was carried out")


@requirement(
    "WR-13",
    Level.MUST,
    "puts a frame together from pieces",
    "Serialization: a stream of bytes",
    SERIALIZATION,
)
def pieces(bench: Bench) -> None:
    """On a stream (serial line, TCP, tunnel) a request comes byte by byte: ACCEPTED."""
    if bench.connection.link.is_datagram:
        raise NotOffered("each datagram of UDP is whole frames")
    message = bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS)
    frame = bench.frame(message)
    bench.listen(0)
    bench.note(f"→ COMMAND_LONG 512 (440) in {len(frame)} pieces")
    for at in range(len(frame)):
        bench.connection.link.send(frame[at : at + 1])
        bench.connection.pacer.pump(0)
    answer = bench.acknowledgement(COMMAND_REQUEST_MESSAGE)
    expect(answer is not None, "no COMMAND_ACK within 1 s")
    expect(answer.result == ACCEPTED, result_name(answer))


@requirement("WR-14", Level.MUST, "takes several frames at once", "Serialization", SERIALIZATION)
def together(bench: Bench) -> None:
    """'On' and 'off' written at once, in one datagram on UDP: both are acknowledged, and the
    light is off."""
    bench.dim()
    bench.listen(0)
    parts = [bench.frame(bench.command_message(COMMAND_ON_OFF, value)) for value in (1, 0)]
    bench.send_raw(b"".join(parts), "COMMAND_LONG 405 (1) and (0) at once")
    answers = acks(bench, COMMAND_ON_OFF, ANSWER_US)
    expect(answers.count(ACCEPTED) >= 2, f"{len(answers)} acknowledgements")
    expect(bench.status().enable == 0, "the second one was not carried out")


@requirement(
    "WR-15",
    Level.MUST,
    "goes on after messages that it does not know",
    "Routing: messages that are not supported",
    "guide/routing.html",
)
def unknown_message(bench: Bench) -> None:
    """A frame with message id 0x7F1234, and known messages that are not for lights: then a
    request is answered."""
    frame = bytes([START_2, 3, 0, 0, 9, 255, 190, 0x34, 0x12, 0x7F, 1, 2, 3, 0, 0])
    bench.send_raw(bench.sealed(frame, 0), "an unknown message, 0x7F1234")
    bench.send(bench.d.MAVLink_attitude_message(0, 0, 0, 0, 0, 0, 0))
    bench.alive("after unknown messages")


@requirement(
    "WR-16", Level.SHOULD, "finds the frames within what was none", "Serialization", SERIALIZATION
)
def rescans(bench: Bench) -> None:
    """The noise of WR-11, then ten requests: at least eight are answered. Who throws away all that
    a false beginning promised loses more."""
    bench.send_raw(GARBAGE, f"{len(GARBAGE)} bytes of garbage")
    answered = 0
    for _ in range(10):
        bench.send(bench.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS))
        answered += len(acks(bench, COMMAND_REQUEST_MESSAGE, 100_000))
    answered += len(acks(bench, COMMAND_REQUEST_MESSAGE, ANSWER_US))
    expect(answered >= 8, f"{answered} of 10 requests after the garbage were answered")
