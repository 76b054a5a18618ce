# SPDX-License-Identifier: Apache-2.0
"""What imcpy's actor hears of a light: a program of its own, since it runs for ever.

Prints a line for each Heartbeat and EntityState of the light; it asks for the latter every
second."""

from __future__ import annotations

import contextlib
from typing import Any

import imcpy
from imcpy.actors.dynamic import DynamicActor
from imcpy.decorators import Periodic, Subscribe

LIGHT = "pharos-light"


class Actor(DynamicActor):  # type: ignore[misc]
    def __init__(self) -> None:
        super().__init__(imc_id=0x3334)
        self.heartbeat.append(LIGHT)

    def _print(self, message: Any) -> None:
        with contextlib.suppress(KeyError):
            if self.resolve_node_id(message).sys_name == LIGHT:
                print(f"{message.msg_name} of {LIGHT}", flush=True)

    @Subscribe(imcpy.Heartbeat)  # type: ignore[untyped-decorator]
    def on_heartbeat(self, message: Any) -> None:
        self._print(message)

    @Subscribe(imcpy.EntityState)  # type: ignore[untyped-decorator]
    def on_state(self, message: Any) -> None:
        self._print(message)

    @Periodic(1)  # type: ignore[untyped-decorator]
    def ask(self) -> None:
        with contextlib.suppress(KeyError):
            self.send(LIGHT, imcpy.QueryEntityState())


if __name__ == "__main__":
    Actor().run()
