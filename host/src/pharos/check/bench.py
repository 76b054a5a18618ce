# SPDX-License-Identifier: Apache-2.0
"""The conversation with the light under test: what was sent and heard, and when."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pymavlink.generator.mavcrc import x25crc

from ..connection import SIGNED, MavlinkConnection, Target
from ..light import (
    ACCEPTED,
    COMMAND_CONFIGURE,
    COMMAND_ON_OFF,
    COMMAND_REQUEST_MESSAGE,
    MESSAGE_STATUS,
    MODE_INTERNAL,
)
from ..photodiode import Photodiode
from .spec import Failed, NotOffered, expect
from .transcript import Transcript

# How long an answer may take, and how long a second one is waited for [µs].
ANSWER_US = 1_000_000
SETTLE_US = 60_000
# Time is told no finer than this in simulated time [µs].
STEP_US = 10_000
# Frames of 40 bytes, more of them than the longest frame has room for; and the pause after each.
AGAIN = 10
AGAIN_US = 300_000
HEARTBEAT_US = 1_000_000
# A light of which nothing has been heard for this long has fallen silent [µs].
SILENCE_US = 6_000_000
OBSERVATION_US = 6_000_000

IN_PROGRESS = 5
DENIED = 2
UNSUPPORTED = 3
RESULTS = {
    0: "ACCEPTED",
    1: "TEMPORARILY_REJECTED",
    2: "DENIED",
    3: "UNSUPPORTED",
    4: "FAILED",
    5: "IN_PROGRESS",
    6: "CANCELLED",
    7: "COMMAND_LONG_ONLY",
    8: "COMMAND_INT_ONLY",
}
SHUTDOWN = 2  # ILLUMINATOR_ERROR_FLAGS_OVER_TEMPERATURE_SHUTDOWN
# While it is looked at, the lamp is no brighter than this [%].
DIM = 5.0
NAN = math.nan


@dataclass(frozen=True)
class Heard:
    time_us: int
    message: Any


@dataclass(frozen=True)
class Settings:
    """What a light was told, as ILLUMINATOR_STATUS reports it."""

    enable: int
    mode: int
    brightness: float
    strobe_period: float
    strobe_duty_cycle: float

    @classmethod
    def of(cls, status: Any) -> Settings:
        return cls(
            int(status.enable),
            int(status.mode),
            float(status.brightness),
            float(status.strobe_period),
            float(status.strobe_duty_cycle),
        )


@dataclass
class Facts:
    """What was found out about the light on the way, by whichever requirement asked first."""

    observation: list[Heard] | None = None
    status: Any = None
    capabilities: int | None = None
    parameters: dict[str, Any] | None = None
    parameter_count: int = 0
    listed: list[Any] = field(default_factory=list)


class Bench(Transcript):
    """Talks to one light."""

    def __init__(
        self,
        connection: MavlinkConnection,
        key: bytes = b"",
        photodiode: Photodiode | None = None,
    ) -> None:
        super().__init__(connection.pacer, SILENCE_US)
        self.connection = connection
        self.key = key
        self.photodiode = photodiode
        self.d = connection.dialect
        self.facts = Facts()
        self._beat_us = self.heard_us - HEARTBEAT_US
        self._malformed = 0
        self._fresh: list[Heard] = []

    @property
    def target(self) -> Target:
        return self.connection.target

    # --- sending ------------------------------------------------------------------------------
    def send(self, message: Any, *, version: int = 2) -> None:
        self.connection.version = version
        try:
            self.send_raw(self.connection.encode(message), describe(message))
        finally:
            self.connection.version = 2

    def send_raw(self, data: bytes, what: str) -> None:
        self.note(f"→ {what}")
        self.connection.link.send(data)

    def frame(self, message: Any) -> bytes:
        return self.connection.encode(message)

    def sealed(self, frame: bytes, crc_extra: int, wrong: int = 0) -> bytes:
        """A MAVLink 2 frame, changed by hand, as it is sent: with a checksum that fits (but for the
        bits of `wrong`), and rightly signed if there is a key."""
        changed = bytearray(frame)
        changed[2] |= SIGNED if self.key else 0
        framed = bytearray(with_checksum(bytes(changed), crc_extra))
        framed[-2] ^= wrong
        if not self.key:
            return bytes(framed)
        signing = self.connection.encoder.signing
        signing.timestamp += 1
        stamp = int(signing.timestamp).to_bytes(6, "little")
        head = bytes(framed) + bytes([signing.link_id]) + stamp
        return head + hashlib.sha256(self.key + head).digest()[:6]

    def heartbeat(self) -> None:
        if self.now() - self._beat_us >= HEARTBEAT_US and self.connection.link.can_send():
            self._beat_us = self.now()
            self.connection.heartbeat()

    # --- hearing ------------------------------------------------------------------------------
    def listen(self, us: int, until: Callable[[Any], bool] | None = None) -> list[Heard]:
        """Everything that comes from the light within `us`, or up to the first for which `until`
        holds."""
        end = self.now() + us
        came: list[Heard] = []
        while True:
            self.heartbeat()
            left = end - self.now()
            self.connection.pacer.pump(max(0, min(left, STEP_US)))
            fresh = [Heard(self.now(), message) for message in self.connection.drain()]
            self.connection.inbox.clear()
            fresh = [heard for heard in fresh if self.is_ours(heard.message)]
            if fresh:
                self.heard_us = self.now()
            for heard in fresh:
                if heard.message.get_type() not in ("HEARTBEAT", "PARAM_VALUE"):
                    self.note(f"← {describe(heard.message)}")
            came += fresh
            if until is not None and any(until(heard.message) for heard in fresh):
                return came
            if self.now() >= end:
                return came

    def is_ours(self, message: Any) -> bool:
        target = self.target
        source = (message.get_srcSystem(), message.get_srcComponent())
        return source == (target.system, target.component)

    def wait_for(self, kind: str, us: int, where: Callable[[Any], bool] = lambda _: True) -> Any:
        """The next message of that kind for which `where` holds; None: none came in time."""

        def found(message: Any) -> bool:
            return bool(message.get_type() == kind and where(message))

        came = self.listen(us, found)
        return next((heard.message for heard in came if found(heard.message)), None)

    def malformed(self) -> list[Any]:
        """Frames that could not be decoded since the last call."""
        fresh = self.connection.malformed[self._malformed :]
        self._malformed = len(self.connection.malformed)
        return fresh

    def observation(self) -> list[Heard]:
        """What the light says when nobody asks, over OBSERVATION_US."""
        if self.facts.observation is None:
            self.note(f"  listens for {OBSERVATION_US / 1e6:g} s")
            self.facts.observation = self.listen(OBSERVATION_US)
        return self.facts.observation

    # --- commands -----------------------------------------------------------------------------
    def command_message(
        self,
        command: int,
        *params: float,
        target: Target | None = None,
        confirmation: int = 0,
        as_int: bool = False,
    ) -> Any:
        to = target or self.target
        p = (list(params) + [0.0] * 7)[:7]
        if as_int:
            return self.d.MAVLink_command_int_message(
                to.system, to.component, 0, command, 0, 0, *p[:4], int(p[4]), int(p[5]), p[6]
            )
        return self.d.MAVLink_command_long_message(
            to.system, to.component, command, confirmation, *p
        )

    def command(self, command: int, *params: float, version: int = 2, **kwargs: Any) -> Any:
        """Sends it; its final COMMAND_ACK, or None if none came in time."""
        self.listen(0)
        self.send(self.command_message(command, *params, **kwargs), version=version)
        return self.acknowledgement(command)

    def acknowledgement_within(self, command: int, us: int) -> Any:
        """Its final one, or None."""
        return self.wait_for(
            "COMMAND_ACK",
            us,
            lambda m: m.command == command and m.result != IN_PROGRESS,
        )

    def acknowledgement(self, command: int) -> Any:
        answer = self.acknowledgement_within(command, ANSWER_US)
        if answer is not None:
            # A second one, which is CM-1's, must not be taken for the next one's.
            self._fresh = self.listen(SETTLE_US)
        return answer

    def accepted(self, command: int, *params: float, **kwargs: Any) -> Any:
        answer = self.command(command, *params, **kwargs)
        expect(answer is not None, f"no COMMAND_ACK to {name_of(self.d, command)} within 1 s")
        expect(
            answer.result == ACCEPTED,
            f"{name_of(self.d, command)} {shown(params)}: {result_name(answer)}, expected ACCEPTED",
        )
        return answer

    def refused(self, command: int, *params: float, **kwargs: Any) -> Any:
        """An answer that is no acceptance."""
        answer = self.command(command, *params, **kwargs)
        expect(answer is not None, f"no COMMAND_ACK to {name_of(self.d, command)} within 1 s")
        expect(
            answer.result not in (ACCEPTED, IN_PROGRESS),
            f"{name_of(self.d, command)} {shown(params)}: ACCEPTED, expected a refusal",
        )
        return answer

    def request(self, number: int, kind: str, *params: float) -> Any:
        """A message on request, after its acknowledgement."""
        self.listen(0)
        self.send(self.command_message(COMMAND_REQUEST_MESSAGE, number, *params))
        answer: list[Any] = []

        def done(message: Any) -> bool:
            name = message.get_type()
            if name == "COMMAND_ACK" and message.command == COMMAND_REQUEST_MESSAGE:
                answer.append(message)
                return bool(message.result != ACCEPTED)
            return bool(answer) and bool(name == kind)

        came = self.listen(2 * ANSWER_US, done)
        expect(bool(answer), f"no COMMAND_ACK to REQUEST_MESSAGE({number}) within 2 s")
        expect(
            answer[0].result == ACCEPTED,
            f"REQUEST_MESSAGE({number}): {result_name(answer[0])}",
        )
        last = came[-1].message if came else None
        if last is None or last.get_type() != kind:
            # A light that sends it before the acknowledgement is CM-7's business.
            early = [h.message for h in came if h.message.get_type() == kind]
            expect(bool(early), f"REQUEST_MESSAGE({number}): ACCEPTED, but no {kind} within 2 s")
            last = early[-1]
        return last

    # --- the lamp -----------------------------------------------------------------------------
    def status(self) -> Any:
        """A fresh ILLUMINATOR_STATUS: on request, or the next of the stream if requests fail."""
        try:
            status = self.request(MESSAGE_STATUS, "ILLUMINATOR_STATUS")
        except Failed:
            status = self.wait_for("ILLUMINATOR_STATUS", 2_500_000)
            if status is None:
                raise
        self.facts.status = status
        return status

    def known_status(self) -> Any:
        return self.facts.status or self.status()

    def settings(self) -> Settings:
        return Settings.of(self.status())

    def configure(
        self,
        brightness: float = DIM,
        period: float = 0.0,
        duty: float = 0.0,
        mode: float = MODE_INTERNAL,
    ) -> Any:
        """The acknowledgement, or None."""
        return self.command(COMMAND_CONFIGURE, mode, brightness, period, duty)

    def switch(self, on: float, **kwargs: Any) -> Any:
        return self.command(COMMAND_ON_OFF, on, **kwargs)

    def dim(self, on: bool = False) -> Settings:
        """Off (or on), at DIM, without strobe; what the light then reports."""
        self.configure()
        self.switch(1 if on else 0)
        return self.settings()

    def lit(self) -> Settings:
        """As dim(True); NotOffered if heat forbids to switch on."""
        now = self.dim(True)
        if not now.enable and self.known_status().error_status & SHUTDOWN:
            raise NotOffered("the light is too hot to be switched on")
        return now

    def periods(self) -> tuple[float, float]:
        """The reported range of the strobe's period; NotOffered if there is none to use."""
        status = self.known_status()
        low, high = float(status.min_strobe_period), float(status.max_strobe_period)
        if not (math.isfinite(low) and math.isfinite(high) and 0 <= low <= high and high > 0):
            raise NotOffered(f"the reported range of periods, {low:g} … {high:g} s, has no use")
        return low, high

    def capabilities(self) -> int:
        """MAV_PROTOCOL_CAPABILITY of COMPONENT_INFORMATION_BASIC; 0: not said."""
        if self.facts.capabilities is None:
            try:
                message = self.request(396, "COMPONENT_INFORMATION_BASIC")
                self.facts.capabilities = int(message.capabilities)
            except Failed:
                self.facts.capabilities = 0
        return self.facts.capabilities

    def alive(self, why: str) -> None:
        """Failed unless the light answers again: what came before may have taken the beginning of
        what comes now, up to the longest frame's length."""
        for _ in range(AGAIN):
            self.listen(0)
            message = self.command_message(COMMAND_REQUEST_MESSAGE, MESSAGE_STATUS)
            self.send(message)
            if self.acknowledgement_within(COMMAND_REQUEST_MESSAGE, AGAIN_US) is not None:
                self.listen(SETTLE_US)
                return
        if self.acknowledgement_within(COMMAND_REQUEST_MESSAGE, ANSWER_US) is None:
            raise Failed(f"no answer any more {why}")


# --- texts ----------------------------------------------------------------------------------------
def shown(values: Any) -> str:
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"


def name_of(dialect: Any, command: int) -> str:
    entry = dialect.enums["MAV_CMD"].get(command)
    return entry.name.removeprefix("MAV_CMD_") if entry else f"command {command}"


def result_name(ack: Any) -> str:
    return RESULTS.get(int(ack.result), f"result {ack.result}")


def describe(message: Any) -> str:
    """A message in a line."""
    kind = message.get_type()
    if kind == "COMMAND_ACK":
        return f"COMMAND_ACK {message.command} {result_name(message)}"
    fields = {name: getattr(message, name, None) for name in message.get_fieldnames()}
    if kind == "COMMAND_LONG":
        where = f"{message.target_system}/{message.target_component}"
        again = f" confirmation {message.confirmation}" if message.confirmation else ""
        values = shown(fields[f"param{n}"] for n in range(1, 8))
        return f"COMMAND_LONG {message.command} {values} to {where}{again}"
    if kind == "COMMAND_INT":
        where = f"{message.target_system}/{message.target_component}"
        names = ("param1", "param2", "param3", "param4", "x", "y", "z")
        return f"COMMAND_INT {message.command} {shown(fields[n] for n in names)} to {where}"
    text = " ".join(f"{name}={_value(value)}" for name, value in fields.items())
    return f"{kind} {text}"[:200]


def _value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | bytes | bytearray):
        return f"{len(value)} bytes"
    return str(value).rstrip("\0")


# --- frames ---------------------------------------------------------------------------------------
def with_checksum(frame: bytes, crc_extra: int) -> bytes:
    """A MAVLink 2 frame, changed by hand, with a checksum that fits and without a signature."""
    body = 10 + frame[1]
    crc = x25crc(frame[1:body])
    crc.accumulate(bytes([crc_extra]))
    return frame[:body] + int(crc.crc).to_bytes(2, "little")


def unpacked(frame: bytes) -> bytes:
    """The payload of a MAVLink 2 frame."""
    return frame[10 : 10 + frame[1]]


def repacked(frame: bytes, payload: bytes) -> bytes:
    """The frame with another payload, and no checksum yet."""
    return bytes([frame[0], len(payload)]) + frame[2:10] + payload
