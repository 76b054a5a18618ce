# SPDX-License-Identifier: Apache-2.0
"""The user-space CAN bus in other people's programs: python-can's tools and PyPI's dronecan."""

from __future__ import annotations

import csv
import os
import re
import signal
import socket
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import can
import dronecan
import pytest
from dronecan import uavcan

from pharos.can_udp import PharosUdpBus, parse_channel
from real_light import BINARY, PATIENCE_S, RealLight, environment, wait_for

FRAMES = [
    can.Message(arbitration_id=0x123, is_extended_id=False, data=b"\x01\x02"),
    can.Message(arbitration_id=0x1FFFFFFF, data=b"12345678"),
    can.Message(arbitration_id=0x18042E0A, data=bytes.fromhex("000100C0")),
    *(can.Message(arbitration_id=number, data=bytes([number])) for number in range(1, 20)),
]
LAST = can.Message(arbitration_id=0x7F, is_extended_id=False)
# The formats that can_player reads back; text is for people.
FORMATS = ["asc", "blf", "csv", "db", "log", "trc"]


@pytest.fixture(params=["group", "broadcast"])
def channel(request: pytest.FixtureRequest) -> Iterator[str]:
    """A bus of the test's own, on a port that is kept for it."""
    host = {"group": "239.65.82.5", "broadcast": "127.255.255.255"}[request.param]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as kept:
        kept.bind(("127.0.0.1", 0))
        yield f"{host}:{kept.getsockname()[1]}"


def tool(name: str, *args: str) -> list[str]:
    return [sys.executable, "-m", f"can.{name}", *args]


def has_read_all(channel: str) -> bool:
    """Whether nothing waits in any socket on that bus."""
    host, port = parse_channel(channel)[1]
    number = int.from_bytes(socket.inet_aton(host), sys.byteorder)
    rows = [line.split() for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
    waiting = [row[4].partition(":")[2] for row in rows if row[1] == f"{number:08X}:{port:04X}"]
    return bool(waiting) and all(int(size, 16) == 0 for size in waiting)


@contextmanager
def logger(channel: str, path: Path) -> Iterator[None]:
    """can_logger, from when it hears the bus until it has written all that went over it."""
    process = subprocess.Popen(
        tool("logger", "-i", "pharos-udp", "-c", channel, "-f", str(path)),
        stdout=subprocess.PIPE,
        env=environment() | {"PYTHONUNBUFFERED": "1"},
    )
    assert process.stdout is not None
    try:
        assert b"PharosUdpBus" in process.stdout.readline()
        yield
        wait_for(lambda: has_read_all(channel), "the logger's reading")
    finally:
        process.send_signal(signal.SIGINT)
        process.stdout.close()
        assert process.wait(PATIENCE_S) == 0


def log(channel: str, path: Path) -> None:
    with PharosUdpBus(channel) as bus, logger(channel, path):
        # The one that is being written when the logger is told to end may not be.
        for frame in [*FRAMES, LAST]:
            bus.send(frame)
        while bus.recv(0) is not None:
            pass


def same(frames: list[can.Message]) -> bool:
    return len(frames) == len(FRAMES) and all(
        got.equals(frame, timestamp_delta=None, check_channel=False, check_direction=False)
        for got, frame in zip(frames, FRAMES, strict=True)
    )


@pytest.mark.realtime
@pytest.mark.parametrize("kind", FORMATS)
def test_what_is_logged_is_played_back(channel: str, tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"a.{kind}"
    log(channel, path)
    with PharosUdpBus(channel) as bus:
        played = subprocess.run(
            tool("player", "-i", "pharos-udp", "-c", channel, "--ignore-timestamps", str(path)),
            env=environment(),
            capture_output=True,
            timeout=PATIENCE_S,
            check=True,
        )
        assert b"Traceback" not in played.stderr
        heard = list(iter(lambda: bus.recv(0), None))
    assert same([frame for frame in heard if frame.arbitration_id != LAST.arbitration_id])


@pytest.mark.realtime
def test_log_for_people_has_a_line_a_frame(channel: str, tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    log(channel, path)
    lines = path.read_text().splitlines()
    assert len(lines) >= len(FRAMES)
    assert re.search(r"ID: +123 +S Rx +DL: +2 +01 02", lines[0])
    assert parse_channel(channel)[0] in lines[0]


@pytest.mark.realtime
def test_a_log_is_converted(channel: str, tmp_path: Path) -> None:
    """What can-utils reads too: the channel is one word."""
    path, table = tmp_path / "a.log", tmp_path / "b.csv"
    log(channel, path)
    assert all(len(line.split()) == 4 for line in path.read_text().splitlines())
    subprocess.run(tool("logconvert", str(path), str(table)), check=True, timeout=PATIENCE_S)
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["arbitration_id"], 16) for row in rows][: len(FRAMES)] == [
        frame.arbitration_id for frame in FRAMES
    ]


@pytest.mark.realtime
def test_a_short_channel_is_that_bus(tmp_path: Path) -> None:
    """Reads only what it sent itself: the bus is everybody's."""
    path = tmp_path / "a.log"
    mark = os.getpid() << 8
    with PharosUdpBus("231") as bus, logger("231", path):
        for number in range(10):
            bus.send(can.Message(arbitration_id=mark & 0x1FFFFF00 | number))
        while bus.recv(0) is not None:
            pass
    assert path.read_text().count(f" pharos-udp/231 {mark & 0x1FFFFF00:08X}"[:-2]) >= 9


# --- PyPI's dronecan ------------------------------------------------------------------------------
@pytest.mark.realtime
def test_a_node_of_dronecan_works_on_it(real_light: Callable[..., RealLight], channel: str) -> None:
    """Through its python-can driver, which flushes after each frame."""
    real_light("--can0", f"udp:{channel}")
    node = dronecan.make_node(channel, bustype="pharos-udp", bitrate=1_000_000, node_id=100)
    heard: set[int] = set()
    names: list[str] = []
    node.add_handler(
        uavcan.protocol.NodeStatus, lambda event: heard.add(event.transfer.source_node_id)
    )

    def spin() -> bool:
        node.spin(1)
        return bool(heard)

    try:
        wait_for(spin, "the light's NodeStatus")
        (light,) = heard

        def ask() -> bool:
            node.request(
                uavcan.protocol.GetNodeInfo.Request(),
                light,
                lambda event: names.append(str(event.response.name)) if event else None,
            )
            node.spin(1)
            return bool(names)

        wait_for(ask, "its answer")
    finally:
        node.close()
    assert names[0].startswith("org.pharos")


# In a network of its own that has loopback and the route, and nothing else.
# Root may need no name space of users, and cannot have one in a chroot.
UNSHARE = ["unshare", "-n"] if os.geteuid() == 0 else ["unshare", "-rn"]
ALONE = 'ip link set lo up && ip route add 239.65.82.0/24 dev lo && exec "$@"'
UPDATE = """
    import sys, time
    import dronecan
    from dronecan import uavcan
    from dronecan.app.file_server import FileServer

    Begin = uavcan.protocol.file.BeginFirmwareUpdate
    node = dronecan.make_node("mcast:0", node_id=100)
    files = FileServer(node, [sys.argv[1]])
    uptimes, answers = [], []

    def on_status(event):
        uptimes.append(event.message.uptime_sec)
        if not answers:
            request = Begin.Request(source_node_id=100)
            request.image_file_remote_path.path = "new.bin"
            node.request(request, event.transfer.source_node_id,
                         lambda event: answers.append(event.response.error) if event else None)

    node.add_handler(uavcan.protocol.NodeStatus, on_status)
    end = time.monotonic() + 60
    while time.monotonic() < end and sorted(uptimes) == uptimes:
        node.spin(0.1)
    print(answers, "restarted" if sorted(uptimes) != uptimes else uptimes)
"""


@pytest.mark.realtime
def test_firmware_comes_over_the_bus_of_dronecans_tools(binary: Path, tmp_path: Path) -> None:
    """`--can0 udp` is their `mcast:0`, as docs/firmware-update.md has it."""
    code, image = tmp_path / "code", tmp_path / "new.bin"
    code.write_bytes(bytes(1000))
    sign = ["-m", "imgtool.main", "sign", "--version", "1.2.3", "--header-size", "0x200"]
    sign += ["--pad-header", "--slot-size", "229376", "--align", "8", str(code), str(image)]
    subprocess.run([sys.executable, *sign], check=True, capture_output=True)
    light = f"{BINARY} --can0 udp --flash {tmp_path}/flash --console none & "
    script = textwrap.dedent(UPDATE)
    (tmp_path / "update.py").write_text(f"if True:\n{textwrap.indent(script, '    ')}")
    done = subprocess.run(
        [*UNSHARE, "sh", "-c", ALONE, "sh", "sh", "-c", light + '"$@"; kill $!', "sh"]
        + [sys.executable, str(tmp_path / "update.py"), str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=90,
        check=True,
    )
    assert done.stdout == "[0] restarted\n", done.stderr
    assert "no route" not in done.stderr


@pytest.mark.realtime
def test_a_host_without_the_route_is_told_the_command(binary: Path) -> None:
    # In the foreground `timeout` signals the light alone: told twice, it can lose the process
    # that looks for leaks at its end, and wait for that for ever.
    light = f"timeout --foreground 1 {binary} --can0 udp --console none"
    done = subprocess.run(
        [*UNSHARE, "sh", "-c", f"ip link set lo up; {light}"],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    (line,) = [line for line in done.stderr.splitlines() if "no route" in line]
    assert line.endswith("ip route add 239.65.82.0/24 dev lo")
