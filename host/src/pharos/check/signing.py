# SPDX-License-Identifier: Apache-2.0
"""Message signing, for a light that has a key which the check was given. No key is ever set."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..light import COMMAND_ON_OFF, COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS
from .bench import ANSWER_US, Bench
from .commands import acks
from .spec import Level, NotOffered, expect, group, requirement

PAGE = "guide/message_signing.html"
ACCEPTING = "Message Signing, Accepting Signed Packets"
SIGNED = 1
SIGNATURE = 13

group("SG", "Signing (with --key-file)")


def need_key(bench: Bench) -> None:
    if not bench.key:
        raise NotOffered("no key was given (--key-file)")


@contextmanager
def speaking(bench: Bench, key: bytes) -> Iterator[None]:
    """What is sent is signed with that key, or with none."""
    signing = bench.connection.encoder.signing
    before = (signing.secret_key, signing.sign_outgoing)
    signing.secret_key, signing.sign_outgoing = key or None, bool(key)
    try:
        yield
    finally:
        signing.secret_key, signing.sign_outgoing = before


@requirement("SG-1", Level.MUST, "signs what it sends", "Message Signing, Frame Format", PAGE)
def signs(bench: Bench) -> None:
    """Each frame has the flag, and the first 48 bits of SHA-256 over key, frame, link and
    timestamp."""
    need_key(bench)
    bench.status()
    came = [bytes(h.message.get_msgbuf()) for h in bench.listen(2_500_000)]
    expect(bool(came), "nothing came within 2.5 s")
    for frame in came:
        expect(frame[0] == 0xFD and bool(frame[2] & SIGNED), f"not signed: {frame.hex()}")
        digest = hashlib.sha256(bench.key + frame[:-6]).digest()[:6]
        expect(digest == frame[-6:], f"a wrong signature: {frame.hex()}")


@requirement("SG-2", Level.MUST, "lets its timestamps grow", "Message Signing, Timestamp", PAGE)
def timestamps(bench: Bench) -> None:
    """From frame to frame of one link id the 48-bit timestamp goes up by one at least."""
    need_key(bench)
    last: dict[int, int] = {}
    for heard in bench.listen(3_000_000):
        frame = bytes(heard.message.get_msgbuf())
        expect(bool(frame[2] & SIGNED), f"not signed: {frame.hex()}")
        link, stamp = frame[-13], int.from_bytes(frame[-12:-6], "little")
        expect(stamp > last.get(link, -1), f"timestamp {stamp} after {last.get(link)}")
        last[link] = stamp


@requirement("SG-3", Level.MUST, "obeys who has the key", ACCEPTING, PAGE)
def obeys(bench: Bench) -> None:
    """A signed request is acknowledged."""
    need_key(bench)
    answer = bench.command(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS)
    expect(answer is not None, "no COMMAND_ACK within 1 s")


def on(bench: Bench, key: bytes) -> bytes:
    """A frame that says 'on', signed with that key, or with none."""
    with speaking(bench, key):
        return bench.frame(bench.command_message(COMMAND_ON_OFF, 1))


def _ignored(bench: Bench, make: Callable[[], bytes], what: str) -> None:
    """make: the frame, made when its time has come, so that it is refused for nothing else."""
    bench.dim()
    bench.listen(0)
    bench.send_raw(make(), f"COMMAND_LONG 405 (1) {what}")
    answers = acks(bench, COMMAND_ON_OFF, ANSWER_US)
    enable = bench.status().enable
    bench.switch(0)
    expect(enable == 0, f"it carried out a command {what}")
    expect(0 not in answers, f"it accepted a command {what}")


@requirement("SG-4", Level.MUST, "does not obey who does not sign",
             "Message Signing, Accepting Unsigned Packets", PAGE)  # fmt: skip
def unsigned(bench: Bench) -> None:
    """'On' without a signature: not carried out."""
    need_key(bench)
    _ignored(bench, lambda: on(bench, b""), "without a signature")


@requirement("SG-5", Level.MUST, "does not obey who has another key", ACCEPTING, PAGE)
def other_key(bench: Bench) -> None:
    """'On', signed with another key: not carried out."""
    need_key(bench)
    other = bytes(byte ^ 0xFF for byte in bench.key)
    _ignored(bench, lambda: on(bench, other), "signed with another key")


@requirement("SG-6", Level.MUST, "does not obey a recording", ACCEPTING, PAGE)
def replay(bench: Bench) -> None:
    """'On', signed rightly and carried out, then off; the very same bytes again: not carried
    out."""
    need_key(bench)
    bench.dim()
    frame = on(bench, bench.key)
    bench.send_raw(frame, "COMMAND_LONG 405 (1), signed")
    bench.acknowledgement(COMMAND_ON_OFF)
    _ignored(bench, lambda: frame, "that was recorded")


@requirement("SG-7", Level.MUST, "does not obey what is over a minute old", ACCEPTING, PAGE)
def old(bench: Bench) -> None:
    """'On', signed on a link id of its own with a timestamp of two minutes ago: not carried out."""
    need_key(bench)
    signing = bench.connection.encoder.signing
    bench.status()
    before = (signing.timestamp, signing.link_id)
    message = bench.command_message(COMMAND_ON_OFF, 1)
    signing.timestamp, signing.link_id = before[0] - 12_000_000, (before[1] + 7) % 256
    try:
        frame = bytes(message.pack(bench.connection.encoder))
    finally:
        signing.timestamp, signing.link_id = before
    _ignored(bench, lambda: frame, "that is two minutes old")
