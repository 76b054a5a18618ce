# SPDX-License-Identifier: Apache-2.0
"""The parameter part of the table: how long a whole list takes on a simulated wire, in virtual
time, against the time that its bytes alone would take there; and how long the packed file."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "system"))

from ftp_client import FtpClient  # noqa: E402
from pharos import Simulator  # noqa: E402

BAUD = 57_600
BITS_PER_BYTE = 10
STEP_US = 1_000
LIMIT_RATIO = 2.2
PACKED = "@PARAM/param.pck?withdefaults=1"
LIMIT_PACKED = 0.5

Figure = tuple[str, float, str]


def measure(binary: Path, dialect: Any) -> tuple[list[Figure], float, float]:
    """Figures, and the ratios that have targets: the list over its bytes, and the packed file over
    the list. Heartbeats and status go on meanwhile."""
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
        client.pass_time(2_000_000)
        begin_us = sim.now_us()
        ftp = FtpClient(client)
        session, length = ftp.open(PACKED)
        packed = sum(part.size for part in ftp.burst(session))
        if packed != length:
            raise SystemExit(f"bench: {packed} of {length} bytes of the packed parameters")
        packed_s = (sim.now_us() - begin_us) / 1e6
    payload = len(request.get_msgbuf()) + sum(seen.values())
    wire_s = payload * BITS_PER_BYTE / BAUD
    figures = [
        (f"parameters: list of {count} at {BAUD} baud", took_s, "s"),
        ("parameters: their bytes alone", wire_s, "s"),
        ("parameters: packed in a file", packed_s, "s"),
    ]
    return figures, took_s / wire_s, packed_s / took_s
