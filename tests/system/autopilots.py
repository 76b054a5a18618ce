# SPDX-License-Identifier: Apache-2.0
"""Autopilots as far as a gimbal meets them: what ArduPilot's and PX4's mount drivers send, in their
order and at their rates. The mathematics is that of the textbooks, and none of the light's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pharos import MavlinkConnection, Simulator, Source, Target

TICK_US = 20_000  # 50 Hz
SECOND_US = 1_000_000

TYPE_GIMBAL = 26
GIMBAL = 154
MOUNT_CONFIGURE = 204
MOUNT_CONTROL = 205
SET_MESSAGE_INTERVAL = 511
REQUEST_MESSAGE = 512
INFORMATION = 283
MAVLINK_TARGETING = 2

RETRACT = 1
LOCKS = 28  # roll, pitch, yaw
CRITICAL = 8 | 16 | 32 | 64 | 128  # encoder, power, motor, software, communication

NO_QUATERNION = (math.nan,) * 4
NO_RATES = (math.nan,) * 3


@dataclass
class Attitude:
    """Degrees."""

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0

    def radians(self) -> tuple[float, float, float]:
        return math.radians(self.roll), math.radians(self.pitch), math.radians(self.yaw)


def quaternion(attitude: Attitude) -> tuple[float, float, float, float]:
    """Yaw, then pitch, then roll."""
    r, p, y = (angle / 2 for angle in attitude.radians())
    cr, sr, cp, sp, cy, sy = (f(a) for a in (r, p, y) for f in (math.cos, math.sin))
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def pan_and_tilt(yaw: float, pitch: float, vehicle: Attitude) -> tuple[float, float]:
    """Where a direction of the earth is, seen from the vehicle's body [deg]."""
    y, p = math.radians(yaw), math.radians(pitch)
    to = (math.cos(p) * math.cos(y), math.cos(p) * math.sin(y), -math.sin(p))
    r, p, y = vehicle.radians()
    cr, sr, cp, sp, cy, sy = (f(a) for a in (r, p, y) for f in (math.cos, math.sin))
    axes = (
        (cp * cy, cp * sy, -sp),
        (sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp),
        (cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp),
    )
    ahead, right, down = (sum(a * b for a, b in zip(axis, to, strict=True)) for axis in axes)
    tilt = math.atan2(-down, math.hypot(ahead, right))
    return math.degrees(math.atan2(right, ahead)), math.degrees(tilt)


class Vehicle:
    """Beats once a second, and streams its attitude and position once it is asked to."""

    autopilot = 3  # ArduPilot

    def __init__(self, sim: Simulator, mav: MavlinkConnection, system: int = 1) -> None:
        self.sim = sim
        self.mav = MavlinkConnection(
            mav.link, sim, mav.dialect, Source(system, 1), Target(system, GIMBAL)
        )
        self.system = system
        self.attitude = Attitude()
        self.streams: dict[int, int] = {}  # message id to period [us]
        self.asked: list[tuple[int, int]] = []  # when [us], message id
        self.heard: list[Any] = []  # from the gimbal, with `at` the time
        self.answers = True  # to what it is asked for
        self._now = 0

    def fly(self, seconds: float) -> None:
        for _ in range(round(seconds * SECOND_US / TICK_US)):
            self.tick()

    def tick(self) -> None:
        self.sim.advance(TICK_US)
        self._now += TICK_US
        for message in self.mav.drain():
            self._take(message)
        self.mav.inbox.clear()
        if self._now % SECOND_US == 0:
            d = self.mav.dialect
            self.mav.send(d.MAVLink_heartbeat_message(2, self.autopilot, 0, 0, 4, 3))
        for message_id, period in self.streams.items():
            if self._now % period < TICK_US:
                self.stream(message_id)
        self.mount()

    def mount(self) -> None:
        """The mount driver's part of a tick."""

    def stream(self, message_id: int) -> None:
        d = self.mav.dialect
        if message_id == 30:
            self.mav.send(d.MAVLink_attitude_message(0, *self.attitude.radians(), 0, 0, 0))
        else:
            self.mav.send(d.MAVLink_global_position_int_message(0, 1, 1, 0, 0, 0, 0, 0, 65535))

    def _take(self, message: Any) -> None:
        if message.get_srcComponent() != GIMBAL:
            return
        message.at = self._now
        self.heard.append(message)
        kind = message.get_type()
        if kind == "REQUEST_DATA_STREAM" and message.target_system == self.system:
            self._ask({10: 30, 6: 33}[message.req_stream_id], message.req_message_rate)
        elif kind == "COMMAND_LONG" and message.command == SET_MESSAGE_INTERVAL:
            self._ask(int(message.param1), 1e6 / message.param2)

    def _ask(self, message_id: int, rate_hz: float) -> None:
        self.asked.append((self._now, message_id))
        if self.answers:
            self.streams[message_id] = round(1e6 / rate_hz)

    def last(self, kind: str, within_us: int = 10**9) -> Any | None:
        for message in reversed(self.heard):
            if message.get_type() == kind and self._now - message.at <= within_us:
                return message
        return None

    def status(self) -> Any:
        """Its last GIMBAL_DEVICE_ATTITUDE_STATUS."""
        status = self.last("GIMBAL_DEVICE_ATTITUDE_STATUS")
        assert status is not None
        return status

    def has_gimbal(self) -> bool:
        beat = self.last("HEARTBEAT", 5 * SECOND_US)
        return beat is not None and beat.type == TYPE_GIMBAL and beat.get_srcSystem() == self.system

    def is_healthy(self) -> bool:
        """As both count it: there, said what it can, and tells where it points each second."""
        status = self.last("GIMBAL_DEVICE_ATTITUDE_STATUS", SECOND_US)
        return (
            self.has_gimbal()
            and self.last("GIMBAL_DEVICE_INFORMATION") is not None
            and status is not None
            and status.failure_flags & CRITICAL == 0
        )

    def request(self, target: Target | None = None) -> None:
        self.mav.send_command_long(REQUEST_MESSAGE, INFORMATION, target=target)

    def set_attitude(
        self,
        flags: int,
        q: Sequence[float] = NO_QUATERNION,
        rates: Sequence[float] = NO_RATES,
    ) -> None:
        d = self.mav.dialect
        self.mav.send(
            d.MAVLink_gimbal_device_set_attitude_message(
                self.system, GIMBAL, flags, list(q), *rates
            )
        )

    def tell_state(self) -> None:
        d = self.mav.dialect
        self.mav.send(
            d.MAVLink_autopilot_state_for_gimbal_device_message(
                self.system,
                GIMBAL,
                self._now,
                list(quaternion(self.attitude)),
                0,
                *(0.0, 0.0, 0.0),
                0,
                math.nan,
                0,
                0,
            )
        )


class ArduPilot(Vehicle):
    """Its driver of protocol v2: finds component 154 by its heartbeat, asks once a second what it
    can, then sends its own state and where to point at 50 Hz."""

    retracted = False
    earth = False
    angles: Attitude | None = None
    rates: tuple[float, float, float] = (0.0, 0.0, 0.0)  # rad/s

    def mount(self) -> None:
        if not self.has_gimbal():
            return
        if self.last("GIMBAL_DEVICE_INFORMATION") is None:
            if self._now % SECOND_US == 0:
                self.request()
            return
        self.tell_state()
        if self.retracted:
            self.set_attitude(RETRACT, rates=(0.0, 0.0, 0.0))
        elif self.angles is not None:
            self.set_attitude(LOCKS if self.earth else 0, quaternion(self.angles))
        else:
            self.set_attitude(LOCKS if self.earth else 0, rates=self.rates)


class OldArduPilot(Vehicle):
    """Its SToRM32 driver: mount commands with pitch and yaw turned round."""

    angles: Attitude | None = None

    def mount(self) -> None:
        if self.has_gimbal() and self.angles is not None and self._now % 100_000 == 0:
            self.mav.send_command_long(
                MOUNT_CONTROL,
                *(-self.angles.pitch, self.angles.roll, -self.angles.yaw),
                *(0, 0, 0, MAVLINK_TARGETING),
            )


class Px4(Vehicle):
    """Its driver of protocol v2: asks everybody once a second what they can, takes the first that
    answers, then points it whenever there is something new."""

    autopilot = 12
    angles: Attitude | None = None
    rates: tuple[float, float, float] | None = None
    lock_yaw = False

    def mount(self) -> None:
        if self.last("GIMBAL_DEVICE_INFORMATION") is None:
            if self._now % SECOND_US == 0:
                self.request(Target(0, 0))
            return
        self.tell_state()
        flags = 4 | 8 | (16 if self.lock_yaw else 0)
        if self.angles is not None:
            self.set_attitude(flags, quaternion(self.angles))
        elif self.rates is not None:
            self.set_attitude(flags, rates=self.rates)


class OldPx4(Vehicle):
    """Its driver of mount commands: configures, then controls at 10 Hz, in degrees."""

    autopilot = 12
    angles: Attitude | None = None
    frames: tuple[int, int, int] = (0, 0, 0)  # of roll, pitch, yaw: body angle, rate, earth angle
    _configured: tuple[int, int, int] | None = None

    def mount(self) -> None:
        if self.angles is None or self._now % 100_000 != 0:
            return
        if self._configured != self.frames:
            self._configured = self.frames
            self.mav.send_command_long(
                MOUNT_CONFIGURE, MAVLINK_TARGETING, 0, 0, 0, *map(float, self.frames)
            )
        self.mav.send_command_long(
            MOUNT_CONTROL,
            *(self.angles.pitch, self.angles.roll, self.angles.yaw),
            *(0, 0, 0, MAVLINK_TARGETING),
        )
