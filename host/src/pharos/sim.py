# SPDX-License-Identifier: Apache-2.0
"""Runs the native light under virtual time and drives it in lock-step.

The light's time stands still until advance(). An advance first names how many bytes were sent to
each wire, so the light waits for exactly these; its reply names how many it sent back, so this side
reads exactly those. Nothing depends on how fast the host is.
"""

from __future__ import annotations

import contextlib
import random
import shlex
import socket
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .connection import MavlinkConnection, Source, Target
from .control import ControlClient
from .dialect import find_dialect, load_dialect
from .errors import RefusedError, SimulatorError
from .link import Link, Port, TcpLink, TerminalLink, UdpLink, parse_address

if TYPE_CHECKING:
    from .can_node import CanPort, DronecanNode
    from .imc import DatagramLink, ImcPeer

START_TIMEOUT_S = 20.0
# How long a light may take to end in order before it is killed.
STOP_TIMEOUT_S = 2.0
# Bounds of one advance while links are attached, so that what the light sends always fits in the
# host's buffers: a pty's is the smallest, 4 KiB.
CHUNK_MIN_US = 100_000
CHUNK_MAX_US = 20_000_000
CHUNK_START_US = 1_000_000
CHUNK_BYTES = 1024
# The first of eight UDP ports each, below those that Linux gives to who asks for any.
RESERVED_PORTS = range(20_000, 32_000, 8)
# Changes of the output that one reply may list.
EDGES_MAX = 10_000


@dataclass(frozen=True)
class Wire:
    """One wire as the light sees it: where it is, and its totals since the process started."""

    name: str
    address: str
    rx_bytes: int
    tx_bytes: int


@dataclass(frozen=True)
class Edge:
    """One change of the lamp's output: when, and to which level (parts per million of full)."""

    time_us: int
    level_ppm: int


@dataclass(frozen=True)
class Tunnel:
    """How a client reaches the light over CAN: the light's node, its own, the serial id, CAN FD."""

    node: int = 68
    own: int = 10
    serial: int = 0
    fd: bool = False


@dataclass
class _Attached:
    port: Port
    rx_before: int
    tx_before: int


class Simulator:
    """The native light as a subprocess. A context manager; leaving it ends the process.

    wires: {"uart0": "udpin:127.0.0.1:0", "can0": "udp:127.255.255.255:{port}", …}; options: further
    command line arguments. In both, {folder} becomes a folder, {port} a UDP port of its own.
    Any failure of the light is a SimulatorError that says how to replay it.
    """

    def __init__(
        self,
        binary: str | Path,
        wires: Mapping[str, str] | None = None,
        *,
        seed: int = 1,
        options: Sequence[str] = (),
        dialect: Any = None,
    ) -> None:
        self.binary = Path(binary)
        self.seed = seed
        self._folder = tempfile.TemporaryDirectory(prefix="pharos-")
        self.folder = Path(self._folder.name)
        self.dialect = dialect
        self.command = [
            str(self.binary),
            *("--time", "virtual", "--seed", str(seed)),
            *("--control", str(self.folder / "control")),
        ]
        self._reservation: socket.socket | None = None
        for name, wire in (wires or {}).items():
            self.command += [f"--{name}", self._fill_in(wire)]
        self.command += [self._fill_in(option) for option in options]
        self._attached: dict[str, _Attached] = {}
        self._buses: dict[str, CanPort] = {}
        self._clients: dict[str, list[MavlinkConnection]] = {}
        self._chunk_us = CHUNK_START_US
        self._now_us = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._control: ControlClient | None = None

    def _fill_in(self, text: str) -> str:
        if "{port}" in text:
            text = text.replace("{port}", str(self._reserve_port()))
        return text.replace("{folder}", str(self.folder))

    def _reserve_port(self) -> int:
        """A port for a bus on loopback's broadcast address, and those behind it for IMC's
        announcements. Binding another address of the host keeps it from being handed out again;
        the kernel gives none of these to who asks for any port."""
        if self._reservation is None:
            self._reservation = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            for port in random.SystemRandom().sample(RESERVED_PORTS, len(RESERVED_PORTS)):
                with contextlib.suppress(OSError):
                    self._reservation.bind(("127.0.0.1", port))
                    return port
            raise SimulatorError("no UDP port is free")
        return int(self._reservation.getsockname()[1])

    # --- the process --------------------------------------------------------------------------
    def start(self) -> Simulator:
        console = (self.folder / "console").open("wb")
        with console:
            try:
                self._process = subprocess.Popen(
                    self.command,
                    stdin=subprocess.DEVNULL,
                    stdout=console,
                    stderr=subprocess.STDOUT,
                    cwd=self.folder,
                )
            except OSError as error:
                raise SimulatorError(f"{self.binary}: {error.strerror}: `make build`?") from error
        try:
            self._control = self._connect()
        except BaseException:
            self.stop()
            raise
        return self

    def _connect(self) -> ControlClient:
        path = str(self.folder / "control")
        assert self._process is not None
        for _ in range(int(START_TIMEOUT_S / 0.005)):
            try:
                return ControlClient(path)
            except OSError:
                pass
            try:
                status = self._process.wait(timeout=0.005)
            except subprocess.TimeoutExpired:
                continue
            raise SimulatorError(f"the light ended with {status} at start{self.replay()}")
        raise SimulatorError(f"the light opened no control socket{self.replay()}")

    def stop(self) -> None:
        """Ends the process and closes every link."""
        for attached in self._attached.values():
            attached.port.close()
        self._attached.clear()
        self._buses.clear()
        if self._reservation is not None:
            self._reservation.close()
            self._reservation = None
        if self._control is not None:
            self._control.close()
        if self._process is not None and self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(timeout=STOP_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def quit(self, timeout_s: float = 10.0) -> int:
        """Asks the light to end; its exit status."""
        assert self._process is not None
        self.request("quit")
        try:
            return self._process.wait(timeout=timeout_s)
        except subprocess.TimeoutExpired as error:
            raise SimulatorError(f"the light did not quit{self.replay()}") from error

    def __enter__(self) -> Simulator:
        return self.start()

    def __exit__(self, *_exc: object) -> None:
        self.stop()
        self._folder.cleanup()

    @property
    def pid(self) -> int:
        assert self._process is not None
        return self._process.pid

    def console(self) -> str:
        """What the light printed so far."""
        path = self.folder / "console"
        return path.read_text(errors="replace") if path.exists() else ""

    def replay(self) -> str:
        """How to get here again: the command line (with the seed) and the last control requests."""
        journal = self._control.journal if self._control else []
        lines = [f"\nreplay (seed {self.seed}): {shlex.join(self.command)}"]
        lines += [f"  {line}" for line in journal[-20:]]
        tail = self.console().splitlines()[-20:]
        return "\n".join(lines + (["console:"] + [f"  {line}" for line in tail] if tail else []))

    # --- control ------------------------------------------------------------------------------
    def request(self, op: str, **fields: Any) -> dict[str, Any]:
        """One control request; the reply. RefusedError if the light refuses it."""
        return self._requests((op, fields))[0]

    def _requests(self, *requests: tuple[str, dict[str, Any]]) -> list[dict[str, Any]]:
        if self._control is None:
            raise SimulatorError("the light was not started")
        try:
            return self._control.requests(*requests)
        except RefusedError:
            raise
        except SimulatorError as error:
            raise SimulatorError(f"{error}{self.replay()}") from error

    def now_us(self) -> int:
        """Board time at the end of the last advance: it goes on over resets."""
        return self._now_us

    def advance(self, us: int = 0, *, s: float = 0.0) -> int:
        """Lets `us` (or `s` seconds) pass; all that the light sent lies in the links' inboxes.
        Returns board time. Advancing by 0 lets the light deal with what was sent to it."""
        self._advance(us + round(s * 1e6))
        return self._now_us

    def observe(self, us: int = 0) -> tuple[dict[str, Any], list[Edge]]:
        """advance(), then outputs() and edges(), in one exchange with the light: a third of the
        time for who looks at each step."""
        _, outputs, edges = self._advance(us, ("outputs", {}), ("edges", {"max": EDGES_MAX}))
        return outputs, self._edges(edges)

    def _advance(self, us: int, *also: tuple[str, dict[str, Any]]) -> list[dict[str, Any]]:
        """also: requests that go along with the last step; all replies of that."""
        left = us
        while True:
            for client in chain.from_iterable(self._clients.values()):
                client.keep_alive()
            step = min(left, self._chunk_us, self._until_due()) if self._attached else left
            left -= step
            if left <= 0:
                return self._advance_once(step, *also)
            self._advance_once(step)

    def pump(self, us: int) -> None:
        """Pacer: lets exactly `us` pass."""
        self.advance(us)

    def _until_due(self) -> int:
        """Lets every port send what is due; how long until there is more."""
        now = self._now_us
        steps = (attached.port.step(now) for attached in self._attached.values())
        return min((max(due - now, 0) for due in steps if due is not None), default=CHUNK_MAX_US)

    def _advance_once(self, us: int, *also: tuple[str, dict[str, Any]]) -> list[dict[str, Any]]:
        due = {
            name: attached.rx_before + attached.port.sent
            for name, attached in self._attached.items()
            if attached.port.sent
        }
        replies = self._requests(("advance", {"us": us} | ({"await": due} if due else {})), *also)
        reply = replies[0]
        self._now_us = int(reply["now_us"])
        most = 0
        for name, (_, sent) in self._totals(reply).items():
            attached = self._attached.get(name)
            if attached is None:
                continue
            port = attached.port
            count = sent - attached.tx_before - port.received
            most = max(most, count * port.unit_weight)
            try:
                port.fetch(count)
            except Exception as error:
                raise SimulatorError(f"{name}: {error}{self.replay()}") from error
        self._pace(us, most)
        return replies

    def _pace(self, us: int, count: int) -> None:
        """Chooses the next chunk so that about CHUNK_BYTES come in it."""
        if count > CHUNK_BYTES:
            self._chunk_us = max(CHUNK_MIN_US, self._chunk_us // 2)
        elif us >= self._chunk_us and count < CHUNK_BYTES // 2:
            self._chunk_us = min(CHUNK_MAX_US, self._chunk_us * 2)

    @staticmethod
    def _totals(reply: Mapping[str, Any]) -> dict[str, tuple[int, int]]:
        """What each wire (bytes) and each bus (frames) has received and sent."""
        wires = {n: (int(w["rx_bytes"]), int(w["tx_bytes"])) for n, w in reply["wires"].items()}
        buses = reply.get("buses", {}).items()
        return wires | {n: (int(b["rx_frames"]), int(b["tx_frames"])) for n, b in buses}

    def wires(self) -> dict[str, Wire]:
        """Every wire by its name, with its actual address (a port 0 resolved)."""
        return {
            name: Wire(name, str(wire["address"]), int(wire["rx_bytes"]), int(wire["tx_bytes"]))
            for name, wire in self.request("wires")["wires"].items()
        }

    def outputs(self) -> dict[str, Any]:
        """What the board puts out now: level, limit, gate, energy, temperature …"""
        return self.request("outputs")

    def edges(self) -> list[Edge]:
        """Changes of the lamp's output since the last call, oldest first. SimulatorError if there
        were more than the light keeps."""
        return self._edges(self.request("edges", max=EDGES_MAX))

    def _edges(self, reply: dict[str, Any]) -> list[Edge]:
        """Those of a reply, and of what it leaves to be asked for."""
        edges: list[Edge] = []
        while True:
            if reply["lost"]:
                raise SimulatorError(f"{reply['lost']} edges were not fetched in time")
            edges += [Edge(int(t), int(level)) for t, level in reply["edges"]]
            if not reply["more"]:
                return edges
            reply = self.request("edges", max=EDGES_MAX)

    def skip_edges(self) -> None:
        """The next edges() reports what changes from now on."""
        self.request("edges", since=int(self.outputs()["changes"]))

    def set(self, **values: Any) -> dict[str, Any]:
        """Sets the surroundings: ambient temperature, fan …"""
        return self.request("set", **values)

    def set_ambient(self, degrees_c: float) -> None:
        self.set(ambient_mdegc=round(degrees_c * 1000))

    def set_fan(self, working: bool) -> None:
        self.set(fan=working)

    def fault(self, device: str, kind: str, **fields: Any) -> dict[str, Any]:
        """Injects a fault, for example ("thermistor", "open"), ("uart0", "lost", rate_ppm=1000)."""
        return self.request("fault", device=device, kind=kind, **fields)

    def gpio(self, line: str, value: bool) -> None:
        """Drives an input line of the board."""
        self.request("gpio", line=line, value=int(value))

    def reset(self) -> None:
        """Pulls the board's reset line."""
        self.request("reset")

    # --- links --------------------------------------------------------------------------------
    def attach(self, name: str, link: Link, *, from_start: bool = False) -> Link:
        """Reads `link` in lock-step with the wire `name` from now on. The simulator closes it.
        from_start: the link was there before the light, so it holds all that was ever sent."""
        wire = self.wires()[name]
        before = (0, 0) if from_start else (wire.rx_bytes, wire.tx_bytes)
        self._attached[name] = _Attached(link, *before)
        return link

    def detach(self, name: str) -> None:
        """Closes what is attached to the wire or bus `name`."""
        self._attached.pop(name).port.close()
        self._buses.pop(name, None)
        self._clients.pop(name, None)

    def open(self, name: str) -> Link:
        """The other end of the wire `name`, attached."""
        wire = self.wires()[name]
        kind, _, rest = wire.address.partition(":")
        link: Link
        if kind == "udpin":
            link = UdpLink(peer=parse_address(rest, wire.address))
        elif kind == "tcpin":
            link = TcpLink(parse_address(rest, wire.address))
        elif kind == "pty":
            link = TerminalLink(rest)
        else:
            raise SimulatorError(f"{name} is {wire.address}: it has no end to open here")
        return self.attach(name, link)

    def bus(self, name: str = "can0") -> CanPort:
        """This side's place on the light's CAN bus, attached; the same at every call. In lock-step
        nobody else may be on that bus: any number of nodes share this place."""
        if name not in self._buses:
            info = self.request("buses")["buses"][name]
            port = self._buses[name] = self._join(name)
            self._attached[name] = _Attached(port, int(info["rx_frames"]), int(info["tx_frames"]))
        return self._buses[name]

    def _join(self, name: str) -> CanPort:
        from .can_node import CanPort, open_bus

        option = self.command[self.command.index(f"--{name}") + 1].partition(",")[0]
        kind, _, rest = option.partition(":")
        interface = "pharos-udp" if kind == "udp" else kind
        return CanPort(open_bus(interface, rest, fd=True))

    def node(self, node_id: int, name: str = "can0", *, fd: bool = False) -> DronecanNode:
        """A DroneCAN node of this side on the bus `name`."""
        from .can_node import DronecanNode

        return DronecanNode(self.bus(name), self.now_us, node_id, fd=fd)

    def connect(
        self,
        name: str = "uart0",
        source: Source | None = None,
        target: Target | None = None,
        *,
        tunnel: Tunnel | None = None,
    ) -> MavlinkConnection:
        """A MAVLink client at the other end of the wire `name`, or on the bus `name`, through the
        tunnel. It speaks at least every KEEP_ALIVE_US while time is advanced, as any station does:
        a light that listens on UDP forgets peers that are silent."""
        if self.dialect is None:
            self.dialect = load_dialect(find_dialect(self.binary.parent))
        link = self._tunnel(name, tunnel or Tunnel()) if name.startswith("can") else self.open(name)
        client = MavlinkConnection(link, self, self.dialect, source, target)
        self._clients.setdefault(name, []).append(client)
        return client

    def _tunnel(self, name: str, tunnel: Tunnel) -> Link:
        from .tunnel import TunnelLink

        node = self.node(tunnel.own, name, fd=tunnel.fd)
        return TunnelLink(node, tunnel.node, serial_id=tunnel.serial)

    def imc(self, name: str = "imc", **kwargs: Any) -> ImcPeer:
        """An IMC peer at the other end of the wire `name`, or of the light's datagrams."""
        from .imc import ImcPeer

        link = self._datagrams() if name == "imc" else self.open(name)
        return ImcPeer(link, self, **kwargs)

    def _datagrams(self) -> DatagramLink:
        from .imc import DatagramLink

        info = self.request("imc")
        kind, _, rest = str(info["address"]).partition(":")
        if kind != "udp":
            raise SimulatorError("the light has no datagrams: its option is --imc udp:HOST:PORT")
        heard_on = int(info["discovery_port"])
        option = self.command[self.command.index("--imc") + 1]
        first = int(option.rpartition("discovery=")[2])
        link = DatagramLink(parse_address(rest, option), first, heard_on)
        self._attached["imc"] = _Attached(
            link, int(info["rx_datagrams"]), int(info["tx_datagrams"])
        )
        return link
