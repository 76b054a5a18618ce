# SPDX-License-Identifier: Apache-2.0
"""Who has no key, and what they try: nothing of it may have an effect, or an answer."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING, Any

from parties import MOUNT, ON_OFF, REBOOT, REQUEST_MESSAGE, STAMP, STATUS, Party

if TYPE_CHECKING:
    from light import Light

REAL32 = 9  # MAV_PARAM_TYPE
RECENT_US = 3_000_000


class Attacker:
    def __init__(self, dialect: Any) -> None:
        self.d = dialect
        self.stranger = Party(dialect, 66, 190)
        self.thief = Party(dialect, 255, 190, bytes(32 * [7]))  # as the owner, with another key

    def attack(self, light: Light, how: str) -> None:
        if how == "replay":
            self._replay(light)
        elif how == "imc":
            if light.imc is not None:  # beside a key IMC may look, no more
                light.imc.send("SetLedBrightness", name="lamp", value=255)
                light.advance(0)
        else:
            light.send(*self._deed(light, how))

    def pretend(self, light: Light) -> None:
        """To be the vehicle and its station, at every second, as strangers on a network are."""
        for party, message in (
            (self.stranger, self.stranger.station()),
            (Party(self.d, 77, 1), self.stranger.autopilot()),
        ):
            light.links["uart0"].send(party.frame(message, 0))

    def _deed(self, light: Light, how: str) -> tuple[Party, Any]:
        d, stranger = self.d, self.stranger
        here = light.address
        gimbal = (here[0], 154)
        deeds: dict[str, tuple[Party, Any]] = {
            "on": (stranger, stranger.command(ON_OFF, 1.0, to=here)),
            "off": (stranger, stranger.command(ON_OFF, 0.0, to=here)),
            "autopilot": (Party(d, 77, 1), stranger.autopilot()),
            "station": (stranger, stranger.station()),
            "setup": (stranger, d.MAVLink_setup_signing_message(*here, [0] * 32, STAMP)),
            "parameter": (
                stranger,
                d.MAVLink_param_set_message(*here, b"THR_SHUTDOWN", 149.0, REAL32),
            ),
            "reboot": (stranger, stranger.command(REBOOT, 1.0, to=here)),
            "point": (
                stranger,
                stranger.command(MOUNT, 30.0, 0.0, 30.0, 0.0, 0.0, 0.0, 2.0, to=gimbal),
            ),
            "status": (stranger, stranger.command(REQUEST_MESSAGE, STATUS, to=here)),
            "other-key": (self.thief, self.thief.command(ON_OFF, 1.0, to=here)),
        }
        return deeds[how]

    def _replay(self, light: Light) -> None:
        """A frame that certainly arrived, and later ones of its stream as well."""
        now_us = light.now_us()
        old = [
            frame
            for at_us, frame in light.recorded
            if now_us - at_us > RECENT_US and at_us > light.oracle.around.up_us
        ]
        if old and light.is_sure() and not light.is_silent:
            light.links["uart0"].send(random.Random(now_us).choice(old))
            light.advance(0)
