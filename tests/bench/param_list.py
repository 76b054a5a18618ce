# SPDX-License-Identifier: Apache-2.0
"""The parameter part of the table: how long a whole list takes on a simulated wire, in virtual
time, against the time that its bytes alone would take there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pharos import Simulator

BAUD = 57_600
BITS_PER_BYTE = 10
STEP_US = 1_000
LIMIT_RATIO = 2.5

Figure = tuple[str, float, str]


def measure(binary: Path, dialect: Any) -> tuple[list[Figure], float]:
    """Figures, and the ratio that has a target. Heartbeats and status go on meanwhile."""
    wires = {"uart0": f"udpin:127.0.0.1:0,paced,baud={BAUD}"}
    with Simulator(binary, wires, dialect=dialect) as sim:
        client = sim.connect("uart0")
        client.heartbeat()
        client.pass_time(2_000_000)
        begin_us = sim.now_us()
        request = dialect.MAVLink_param_request_list_message(1, 243)
        client.send(request)
        seen: dict[int, int] = {}
        count = 1
        while len(seen) < count:
            for message in client.pass_time(STEP_US):
                if message.get_type() == "PARAM_VALUE":
                    seen[message.param_index] = len(message.get_msgbuf())
                    count = message.param_count
            if sim.now_us() - begin_us > 60_000_000:
                raise SystemExit(f"bench: {len(seen)} of {count} parameters in a minute")
        took_s = (sim.now_us() - begin_us) / 1e6
    payload = len(request.get_msgbuf()) + sum(seen.values())
    wire_s = payload * BITS_PER_BYTE / BAUD
    figures = [
        (f"parameters: list of {count} at {BAUD} baud", took_s, "s"),
        ("parameters: their bytes alone", wire_s, "s"),
    ]
    return figures, took_s / wire_s
