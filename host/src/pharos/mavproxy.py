# SPDX-License-Identifier: Apache-2.0
"""A module of MAVProxy: `module load pharos`, then `light on`, `light strobe 2 10`, …

It speaks to the first illuminator that MAVProxy hears, of whatever maker, beside a vehicle or
alone, and shows its status in the console. MAVProxy calls the methods below from its one thread.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from MAVProxy.modules.lib import mp_module

from .connection import Target
from .dialect import load_dialect
from .errors import PharosError, UsageError
from .light import (
    ACCEPTED,
    COMMAND_CONFIGURE,
    COMMAND_ON_OFF,
    DUTY_DEFAULT,
    IN_PROGRESS,
    MODE_INTERNAL,
    RESULTS,
    TRIES,
    TRY_US,
    TYPE_ILLUMINATOR,
    Status,
    status_of,
)

STATUS_ID = 440  # ILLUMINATOR_STATUS, which pymavlink's own dialects lack
USAGE = "usage: light on | off | brightness PERCENT | strobe PERIOD [DUTY] | steady | status"


@dataclass
class Asked:
    """A command that is not answered yet."""

    command: int
    params: tuple[float, ...]
    then: dict[str, float]  # what its status has when it is taken
    tries: int = 0
    due: float = 0


class LightModule(mp_module.MPModule):  # type: ignore[misc]
    def __init__(self, mpstate: Any, clock: Callable[[], float] = time.monotonic) -> None:
        # Of all vehicles: MAVProxy gives other modules what its target says, and a light that is
        # alone never becomes the target.
        super().__init__(mpstate, "pharos", "a light", public=True, multi_vehicle=True)
        self.light: Target | None = None
        self.latest: Status | None = None
        self._clock = clock
        self._asked: Asked | None = None
        self._reader = load_dialect().MAVLink(None)
        words = ["on", "off", "brightness", "strobe", "steady", "status"]
        self.add_command("light", self.cmd_light, "switch, dim and strobe a light", words)

    # --- what the user types ------------------------------------------------------------------
    def cmd_light(self, words: Sequence[str]) -> None:
        try:
            self._run(words)
        except (UsageError, ValueError):
            self._say(USAGE)
        except PharosError as error:
            self._say(str(error))

    def _run(self, words: Sequence[str]) -> None:
        match list(words):
            case ["on"]:
                self._switch(True)
            case ["off"]:
                self._switch(False)
            case ["brightness", percent]:
                self._configure(brightness=float(percent))
            case ["strobe", period]:
                duty = self._known().strobe_duty_cycle
                self._strobe(float(period), duty if 0 < duty < 100 else DUTY_DEFAULT)
            case ["strobe", period, duty]:
                self._strobe(float(period), float(duty))
            case ["steady"]:
                self._configure(strobe_period=0.0)
            case ["status"]:
                self._say(str(self._known()))
            case _:
                raise UsageError(USAGE)

    def _known(self) -> Status:
        if self.latest is None:
            raise PharosError("no status of an illuminator has come yet")
        return self.latest

    def _switch(self, on: bool) -> None:
        self._ask(COMMAND_ON_OFF, (float(on),), {"enable": on})

    def _strobe(self, period_s: float, duty: float) -> None:
        self._configure(strobe_period=period_s, strobe_duty_cycle=duty)

    def _configure(self, **settings: float) -> None:
        """These settings; the others as they are."""
        wanted = replace(self._known(), **settings)  # type: ignore[arg-type]
        mode = wanted.mode or MODE_INTERNAL
        strobe = (wanted.strobe_period, wanted.strobe_duty_cycle)
        self._ask(COMMAND_CONFIGURE, (mode, wanted.brightness, *strobe), settings)

    # --- the wire -----------------------------------------------------------------------------
    def _ask(self, command: int, params: tuple[float, ...], then: dict[str, float]) -> None:
        if self.light is None:
            raise PharosError("no illuminator has been heard yet")
        self._asked = Asked(command, params, then)
        self._send(self._asked)

    def _send(self, asked: Asked) -> None:
        assert self.light is not None
        seven = (list(asked.params) + [0.0] * 7)[:7]
        self.mpstate.master(self.light.system).mav.command_long_send(
            self.light.system, self.light.component, asked.command, asked.tries, *seven
        )
        asked.tries += 1
        asked.due = self._clock() + TRY_US / 1e6

    def idle_task(self) -> None:
        asked = self._asked
        if asked is None or self._clock() < asked.due:
            return
        if asked.tries < TRIES:
            self._send(asked)
            return
        self._asked = None
        self._say("the light does not answer")

    def mavlink_packet(self, message: Any) -> None:
        kind = message.get_type()
        if kind in ("ILLUMINATOR_STATUS", f"UNKNOWN_{STATUS_ID}"):
            self._take_status(message)
            return
        source = Target(message.get_srcSystem(), message.get_srcComponent())
        if kind == "HEARTBEAT" and message.type == TYPE_ILLUMINATOR and self.light is None:
            self.light = source
            self._say(f"illuminator {source.system}/{source.component}")
        if kind == "COMMAND_ACK" and source == self.light:
            self._take_answer(int(message.command), int(message.result))

    def _take_status(self, unread: Any) -> None:
        """Where MAVProxy's dialect lacks the message, it has neither fields nor a source, and
        nobody has looked at its checksum."""
        try:
            message = self._reader.decode(bytearray(unread.get_msgbuf()))
        except Exception as error:  # pymavlink's MAVError is another class in each dialect
            self._say(f"ILLUMINATOR_STATUS: {error}")
            return
        if Target(message.get_srcSystem(), message.get_srcComponent()) != self.light:
            return
        self.latest = status_of(message)
        colour = "red" if self.latest.errors else "green" if self.latest.enable else "grey"
        self.mpstate.console.set_status("Light", f"Light {self.latest}", row=1, fg=colour)

    def _take_answer(self, command: int, result: int) -> None:
        asked = self._asked
        if asked is None or asked.command != command or result == IN_PROGRESS:
            return
        self._asked = None
        if result != ACCEPTED:
            self._say(RESULTS.get(result, f"result {result}"))
            return
        if self.latest is not None:  # until the light tells of it itself, within a second
            self.latest = replace(self.latest, **asked.then)  # type: ignore[arg-type]
        self._say("ok")

    def _say(self, text: str) -> None:
        self.mpstate.console.writeln(f"light: {text}")

    def unload(self) -> None:
        self.remove_command("light")
