# SPDX-License-Identifier: Apache-2.0
"""Stands in for the light in tests of the simulator: one UDP wire, and the control socket's
lock-step. Under advance it echoes each datagram, and sends "tick" for each second that passes.

--misbehave silent: reports bytes that it never sends; exit: ends at start with status 3.
"""

from __future__ import annotations

import argparse
import json
import socket
import sys
from typing import Any


class Fake:
    def __init__(self, misbehave: str) -> None:
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.udp.bind(("127.0.0.1", 0))
        self.misbehave = misbehave
        self.now_us = 0
        self.rx = 0
        self.tx = 0
        self.peer: Any = None

    def wires(self) -> dict[str, Any]:
        address = f"udpin:127.0.0.1:{self.udp.getsockname()[1]}"
        return {"uart0": {"address": address, "rx_bytes": self.rx, "tx_bytes": self.tx}}

    def send(self, data: bytes) -> None:
        if self.peer is None:
            return
        self.tx += len(data)
        if self.misbehave != "silent":
            self.udp.sendto(data, self.peer)

    def advance(self, request: dict[str, Any]) -> dict[str, Any]:
        while self.rx < request.get("await", {}).get("uart0", 0):
            data, self.peer = self.udp.recvfrom(4096)
            self.rx += len(data)
            self.send(data)
        before = self.now_us // 1_000_000
        self.now_us += request["us"]
        for _ in range(self.now_us // 1_000_000 - before):
            self.send(b"tick")
        return {"now_us": self.now_us, "wires": self.wires()}

    def answer(self, request: dict[str, Any]) -> dict[str, Any]:
        if request["op"] == "advance":
            return {"ok": True, **self.advance(request)}
        if request["op"] == "wires":
            return {"ok": True, "wires": self.wires()}
        if request["op"] == "quit":
            return {"ok": True}
        return {"ok": False, "error": f"no operation '{request['op']}'"}


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--control")
    parser.add_argument("--misbehave", default="")
    args, _ = parser.parse_known_args()
    if args.misbehave == "exit":
        print("fake: no such wire", file=sys.stderr)
        return 3
    fake = Fake(args.misbehave)
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
        listener.bind(args.control)
        listener.listen()
        with listener.accept()[0].makefile("rw") as control:
            for line in control:
                request = json.loads(line)
                control.write(json.dumps({"id": request["id"], **fake.answer(request)}) + "\n")
                control.flush()
                if request["op"] == "quit":
                    break
    return 0


if __name__ == "__main__":
    sys.exit(main())
