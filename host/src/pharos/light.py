# SPDX-License-Identifier: Apache-2.0
"""An illuminator as its user sees it: on, off, brightness, strobe, over a MAVLink connection."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any

from .connection import MavlinkConnection, Target
from .errors import CommandError, SilentError

# Of MAVLink's common.xml.
TYPE_ILLUMINATOR = 44
TYPE_STATION = 6
COMMAND_ON_OFF = 405
COMMAND_CONFIGURE = 406
COMMAND_REQUEST_MESSAGE = 512
MESSAGE_INFORMATION = 396
MESSAGE_STATUS = 440
MODE_INTERNAL, MODE_EXTERNAL_SYNC = 1, 2
MODES = {0: "unknown", MODE_INTERNAL: "internal", MODE_EXTERNAL_SYNC: "external sync"}
ERRORS = {1: "thermal throttling", 2: "over-temperature shutdown", 4: "thermistor failure"}

COMMAND_MOUNT_CONTROL = 205
MOUNT_TARGETING = 2
COMPONENT_GIMBAL = 154
COMMAND_REBOOT = 246
REBOOT_FORCE = 20190226
COMMAND_SELF_TEST = 31010  # MAV_CMD_USER_1: this light's own
ACCEPTED = 0
IN_PROGRESS = 5
# A command that takes time says so at least this often [µs].
PROGRESS_US = 3_000_000
RESULTS = {
    1: "temporarily rejected: the light is busy; ask again",
    2: "denied: a value is out of range",
    3: "unsupported by this light",
    4: "failed: not possible now",
    5: "still in progress",
    6: "cancelled",
}
# How often a request is sent that nobody answers, and for how long each answer is waited for [µs].
TRIES = 3
HEARTBEAT_US = 1_000_000
TRY_US = 700_000
# A first strobe that nobody gave a duty cycle has this one [%].
DUTY_DEFAULT = 50.0


@dataclass(frozen=True)
class Status:
    """ILLUMINATOR_STATUS: what was commanded, and how the light is."""

    enable: bool
    mode: int
    brightness: float  # [%]
    strobe_period: float  # [s], 0: no strobe
    strobe_duty_cycle: float  # [%]
    temp_c: float
    errors: int
    min_strobe_period: float
    max_strobe_period: float
    uptime_ms: int

    @property
    def error_names(self) -> list[str]:
        return [name for bit, name in ERRORS.items() if self.errors & bit]

    @property
    def is_strobing(self) -> bool:
        return self.strobe_period > 0 and 0 < self.strobe_duty_cycle < 100

    def as_fields(self) -> dict[str, Any]:
        fields = asdict(self)
        fields["mode"] = MODES.get(self.mode, str(self.mode))
        fields["errors"] = self.error_names
        return fields

    def __str__(self) -> str:
        parts = ["on" if self.enable else "off", f"{self.brightness:g} %"]
        if self.is_strobing:
            period = _short(self.strobe_period)
            parts.append(f"strobe {period} s at {_short(self.strobe_duty_cycle)} %")
        if self.mode == MODE_EXTERNAL_SYNC:
            parts.append("external sync")
        parts.append("? °C" if math.isnan(self.temp_c) else f"{self.temp_c:.1f} °C")
        return ", ".join(parts + [name.upper() for name in self.error_names])


def _short(value: float) -> str:
    """A 32-bit float without the digits that it does not have."""
    return f"{value:.6g}"


@dataclass(frozen=True)
class Information:
    """COMPONENT_INFORMATION_BASIC."""

    vendor_name: str
    model_name: str
    software_version: str
    hardware_version: str
    serial_number: str
    capabilities: int
    time_manufacture_s: int


class Light:
    """Every command returns once the light has accepted it; CommandError says why it did not,
    SilentError that nobody answered."""

    def __init__(self, connection: MavlinkConnection) -> None:
        self.connection = connection
        self.status: Status | None = None  # the latest that came
        self.texts: list[str] = []  # STATUSTEXTs that nobody has taken
        self.heard_us = connection.pacer.now_us()  # when the light last said anything
        self._latest: dict[str, Any] = {}  # by type

    # --- who is there -------------------------------------------------------------------------
    def find(self, timeout_us: int = 3_000_000, target: Target | None = None) -> Target:
        """Waits for an illuminator's heartbeat, and addresses it from now on. target: that one."""
        connection = self.connection
        others: set[str] = set()
        end = connection.pacer.now_us() + timeout_us
        while (left := end - connection.pacer.now_us()) > 0:
            if connection.link.can_send():
                connection.heartbeat()
            for message in self._messages(min(left, 500_000), until="HEARTBEAT"):
                if message.get_type() != "HEARTBEAT":
                    continue
                found = Target(message.get_srcSystem(), message.get_srcComponent())
                wanted = message.type == TYPE_ILLUMINATOR if target is None else found == target
                if wanted:
                    connection.target = found
                    return found
                if message.type != TYPE_STATION:
                    others.add(f"{found.system}/{found.component}")
        who = f"component {target.system}/{target.component}" if target else "illuminator"
        heard = f"; heard {', '.join(sorted(others))}" if others else ""
        raise connection.silence(f"no {who} answered within {timeout_us / 1e6:g} s{heard}")

    def poll(self, us: int = 0) -> list[Any]:
        """Lets `us` pass, or less if something comes; what came."""
        return self._messages(us)

    def poll_target(self, us: int) -> list[Any]:
        """As poll(), of the light only."""
        return [message for message in self._messages(us) if self._is_target(message)]

    def _is_target(self, message: Any) -> bool:
        target = self.connection.target
        source = (message.get_srcSystem(), message.get_srcComponent())
        return source == (target.system, target.component)

    def _messages(self, us: int, until: str | None = None) -> list[Any]:
        """What comes within `us`; with `until`, no longer than to a message of that type."""
        connection = self.connection
        end = connection.pacer.now_us() + us
        came: list[Any] = []
        while True:
            left = max(0, end - connection.pacer.now_us())
            connection.keep_alive(HEARTBEAT_US)
            connection.pacer.pump(min(left, 20_000))
            fresh = connection.drain()
            connection.inbox.clear()
            for message in fresh:
                self._note(message)
            came += fresh
            if left == 0 or (fresh and until is None):
                return came
            if any(message.get_type() == until for message in fresh):
                return came

    def _note(self, message: Any) -> None:
        if not self._is_target(message):
            return
        self.heard_us = self.connection.pacer.now_us()
        self._latest[message.get_type()] = message
        if message.get_type() == "ILLUMINATOR_STATUS":
            self.status = status_of(message)
        elif message.get_type() == "STATUSTEXT":
            self.texts.append(str(message.text))

    # --- other components of its system -------------------------------------------------------
    @contextmanager
    def _component(self, component: int) -> Iterator[None]:
        """Commands go to that component meanwhile."""
        light = self.connection.target
        self.connection.target = Target(light.system, component)
        try:
            yield
        finally:
            self.connection.target = light

    def point(self, pan_deg: float, tilt_deg: float) -> None:
        """Turns the beam: pan to the right of the nose, tilt up."""
        with self._component(COMPONENT_GIMBAL):
            self.command(COMMAND_MOUNT_CONTROL, tilt_deg, 0, pan_deg, 0, 0, 0, MOUNT_TARGETING)

    # --- commands -----------------------------------------------------------------------------
    def command(
        self,
        command: int,
        *params: float,
        on_progress: Callable[[int], None] = lambda _: None,
    ) -> None:
        """Sends COMMAND_LONG until it is answered. One that takes time is waited for as long as it
        goes on; on_progress: how far it is [%]."""
        connection = self.connection
        for confirmation in range(TRIES):
            connection.send_command_long(command, *params, confirmation=confirmation)
            end = connection.pacer.now_us() + TRY_US
            while (left := end - connection.pacer.now_us()) > 0:
                for message in self._messages(left, until="COMMAND_ACK"):
                    if message.get_type() != "COMMAND_ACK" or message.command != command:
                        continue
                    if message.result != IN_PROGRESS:
                        self._check(command, int(message.result))
                        return
                    on_progress(int(message.progress))
                    end = connection.pacer.now_us() + PROGRESS_US
        raise connection.silence("the light stopped answering")

    def _check(self, command: int, result: int) -> None:
        if result == ACCEPTED:
            return
        reason = RESULTS.get(result, f"result {result}")
        status = self.status
        if result == 2 and command == COMMAND_CONFIGURE and status is not None:
            low, high = _short(status.min_strobe_period), _short(status.max_strobe_period)
            reason += f"; brightness and duty go from 0 to 100 %, periods from {low} to {high} s"
        if result == 4 and status is not None and status.errors:
            reason += f" ({', '.join(status.error_names)})"
        raise CommandError(reason, result)

    def on(self) -> None:
        self.command(COMMAND_ON_OFF, 1)

    def off(self) -> None:
        self.command(COMMAND_ON_OFF, 0)

    def reboot(self, force: bool = False) -> None:
        """CommandError: not while the lamp is on, unless forced."""
        self.command(COMMAND_REBOOT, 0, 0, 1, 0, 0, REBOOT_FORCE if force else 0)

    def self_test(
        self, percent: float = 0, on_progress: Callable[[int], None] = lambda _: None
    ) -> None:
        """Sweeps the lamp, up to that brightness (0: full) [%]. Takes seconds."""
        self.command(COMMAND_SELF_TEST, 1, percent, on_progress=on_progress)

    def configure(self, wanted: Status) -> None:
        """Sets mode, brightness, strobe and duty cycle of `wanted`, all or nothing."""
        mode = wanted.mode or MODE_INTERNAL
        self.command(
            COMMAND_CONFIGURE,
            mode,
            wanted.brightness,
            wanted.strobe_period,
            wanted.strobe_duty_cycle,
        )

    def set_brightness(self, percent: float) -> None:
        self.configure(replace(self.fetch_status(), brightness=percent))

    def set_strobe(self, period_s: float, duty: float | None = None) -> None:
        """period_s 0: a steady light."""
        now = self.fetch_status()
        if duty is None and period_s and not 0 < now.strobe_duty_cycle < 100:
            duty = DUTY_DEFAULT
        if duty is not None:
            now = replace(now, strobe_duty_cycle=duty)
        self.configure(replace(now, strobe_period=period_s))

    def set_sync(self, external: bool) -> None:
        """Whether an input line gates the lamp, instead of its own clock."""
        mode = MODE_EXTERNAL_SYNC if external else MODE_INTERNAL
        self.configure(replace(self.fetch_status(), mode=mode))

    # --- reports ------------------------------------------------------------------------------
    def _request(self, number: int, kind: str) -> Any:
        """A message on request: it follows the acknowledgement."""
        pacer = self.connection.pacer
        self._latest.pop(kind, None)
        self.command(COMMAND_REQUEST_MESSAGE, number)
        end = pacer.now_us() + TRY_US
        while kind not in self._latest:
            left = end - pacer.now_us()
            if left <= 0:
                raise SilentError(f"{self.connection.link}: the light sent no {kind}")
            self._messages(left, until=kind)
        return self._latest[kind]

    def fetch_status(self) -> Status:
        """A fresh status, on request."""
        return status_of(self._request(MESSAGE_STATUS, "ILLUMINATOR_STATUS"))

    def next_status(self, timeout_us: int = 3_000_000) -> Status:
        """The next status that the light sends by itself."""
        end = self.connection.pacer.now_us() + timeout_us
        while (left := end - self.connection.pacer.now_us()) > 0:
            self.status = None
            self._messages(left, until="ILLUMINATOR_STATUS")
            if self.status is not None:
                return self.status
        raise SilentError(f"{self.connection.link}: no status within {timeout_us / 1e6:g} s")

    def fetch_information(self) -> Information:
        message = self._request(MESSAGE_INFORMATION, "COMPONENT_INFORMATION_BASIC")
        vendor, model, software, hardware, serial = (
            str(getattr(message, name)).rstrip("\0")
            for name in (
                "vendor_name",
                "model_name",
                "software_version",
                "hardware_version",
                "serial_number",
            )
        )
        return Information(
            vendor,
            model,
            software,
            hardware,
            serial,
            int(message.capabilities),
            int(message.time_manufacture_s),
        )


def status_of(message: Any) -> Status:
    return Status(
        enable=bool(message.enable),
        mode=int(message.mode),
        brightness=_exact(message.brightness),
        strobe_period=_exact(message.strobe_period),
        strobe_duty_cycle=_exact(message.strobe_duty_cycle),
        temp_c=_exact(message.temp_c),
        errors=int(message.error_status),
        min_strobe_period=_exact(message.min_strobe_period),
        max_strobe_period=_exact(message.max_strobe_period),
        uptime_ms=int(message.uptime_ms),
    )


def _exact(value: float) -> float:
    """The shortest decimal that crosses the wire as this 32-bit float: 0.1, not 0.10000000149."""
    return float(f"{value:.7g}")
