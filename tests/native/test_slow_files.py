# SPDX-License-Identifier: Apache-2.0
"""A trace or a recording that is written more slowly than it comes loses whole lines, and says so.
Real time; the slow disk is a pipe that is not read until the end."""

from __future__ import annotations

import os
import re
import socket
from pathlib import Path

import pytest

from echo_light import Light, Start

pytestmark = pytest.mark.realtime


# More changes than wait in the light and the pipe (344,064 bytes), at three bytes each: those of
# one microsecond share a time mark.
MANY = 130_000


class Pipe:
    """A file that takes 64 KiB and no more, until it is read."""

    def __init__(self, path: Path) -> None:
        os.mkfifo(path)
        self.path = path
        self.fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK)

    def read_to_the_end_of(self, light: Light) -> str:
        os.set_blocking(self.fd, True)
        light.do("quit")
        data = b""
        while more := os.read(self.fd, 1 << 16):
            data += more
        os.close(self.fd)
        return data.decode()


def _toggle(light: Light, times: int) -> None:
    """Each is a change to record, and events to trace."""
    for start in range(0, times, 1000):
        for i in range(start, start + 1000):
            light.send_line(b'{"op":"gpio","line":"sync","value":%d}' % (i % 2))
        for _ in range(1000):
            assert light.read_line()["ok"]


def test_a_recording_says_what_it_lacks(start: Start, tmp_path: Path) -> None:
    pipe = Pipe(tmp_path / "record")
    light = start("--record", str(pipe.path), virtual=False)
    _toggle(light, MANY)
    text = pipe.read_to_the_end_of(light)
    head, *rest = text.split("$comment changes are missing here $end\n")
    assert rest
    assert head.startswith("$version pharos $end\n")
    for part in rest:
        assert re.match(r"#\d+\n\$dumpall\nb[01]+ !\n(?:.+\n)+\$end\n", part)


def test_a_trace_counts_what_it_lacks(start: Start, tmp_path: Path) -> None:
    pipe = Pipe(tmp_path / "trace")
    light = start("--trace", str(pipe.path), "--uart0", "udpin:127.0.0.1:0", virtual=False)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ground:
        ground.connect(light.address("uart0"))
        for sent in range(1, 40_001):
            ground.send(b"x")
            if sent % 2 == 0:
                light.do("hello")
    lines = pipe.read_to_the_end_of(light).splitlines()
    assert all(re.fullmatch(r"\d+ \S+ \S+ -?\d+", line) for line in lines)
    lost = [int(line.split()[3]) for line in lines if line.split()[1] == "lost"]
    assert lost
    assert all(lost)
