# SPDX-License-Identifier: Apache-2.0
"""An independent DroneCAN node, PyPI's dronecan, on a simulated light's bus."""

from __future__ import annotations

import time
from typing import Any

import dronecan
from dronecan import uavcan

from harness import NODE
from parameters import shortest
from pharos import Simulator
from pharos.can_node import BusDriver

PEER = 10
STEP_US = 10_000


class Peer:
    """A node of PyPI's dronecan on the light's bus. Its own clock, the host's, hardly moves."""

    def __init__(self, sim: Simulator, fd: bool = False, node_id: int = PEER) -> None:
        self.sim = sim
        self.node = dronecan.node.Node(
            BusDriver(sim.bus(), lambda: time.monotonic_ns() // 1000),
            node_id=node_id,
            send_canfd=fd,
            catch_handler_exceptions=False,
        )

    def run(self, duration_us: int) -> None:
        for _ in range(0, duration_us, STEP_US):
            self.sim.advance(STEP_US)
            self.node.spin(0)

    def ask(self, request: Any, node_id: int = NODE) -> Any:
        answers: list[Any] = []
        self.node.request(request, node_id, answers.append, priority=20)
        self.run(50_000)
        assert len(answers) == 1, "no answer"
        assert answers[0] is not None, "too late"
        return answers[0].response

    def tell(self, message: Any) -> None:
        self.node.broadcast(message)
        self.run(STEP_US)

    def heard(self, kind: Any) -> list[Any]:
        """Messages of a type from now on."""
        messages: list[Any] = []
        self.node.add_handler(kind, lambda event: messages.append(event.message))
        return messages

    def param(self, name: str, value: float | None = None) -> float:
        """What is in force, after a set if there is a value: an integer or a real as it is."""
        request = uavcan.protocol.param.GetSet.Request()
        request.name.encode(name)
        if isinstance(value, int):
            request.value.integer_value = value
        elif value is not None:
            request.value.real_value = value
        answer = self.ask(request).value
        if dronecan.get_active_union_field(answer) == "real_value":
            return shortest(answer.real_value)
        return int(answer.integer_value)
