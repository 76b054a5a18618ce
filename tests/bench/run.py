# SPDX-License-Identifier: Apache-2.0
"""`make bench`: one table, from one run, on the machine it names.

Servers are measured in turn, round after round, so that whatever else the machine does meets all of
them alike; ratios are taken within a round, and the median over the rounds is shown.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import platform
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "host" / "src"))

import can_bus
import imc_codec
import param_list

from pharos import Simulator, find_dialect, load_dialect
from pharos.control import ControlClient

ROOT = Path(__file__).resolve().parents[2]
COMMAND_LONG = 76
COMMAND_ACK = 77
WINDOW = 32
KEY = bytes(range(32))
# Of signed commands, in units of 10 µs, an hour apart, from a day after the stored one on.
timestamps = itertools.count(86_400 * 100_000, 3600 * 100_000)
DAY_S = 86_400
START_TIMEOUT_S = 20.0

# Targets, as the issue sets them.
P50_RATIO_MAX = 1.25
RATE_OVER_PYMAVLINK_MIN = 5.0
RATE_OVER_ECHO_MIN = 0.7
SWITCH_US_MAX = 0.3
DAY_S_MAX = 5.0
RESIDENT_MB_MAX = 4.0


@dataclass(frozen=True)
class Row:
    """One line of the table. `met` is None where there is no target."""

    what: str
    value: float
    unit: str
    target: str = ""
    met: bool | None = None


@dataclass(frozen=True)
class Server:
    name: str
    port: int
    peer_port: int  # where its client speaks from, each time
    answer: int  # the message id that counts as an answer
    pid: int
    is_signed: bool = False  # has KEY, so commands must be signed


@dataclass
class Samples:
    p50_us: list[float]
    p99_us: list[float]
    rate: list[float]
    lost: int = 0


def at_most(what: str, value: float, unit: str, limit: float) -> Row:
    return Row(what, value, unit, f"≤ {limit:g}", value <= limit)


def at_least(what: str, value: float, unit: str, limit: float) -> Row:
    return Row(what, value, unit, f"≥ {limit:g}", value >= limit)


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


# --- servers --------------------------------------------------------------------------------------
@contextmanager
def printing_its_port(name: str, answer: int, *command: str | Path) -> Iterator[Server]:
    process = subprocess.Popen([str(c) for c in command], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield Server(name, int(process.stdout.readline()), free_port(), answer, process.pid)
    finally:
        process.kill()
        process.wait()


def store_key(binary: Path, settings: Path) -> None:
    """Has a light store KEY, typed at its shell."""
    wires = {"uart0": "udpin:127.0.0.1:0", "console": "pty:{folder}/shell"}
    with Simulator(binary, wires, options=["--settings", str(settings)]) as sim:
        console = sim.open("console")
        console.send(b"signing key\r" + KEY.hex().encode() + b"\r")
        sim.advance(2_000_000)
        if b"signing is on" not in b"".join(console.take()):
            raise SystemExit("bench: the light took no key")


@contextmanager
def pharos(binary: Path, is_signed: bool = False) -> Iterator[Server]:
    """The light in real time, listening over UDP."""
    with tempfile.TemporaryDirectory(prefix="pharos-") as folder:
        control = Path(folder) / "control"
        settings = Path(folder) / "settings"
        if is_signed:
            store_key(binary, settings)
        process = subprocess.Popen(
            [str(binary), "--control", str(control), "--uart0", "udpin:127.0.0.1:0",
             "--console", "none", "--settings", str(settings)],
            stdin=subprocess.DEVNULL,
            cwd=folder,
        )  # fmt: skip
        try:
            address = first_reply(process, control)["wires"]["uart0"]["address"]
            port = int(address.rpartition(":")[2])
            name = "pharos, signed" if is_signed else "pharos"
            yield Server(name, port, free_port(), COMMAND_ACK, process.pid, is_signed)
        finally:
            process.kill()
            process.wait()


def first_reply(process: subprocess.Popen[bytes], control: Path) -> dict[str, Any]:
    end = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < end:
        try:
            client = ControlClient(str(control))
        except OSError:
            try:
                raise SystemExit(f"bench: the light ended with {process.wait(0.01)}")
            except subprocess.TimeoutExpired:
                continue
        reply = client.request("wires")
        client.close()
        return reply
    raise SystemExit("bench: the light opened no control socket")


# --- measurements ---------------------------------------------------------------------------------
def client(tools: Path, mode: str, server: Server, *arguments: object) -> list[float]:
    """Server and client each have a processor of their own, where there are two: otherwise the
    figures depend on where the kernel happens to put them."""
    processors = sorted(os.sched_getaffinity(0))
    own, other = processors[-1], processors[0]
    os.sched_setaffinity(server.pid, {other})
    words = [mode, server.peer_port, server.port, server.answer, *arguments]
    if server.is_signed:
        # Later than all that was sent before: each run signs fewer than in an hour.
        words += [KEY.hex(), next(timestamps)]
    output = subprocess.run(
        [str(tools / "bench_client"), *map(str, words)],
        check=True,
        preexec_fn=lambda: os.sched_setaffinity(0, {own}),
        capture_output=True,
        text=True,
    ).stdout
    return [float(word) for word in output.split()]


def command_frame(dialect: Any, is_signed: bool = False) -> str:
    codec = dialect.MAVLink(None, 255, 190)
    codec.signing.secret_key = KEY
    codec.signing.sign_outgoing = is_signed
    message = dialect.MAVLink_command_long_message(1, 243, 405, 0, 1, 0, 0, 0, 0, 0, 0)
    return str(bytes(message.pack(codec)).hex())


def measure_servers(
    args: argparse.Namespace, servers: Sequence[Server], dialect: Any
) -> dict[str, Samples]:
    samples = {server.name: Samples([], [], []) for server in servers}
    for round_ in range(args.rounds):
        # Each round begins with another server.
        order = [servers[(round_ + i) % len(servers)] for i in range(len(servers))]
        for server in order:
            found = samples[server.name]
            frame = command_frame(dialect, server.is_signed)
            p50, p99, lost = client(args.tools, "latency", server, args.pings, frame, 1)
            found.p50_us.append(p50 / 1e3)
            found.p99_us.append(p99 / 1e3)
            found.lost += int(lost)
        for server in order:
            found = samples[server.name]
            frame = command_frame(dialect, server.is_signed)
            rate, lost = client(args.tools, "rate", server, args.commands, frame, WINDOW)
            found.rate.append(rate)
            found.lost += int(lost)
    return samples


def ratio(ours: Sequence[float], theirs: Sequence[float]) -> float:
    """Median of the rounds' ratios."""
    return statistics.median(a / b for a, b in zip(ours, theirs, strict=True))


def server_rows(samples: dict[str, Samples]) -> list[Row]:
    rows = []
    for name, found in samples.items():
        rows += [
            Row(f"{name}: command→ACK p50", statistics.median(found.p50_us), "µs"),
            Row(f"{name}: command→ACK p99", statistics.median(found.p99_us), "µs"),
            Row(
                f"{name}: ACKs per second, {WINDOW} in flight", statistics.median(found.rate), "/s"
            ),
            Row(f"{name}: answers lost", found.lost, "", "≤ 0", found.lost == 0),
        ]
    light, echo, responder = (samples[n] for n in ("pharos", "UDP echo", "pymavlink"))
    signed = samples["pharos, signed"]
    return [
        *rows,
        at_most("p50, pharos / UDP echo", ratio(light.p50_us, echo.p50_us), "×", P50_RATIO_MAX),
        at_least(
            "ACKs per second, pharos / UDP echo",
            ratio(light.rate, echo.rate),
            "×",
            RATE_OVER_ECHO_MIN,
        ),
        at_least(
            "ACKs per second, pharos / pymavlink",
            ratio(light.rate, responder.rate),
            "×",
            RATE_OVER_PYMAVLINK_MIN,
        ),
        Row("p50, signed / unsigned", ratio(signed.p50_us, light.p50_us), "×"),
        Row("ACKs per second, signed / unsigned", ratio(signed.rate, light.rate), "×"),
    ]


def resident_mb(pid: int) -> float:
    status = Path(f"/proc/{pid}/status").read_text()
    found = re.search(r"^VmRSS:\s+(\d+) kB", status, re.MULTILINE)
    if found is None:
        raise SystemExit(f"bench: process {pid} tells no VmRSS")
    return int(found[1]) / 1024


def measure_day(binary: Path, dialect: Any) -> list[Row]:
    """A day of strobe at 10 Hz, both streams sent over UDP, thermal supervision."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        sock.settimeout(START_TIMEOUT_S)
        wire = f"udpout:127.0.0.1:{sock.getsockname()[1]}"
        with Simulator(binary, {"uart0": wire}, dialect=dialect) as sim:
            sim.request("advance", us=1_000_000)
            peer = sock.recvfrom(2048)[1]
            codec = dialect.MAVLink(None, 255, 190)
            sent = 0
            for command, params in ((406, (1, 50, 0.1, 50)), (405, (1, 0, 0, 0))):
                message = dialect.MAVLink_command_long_message(1, 243, command, 0, *params, 0, 0, 0)
                sent += sock.sendto(message.pack(codec), peer)
            before = sim.request("advance", us=1_000_000, **{"await": {"uart0": sent}})
            changes = sim.outputs()["changes"]
            begin = time.monotonic()
            after = sim.request("advance", us=DAY_S * 1_000_000)
            took = time.monotonic() - begin
            edges = sim.outputs()["changes"] - changes
    datagrams = after["wires"]["uart0"]["tx_datagrams"] - before["wires"]["uart0"]["tx_datagrams"]
    # What is measured must have happened: two edges a period; a heartbeat and a status a second.
    if edges != DAY_S * 20 or datagrams < DAY_S * 2:
        raise SystemExit(f"bench: {edges} edges and {datagrams} datagrams in a simulated day")
    return [
        at_most("a simulated day", took, "s", DAY_S_MAX),
        Row("simulated seconds per second", DAY_S / took, "×"),
    ]


def measure_switch(tools: Path) -> Row:
    """The kernel's own benchmark prints nanoseconds per switch."""
    output = subprocess.run(
        [str(tools / "switch"), "--time", "virtual", "--console", "none"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    found = re.search(r"([\d.]+)\s*ns", output)
    if found is None:
        raise SystemExit(f"bench: no '… ns' in what switch printed: {output!r}")
    return at_most("context switch", float(found[1]) / 1e3, "µs", SWITCH_US_MAX)


def measure_parse(tools: Path, dialect: Any) -> Row:
    """A mixed stream through the framer: commands, heartbeats, attitudes, parameters."""
    codec = dialect.MAVLink(None, 1, 1)
    messages = [
        dialect.MAVLink_command_long_message(1, 243, 405, 0, 1, 0, 0, 0, 0, 0, 0),
        dialect.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3),
        dialect.MAVLink_attitude_message(12345, 0.1, -0.2, 1.5, 0.01, 0.02, 0.03),
        dialect.MAVLink_param_value_message(b"LIGHT_BRIGHT", 42.0, 9, 100, 7),
        dialect.MAVLink_global_position_int_message(1, 2, 3, 4, 5, 6, 7, 8, 9),
    ]
    stream = bytearray()
    while len(stream) < 1 << 20:
        for message in messages:
            stream += message.pack(codec)
            codec.seq = (codec.seq + 1) % 256
    with tempfile.NamedTemporaryFile(prefix="pharos-stream-") as file:
        file.write(stream)
        file.flush()
        output = subprocess.run(
            [str(tools / "parse"), file.name, "200"], check=True, capture_output=True, text=True
        ).stdout
    return Row("MAVLink parse rate", float(output.split()[0]), "MB/s")


def measure_command(tools: Path) -> list[Row]:
    """What a command costs without sockets and threads, and what signatures add to it."""
    output = subprocess.run(
        [str(tools / "command"), "1000000"], check=True, capture_output=True, text=True
    ).stdout
    plain, signed = (float(word) / 1e3 for word in output.split())
    return [
        Row("command and ACK in the endpoint, CPU", plain, "µs"),
        Row("the same, both signed", signed, "µs"),
        Row("CPU in the endpoint, signed / unsigned", signed / plain, "×"),
    ]


# --- the table ------------------------------------------------------------------------------------
def machine() -> str:
    text = Path("/proc/cpuinfo").read_text()
    found = re.search(r"^(?:model name|Model)\s*:\s*(.+)$", text, re.MULTILINE)
    model = found[1] if found else platform.machine()
    return f"{model}, {os.cpu_count()} CPUs, {platform.system()} {platform.release()}"


def show(rows: Sequence[Row]) -> None:
    width = max(len(row.what) for row in rows)
    print(f"{'':<{width}}  {'value':>12}       {'target':>8}  met")
    for row in rows:
        number = f"{row.value:,.0f}" if abs(row.value) >= 1000 else f"{row.value:.3g}"
        met = {None: "", True: "yes", False: "NO"}[row.met]
        print(f"{row.what:<{width}}  {number:>12} {row.unit:<5} {row.target:>8}  {met}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "native")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--pings", type=int, default=10_000, help="of a round, one at a time")
    parser.add_argument("--commands", type=int, default=100_000, help="of a round, pipelined")
    parser.add_argument("--json", type=Path, help="also write the results there")
    args = parser.parse_args()
    args.tools = args.build / "tests" / "bench"
    binary = args.build / "pharos"
    if not binary.is_file():
        parser.error(f"{binary}: no such file; run `make build`")
    dialect_path = find_dialect(args.build)
    dialect = load_dialect(dialect_path)

    with ExitStack() as stack:
        echo = printing_its_port("UDP echo", COMMAND_LONG, args.tools / "udp_echo")
        script = Path(__file__).with_name("pymavlink_responder.py")
        responder = printing_its_port(
            "pymavlink", COMMAND_ACK, sys.executable, script, dialect_path
        )
        light = stack.enter_context(pharos(binary))
        signed = stack.enter_context(pharos(binary, is_signed=True))
        servers = [stack.enter_context(echo), light, signed, stack.enter_context(responder)]
        rows = server_rows(measure_servers(args, servers, dialect))
        rows.append(at_most("resident memory", resident_mb(light.pid), "MB", RESIDENT_MB_MAX))
    rows.append(measure_switch(args.tools))
    rows += measure_day(binary, dialect)
    rows.append(measure_parse(args.tools, dialect))
    rows += measure_command(args.tools)
    figures, of_bytes, of_list = param_list.measure(binary, dialect)
    rows += [Row(*figure) for figure in figures]
    rows.append(at_most("parameters: list / bytes", of_bytes, "×", param_list.LIMIT_RATIO))
    rows.append(at_most("parameters: packed / list", of_list, "×", param_list.LIMIT_PACKED))
    figures, ratio_of_imcpy = imc_codec.measure(args.tools)
    rows += [Row(*figure) for figure in figures]
    if ratio_of_imcpy is not None:
        rows.append(at_least("IMC in, imcpy / pharos", ratio_of_imcpy, "×", imc_codec.LIMIT_RATIO))
    rows += [Row(*figure) for figure in can_bus.measure(binary, dialect)]

    print(machine())
    show(rows)
    if args.json:
        result = {"machine": machine(), "rows": [asdict(row) for row in rows]}
        args.json.write_text(json.dumps(result, indent=2, ensure_ascii=False) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
