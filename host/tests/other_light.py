# SPDX-License-Identifier: Apache-2.0
"""A light of another make: written from the MAVLink guide's pages (illuminator, command, heartbeat
and message-request protocols, versions) and common.xml alone, by someone who knew nothing of
`pharos check`. A torch without extras: one mode, no thermometer, no parameters, no files, no key.

Bytes and time in, bytes out."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
HEARTBEAT, COMMAND_LONG, COMMAND_INT = 0, 76, 75
MESSAGE_INTERVAL, PROTOCOL_VERSION, INFORMATION, STATUS = 244, 300, 396, 440
GET_INTERVAL, SET_INTERVAL, REQUEST_MESSAGE = 510, 511, 512
ON_OFF, CONFIGURE = 405, 406
SECOND_US = 1_000_000
INTERVAL_MIN_US = 20_000
PERIOD_MIN_S, PERIOD_MAX_S = 0.05, 2.0
MODE_INTERNAL = 1


class OtherLight:
    """component: MAV_COMP_ID_ILLUMINATOR by default."""

    def __init__(self, dialect: Any, system: int = 7, component: int = 243) -> None:
        self.d = dialect
        self.system, self.component = system, component
        self.codec = dialect.MAVLink(None, system, component)
        self.codec.robust_parsing = True
        self.is_on = False
        self.brightness, self.period, self.duty = 0.0, 0.0, 100.0
        self.now_us = 0
        self.heard_v2 = True
        # What is sent by itself: interval, and when next.
        self.streams = {HEARTBEAT: (SECOND_US, 0), STATUS: (SECOND_US, SECOND_US // 2)}
        self.defaults = {HEARTBEAT: SECOND_US, STATUS: SECOND_US}
        self.commands: dict[int, Callable[[list[float]], int]] = {
            ON_OFF: self.on_off,
            CONFIGURE: self.configure,
        }
        self.messages: dict[int, Callable[[], Any]] = {
            HEARTBEAT: self.heartbeat,
            STATUS: self.status,
            INFORMATION: self.information,
            PROTOCOL_VERSION: self.protocol_version,
        }

    # --- bytes and time -----------------------------------------------------------------------
    def receive(self, data: bytes) -> list[bytes]:
        """What it answers to bytes that came."""
        sent = []
        for message in self.codec.parse_buffer(data) or []:
            if message.get_type() == "BAD_DATA":
                continue
            source = (message.get_srcSystem(), message.get_srcComponent())
            if source == (self.system, self.component):
                continue
            self.heard_v2 = message.get_msgbuf()[0] == 0xFD
            if message.get_msgId() in (COMMAND_LONG, COMMAND_INT):
                sent += self.command(message, source)
        return [self.pack(message) for message in sent if self.fits(message)]

    def step(self, now_us: int) -> list[bytes]:
        """What it says by itself until then; next_us() says when it wants to be called."""
        self.now_us = now_us
        sent = []
        for number, (interval, due) in self.streams.items():
            if interval > 0 and due <= now_us:
                sent.append(self.messages[number]())
                self.streams[number] = (interval, max(due + interval, now_us + 1))
        return [self.pack(message) for message in sent if self.fits(message)]

    def next_us(self) -> int:
        return min(due for interval, due in self.streams.values() if interval > 0)

    def fits(self, message: Any) -> bool:
        return self.heard_v2 or message.get_msgId() < 256

    def pack(self, message: Any) -> bytes:
        frame = bytes(message.pack(self.codec, force_mavlink1=not self.heard_v2))
        self.codec.seq = (self.codec.seq + 1) % 256
        return frame

    # --- the command protocol -----------------------------------------------------------------
    def command(self, message: Any, source: tuple[int, int]) -> list[Any]:
        to_system, to_component = message.target_system, message.target_component
        if to_system not in (0, self.system) or to_component not in (0, self.component):
            return []
        params = [getattr(message, f"param{number}") for number in range(1, 5)]
        if message.get_msgId() == COMMAND_LONG:
            params += [message.param5, message.param6, message.param7]
        else:
            params += [float(message.x), float(message.y), message.z]
        more: list[Any] = []
        number = int(message.command)
        if number in self.commands:
            result = self.commands[number](params)
        elif number == REQUEST_MESSAGE:
            result = self.request(params, more)
        elif number == SET_INTERVAL:
            result = self.set_interval(params)
        elif number == GET_INTERVAL:
            result = self.get_interval(params, more)
        elif to_component == 0:
            return []  # it may be for another component
        else:
            result = UNSUPPORTED
        ack = self.d.MAVLink_command_ack_message(number, result, 0, 0, *source)
        return [ack, *more]

    @staticmethod
    def whole(value: float) -> int:
        """−2: it is no whole number."""
        return int(value) if math.isfinite(value) and value == int(value) else -2

    def request(self, params: list[float], more: list[Any]) -> int:
        number = self.whole(params[0])
        if number == MESSAGE_INTERVAL:
            return self.get_interval([params[1]], more)
        if number not in self.messages:
            return DENIED
        more.append(self.messages[number]())
        return ACCEPTED

    def set_interval(self, params: list[float]) -> int:
        number, interval = self.whole(params[0]), self.whole(params[1])
        if number not in self.defaults or interval < -1:
            return DENIED
        if number == HEARTBEAT and interval not in (0, SECOND_US):
            return DENIED
        if interval == 0:
            interval = self.defaults[number]
        if interval > 0:
            interval = max(interval, INTERVAL_MIN_US)
        self.streams[number] = (interval, self.now_us + max(interval, 0))
        return ACCEPTED

    def get_interval(self, params: list[float], more: list[Any]) -> int:
        number = self.whole(params[0])
        if number < 0 or number > 0xFFFF:
            return DENIED
        interval = self.streams[number][0] if number in self.streams else 0
        if number in self.messages and number not in self.streams:
            interval = -1
        more.append(self.d.MAVLink_message_interval_message(number, interval))
        return ACCEPTED

    # --- the illuminator protocol -------------------------------------------------------------
    def on_off(self, params: list[float]) -> int:
        if params[0] not in (0.0, 1.0):
            return DENIED
        self.is_on = params[0] == 1.0
        return ACCEPTED

    def configure(self, params: list[float]) -> int:
        mode, brightness, period, duty = params[:4]
        if mode != MODE_INTERNAL:
            return DENIED
        if not 0 <= brightness <= 100 or not 0 <= duty <= 100:
            return DENIED
        if period != 0 and not PERIOD_MIN_S <= period <= PERIOD_MAX_S:
            return DENIED
        self.brightness, self.period, self.duty = brightness, period, duty
        return ACCEPTED

    # --- messages -----------------------------------------------------------------------------
    def heartbeat(self) -> Any:
        d = self.d
        return d.MAVLink_heartbeat_message(
            d.MAV_TYPE_ILLUMINATOR, d.MAV_AUTOPILOT_INVALID, 0, 0, d.MAV_STATE_ACTIVE, 3
        )

    def status(self) -> Any:
        return self.d.MAVLink_illuminator_status_message(
            self.now_us // 1000, int(self.is_on), 1, 0, MODE_INTERNAL, self.brightness,
            self.period, self.duty, math.nan, PERIOD_MIN_S, PERIOD_MAX_S,
        )  # fmt: skip

    def information(self) -> Any:
        d = self.d
        capabilities = d.MAV_PROTOCOL_CAPABILITY_MAVLINK2 | d.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        return d.MAVLink_component_information_basic_message(
            self.now_us // 1000, capabilities, 0, b"Lumen", b"Torch 3", b"2.0.1", b"B", b"00417",
        )  # fmt: skip

    def protocol_version(self) -> Any:
        return self.d.MAVLink_protocol_version_message(200, 100, 200, bytes(8), bytes(8))
