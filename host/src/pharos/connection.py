# SPDX-License-Identifier: Apache-2.0
"""A MAVLink client over any link. Waiting lets time pass through the link's `Pacer`: simulated
time in lock-step, so nothing sleeps and nothing is missed, or real time."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .errors import SilentError
from .link import Link, Pacer

# Ids a ground station uses.
OWN_SYSTEM = 255
OWN_COMPONENT = 190
ILLUMINATOR_COMPONENT = 243
# Length of the first and longest wait between looks at the inbox [µs].
STEP_MIN_US = 1_000
STEP_MAX_US = 100_000
HISTORY_MAX = 100_000
MALFORMED_MAX = 10_000
# What a timestamp of signed messages counts [µs].
TIMESTAMP_US = 10
# The incompatibility flag of a signed frame.
SIGNED = 1
# 2015-01-01 in Unix time, from which they count [s].
SIGNING_EPOCH_S = 1_420_070_400
# A client that has spoken is not silent for longer than this, if keep_alive() is called in time.
KEEP_ALIVE_US = 15_000_000


def signing_time() -> int:
    """The host's clock as a timestamp of signed messages: units of 10 µs since 2015."""
    return int((time.time() - SIGNING_EPOCH_S) * 1e6) // TIMESTAMP_US


@dataclass(frozen=True)
class Source:
    """Who a client says it is."""

    system: int = OWN_SYSTEM
    component: int = OWN_COMPONENT


@dataclass(frozen=True)
class Target:
    """Whom commands are addressed to; zero means all."""

    system: int
    component: int = ILLUMINATOR_COMPONENT


class MavlinkConnection:
    """`inbox` holds decoded messages not yet received, `history` every one since the start."""

    def __init__(
        self,
        link: Link,
        pacer: Pacer,
        dialect: Any,
        source: Source | None = None,
        target: Target | None = None,
    ) -> None:
        self.link = link
        self.pacer = pacer
        self.dialect = dialect
        self.source = source or Source()
        self.target = target or Target(1)
        self.inbox: deque[Any] = deque()
        self.history: deque[Any] = deque(maxlen=HISTORY_MAX)
        self.malformed: list[Any] = []  # pymavlink's BAD_DATA: bytes, and what is wrong with them
        self.version = 2
        self._spoke_us: int | None = None
        self._clock_offset = 0
        self.encoder = self._new_codec()
        self._decoder = self._new_codec()

    def _new_codec(self) -> Any:
        codec = self.dialect.MAVLink(None, self.source.system, self.source.component)
        codec.robust_parsing = True
        return codec

    def sign(self, key: bytes, timestamp: int, link_id: int = 0) -> None:
        """From now on what is sent is signed, from that timestamp on (units of 10 µs since 2015),
        and what comes unsigned or wrongly signed is not received; an empty key: no longer."""
        for codec in (self.encoder, self._decoder):
            codec.signing.secret_key = key or None
            codec.signing.timestamp = timestamp
            codec.signing.link_id = link_id
            codec.signing.sign_outgoing = bool(key)
        self._clock_offset = timestamp - self.pacer.now_us() // TIMESTAMP_US

    def take_all(self) -> None:
        """From now on frames are received whether they are rightly signed or not."""
        self._decoder.signing.allow_unsigned_callback = lambda _codec, _message: True

    @property
    def signs(self) -> bool:
        """Whether what is sent is signed."""
        return bool(self.encoder.signing.sign_outgoing)

    def hears_signed(self) -> bool:
        """Whether the target's latest message was signed."""
        target = (self.target.system, self.target.component)
        for message in reversed(self.history):
            if (message.get_srcSystem(), message.get_srcComponent()) == target:
                return bool(message.get_header().incompat_flags & SIGNED)
        return False

    def silence(self, what: str) -> SilentError:
        """The error that nobody did `what`, with the reason if there is one to be seen."""
        if self.hears_signed() and not self.signs:
            what = "the light signs its messages and obeys only who has its key: --key-file FILE"
        elif self.signs and any("signature" in str(bad.reason) for bad in self.malformed):
            what += "; what came is not signed with this key"
        elif self.malformed and not self.history:
            what += "; what came is no MAVLink: is the baud rate right?"
        return SilentError(f"{self.link}: {what}")

    def encode(self, message: Any) -> bytes:
        """The next frame that carries `message`: counts the sequence number."""
        self._spoke_us = self.pacer.now_us()
        signing = self.encoder.signing
        now = self._spoke_us // TIMESTAMP_US + self._clock_offset
        signing.timestamp = max(signing.timestamp, now)
        frame: bytes = message.pack(self.encoder, force_mavlink1=self.version == 1)
        self.encoder.seq = (self.encoder.seq + 1) % 256
        return bytes(frame)

    def send(self, message: Any) -> None:
        self.link.send(self.encode(message))

    def drain(self) -> list[Any]:
        """Decodes what lies in the link's inbox; returns the new messages."""
        fresh: list[Any] = []
        for chunk in self.link.take():
            for message in self._decoder.parse_buffer(chunk) or []:
                if message.get_type() != "BAD_DATA":
                    fresh.append(message)
                elif len(self.malformed) < MALFORMED_MAX:
                    self.malformed.append(message)
        self.inbox.extend(fresh)
        self.history.extend(fresh)
        return fresh

    def pass_time(self, us: int) -> list[Any]:
        """Lets `us` pass and returns what came; the inbox is empty afterwards."""
        end = self.pacer.now_us() + us
        self.pacer.pump(us)
        while self.pacer.now_us() < end:
            self.pacer.pump(end - self.pacer.now_us())
        self.drain()
        came = list(self.inbox)
        self.inbox.clear()
        return came

    def recv(
        self,
        kind: str,
        *,
        timeout_us: int = 2_000_000,
        where: Callable[[Any], bool] = lambda _message: True,
    ) -> Any:
        """The next message of type `kind` for which `where` holds. What came before it is dropped
        from the inbox, as pymavlink's recv_match does. SilentError after `timeout_us`."""
        message = self.poll(kind, timeout_us=timeout_us, where=where)
        if message is None:
            raise SilentError(f"no {kind} within {timeout_us / 1e6:g} s over {self.link}")
        return message

    def poll(
        self,
        kind: str,
        *,
        timeout_us: int = 0,
        where: Callable[[Any], bool] = lambda _message: True,
    ) -> Any | None:
        """As recv(), but None if nothing of that kind came."""
        end = self.pacer.now_us() + timeout_us
        step = 0
        while True:
            self.pacer.pump(step)
            self.drain()
            while self.inbox:
                message = self.inbox.popleft()
                if message.get_type() == kind and where(message):
                    return message
            left = end - self.pacer.now_us()
            if left <= 0:
                return None
            step = min(max(2 * step, STEP_MIN_US), STEP_MAX_US, left)

    def heartbeat(self) -> None:
        """Says that a ground station is here; a listening light learns where to answer."""
        d = self.dialect
        self.send(
            d.MAVLink_heartbeat_message(
                d.MAV_TYPE_GCS, d.MAV_AUTOPILOT_INVALID, 0, 0, d.MAV_STATE_ACTIVE, 3
            )
        )

    def keep_alive(self, silence_us: int = KEEP_ALIVE_US) -> None:
        """A heartbeat, if this client has spoken, but not within the last `silence_us`."""
        if self._spoke_us is not None and self.pacer.now_us() - self._spoke_us >= silence_us:
            self.heartbeat()

    def command_long(
        self,
        command: int,
        *params: float,
        target: Target | None = None,
        confirmation: int = 0,
        timeout_us: int = 1_000_000,
    ) -> Any:
        """Sends COMMAND_LONG (missing parameters are 0) and returns its COMMAND_ACK."""
        self.send_command_long(command, *params, target=target, confirmation=confirmation)
        return self._ack(command, timeout_us)

    def send_command_long(
        self, command: int, *params: float, target: Target | None = None, confirmation: int = 0
    ) -> None:
        to = target or self.target
        seven = (list(params) + [0.0] * 7)[:7]
        self.send(
            self.dialect.MAVLink_command_long_message(
                to.system, to.component, command, confirmation, *seven
            )
        )

    def command_int(
        self,
        command: int,
        *params: float,
        target: Target | None = None,
        timeout_us: int = 1_000_000,
    ) -> Any:
        """Sends COMMAND_INT (params: 1 … 4, x, y, z) and returns its COMMAND_ACK."""
        self.send_command_int(command, *params, target=target)
        return self._ack(command, timeout_us)

    def send_command_int(self, command: int, *params: float, target: Target | None = None) -> None:
        to = target or self.target
        p = (list(params) + [0.0] * 7)[:7]
        self.send(
            self.dialect.MAVLink_command_int_message(
                to.system, to.component, 0, command, 0, 0, *p[:4], int(p[4]), int(p[5]), p[6]
            )
        )

    def _ack(self, command: int, timeout_us: int) -> Any:
        return self.recv("COMMAND_ACK", timeout_us=timeout_us, where=lambda m: m.command == command)

    def close(self) -> None:
        self.link.close()
