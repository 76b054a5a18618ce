# SPDX-License-Identifier: Apache-2.0
"""Lights within reach: on UDP, TCP, serial lines, CAN buses, and in IMC's announcements.

A place is where to look: a URL as open_link() takes it, where `udp:` may be a broadcast address;
`can:INTERFACE/CHANNEL`, all nodes of that bus; `imc:`, what nodes announce on this host and its
networks.
"""

from __future__ import annotations

import glob
import re
import socket
import subprocess
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .connection import MavlinkConnection, Target
from .dialect import load_dialect
from .errors import LinkError, PharosError, UrlError
from .light import TYPE_ILLUMINATOR, Information, Light
from .link import BAUD_DEFAULT, DATAGRAM_MAX, Link, Port, RealPacer, open_link, parse_address

if TYPE_CHECKING:
    from .can_node import CanPort

SECONDS = 3.0
# The ports that lights and ground stations use by default.
UDP_PORTS = (14540, 14550)
TCP_PORT = 5770
SERIAL = ("/dev/serial/by-id/*", "/dev/ttyUSB*", "/dev/ttyACM*")
NETWORK = Path("/sys/class/net")
ARPHRD_CAN = 280  # <linux/if_arp.h>
MDNS_TYPE = "_mavlink._udp"
MDNS_S = 2.0
IMC_PORTS = range(30100, 30105)
IMC_GROUP = "224.0.75.69"
IMC_SENSORS = (6, 7)  # SystemType: STATICSENSOR, MOBILESENSOR
HEARTBEAT_US = 1_000_000
# How long a device is asked what it is, once it is found [µs].
PROBE_S = 1.0


@dataclass(frozen=True)
class Found:
    """A light, and the URL that reaches it. system, component: MAVLink's; 0: it has none there."""

    url: str
    system: int = 0
    component: int = 0
    information: Information | None = None
    name: str = ""
    note: str = field(default="", compare=False)

    @property
    def serial(self) -> str:
        return self.information.serial_number if self.information else ""

    def as_fields(self) -> dict[str, Any]:
        info = self.information
        return {
            "url": self.url,
            "system": self.system,
            "component": self.component,
            "name": self.name,
            "serial": self.serial,
            "version": info.software_version if info else "",
            "note": self.note,
        }

    def __str__(self) -> str:
        parts = [f"{self.url:<34}"]
        if self.system:
            parts.append(f"{self.system}/{self.component}")
        parts.append(self.name or "?")
        if self.information:
            parts.append(f"software {self.information.software_version or '?'}")
            parts.append(f"serial {self.serial or 'unknown'}")
        return "  ".join(parts + ([f"({self.note})"] if self.note else []))


def usual_places(baud: int = BAUD_DEFAULT) -> list[str]:
    """Where lights are on most hosts."""
    places = [
        f"udp:{address}:{port}"
        for port in UDP_PORTS
        for address in ("127.0.0.1", "127.255.255.255", "255.255.255.255")
    ]
    places += [f"udpin:0.0.0.0:{port}" for port in UDP_PORTS]
    places.append(f"tcp:127.0.0.1:{TCP_PORT}")
    paths = {str(Path(p).resolve()): p for pattern in SERIAL for p in sorted(glob.glob(pattern))}
    places += [f"serial:{path},{baud}" for path in paths.values()]
    places += [f"can:socketcan/{name}" for name in _can_interfaces()]
    return [*places, "can:pharos-udp", "imc:", *announced_places()]


def announced_places() -> list[str]:
    """What the network's mDNS says of lights (_mavlink._udp); nothing without avahi-browse."""
    words = ("avahi-browse", "--resolve", "--parsable", "--terminate", "--no-db-lookup", MDNS_TYPE)
    try:
        done = subprocess.run(words, capture_output=True, timeout=MDNS_S, check=False)
        text = done.stdout
    except subprocess.TimeoutExpired as late:
        text = late.stdout or b""
    except OSError:
        return []
    places: dict[str, None] = {}
    for line in text.decode(errors="replace").splitlines():
        fields = line.split(";")
        # =;interface;protocol;name;type;domain;host;address;port;text
        if len(fields) < 9 or fields[0] != "=" or fields[4] != MDNS_TYPE:
            continue
        host, port = fields[7], fields[8]
        place = f"udp:[{host}]:{port}" if ":" in host else f"udp:{host}:{port}"
        # A link-local address needs an interface, which a URL has no place for.
        if not host.lower().startswith("fe80"):
            with suppress(UrlError):
                parse_address(place.removeprefix("udp:"), place)
                places[place] = None
    return list(places)


def _can_interfaces() -> Iterator[str]:
    for kind in sorted(NETWORK.glob("*/type")):
        state = kind.with_name("operstate")
        with suppress(OSError, ValueError):
            if int(kind.read_text()) == ARPHRD_CAN and state.read_text().strip() != "down":
                yield kind.parent.name


def find_lights(
    places: Iterable[str] | None = None,
    seconds: float = SECONDS,
    on_skip: Callable[[str, PharosError], None] = lambda _place, _error: None,
) -> list[Found]:
    """Those that speak within the time. on_skip: of the usual places, many are not there."""
    chosen = usual_places() if places is None else list(places)
    with ExitStack() as stack:
        sources: list[_Source] = []
        for place in chosen:
            try:
                sources += _sources_of(place, stack)
            except PharosError as error:
                on_skip(place, error)
        pacer = RealPacer([source.port for source in sources])
        for source in sources:
            source.begin(pacer)
        end = pacer.now_us() + round(seconds * 1e6)
        while sources and pacer.now_us() < end:
            for source in sources:
                source.step(pacer.now_us())
            pacer.pump(min(50_000, max(0, end - pacer.now_us())))
        found = [light for source in sources for light in source.lights()]
    return _warned(_once(found))


def _once(found: Iterable[Found]) -> list[Found]:
    """One that was seen twice at the same URL is one."""
    return list({(f.url, f.system, f.component): f for f in found}.values())


def _warned(found: list[Found]) -> list[Found]:
    """Different lights of the same ids are told of: neither can be commanded alone."""
    warned = []
    for light in found:
        twins = [
            other.url
            for other in found
            if light.system
            and other is not light
            and (other.system, other.component) == (light.system, light.component)
            and other.serial != light.serial
        ]
        note = f"the ids of {', '.join(twins)} too" if twins else light.note
        warned.append(replace(light, note=note))
    return warned


# --- where they are -------------------------------------------------------------------------------
class _Source:
    """A place that is listened to."""

    port: Port

    def begin(self, pacer: RealPacer) -> None: ...

    def step(self, now_us: int) -> None: ...

    def lights(self) -> list[Found]:
        raise NotImplementedError


def _sources_of(place: str, stack: ExitStack) -> list[_Source]:
    kind, _, rest = place.partition(":")
    if kind in ("udp", "udpout"):
        callers = _Callers(parse_address(rest, place), place)
        stack.callback(callers.port.close)
        return [callers]
    if kind == "can":
        bus = _Bus(rest)
        stack.callback(bus.port.close)
        return [bus]
    if kind == "imc":
        announcements = _Announcements()
        stack.callback(announcements.port.close)
        return [announcements]
    link = open_link(place)
    stack.callback(link.close)
    return [_Line(link, place)]


class _Line(_Source):
    """A link, on which any number of components may be."""

    def __init__(self, link: Link, url: str) -> None:
        self.port = link
        self.url = url
        self.heard: dict[tuple[int, int], None] = {}
        self._beat_us = 0

    def begin(self, pacer: RealPacer) -> None:
        assert isinstance(self.port, Link)
        self.connection = MavlinkConnection(self.port, pacer, load_dialect())

    def step(self, now_us: int) -> None:
        connection = self.connection
        for message in connection.drain():
            if message.get_type() == "HEARTBEAT" and message.type == TYPE_ILLUMINATOR:
                self.heard[message.get_srcSystem(), message.get_srcComponent()] = None
        connection.inbox.clear()
        if now_us >= self._beat_us and connection.link.can_send():
            self._beat_us = now_us + HEARTBEAT_US
            with suppress(LinkError):
                connection.heartbeat()

    def lights(self) -> list[Found]:
        self.step(0)
        found = []
        for system, component in self.heard:
            self.connection.target = Target(system, component)
            information, note = None, ""
            try:
                information = Light(self.connection).fetch_information()
            except PharosError as error:
                signed = self.connection.hears_signed()
                note = "it signs its messages: --key-file" if signed else str(error)
            name = f"{information.vendor_name} {information.model_name}" if information else ""
            found.append(Found(self.url, system, component, information, name.strip(), note))
        return found


class _CallPort(Port):
    """A socket that calls an address, which may be everybody's, and hears who answers."""

    def __init__(self, address: tuple[str, int], place: str) -> None:
        super().__init__()
        self.address = address
        self.callers: dict[tuple[str, int], None] = {}
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
            self._socket.bind(("127.0.0.1" if address[0].startswith("127.") else "0.0.0.0", 0))
        except OSError as error:
            self._socket.close()
            raise LinkError(f"{place}: {error.strerror}") from error

    def fileno(self) -> int:
        return self._socket.fileno()

    def call(self, data: bytes) -> None:
        with suppress(OSError):  # nobody there, or no such network
            self._socket.sendto(data, self.address)

    def poll(self, timeout_s: float) -> bool:
        del timeout_s
        try:
            data, peer = self._socket.recvfrom(DATAGRAM_MAX)
        except OSError:
            return False
        if data[:1] in (b"\xfd", b"\xfe"):
            self.callers[str(peer[0]), int(peer[1])] = None
        return True

    def close(self) -> None:
        self._socket.close()


class _Callers(_Source):
    """Who answers a heartbeat to an address; each is then asked alone."""

    def __init__(self, address: tuple[str, int], place: str) -> None:
        if address[1] == 0:
            raise UrlError(f"'{place}': nobody listens on port 0")
        self.calls = self.port = _CallPort(address, place)
        self._beat_us = 0
        dialect = load_dialect()
        station = dialect.MAVLink(None, 255, 190)
        self._call = bytes(dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(station))

    def step(self, now_us: int) -> None:
        if now_us >= self._beat_us:
            self._beat_us = now_us + HEARTBEAT_US
            self.calls.call(self._call)

    def lights(self) -> list[Found]:
        found: list[Found] = []
        for host, port in self.calls.callers:
            url = f"udp:{host}:{port}"
            with open_link(url) as link:
                found += _lights_on(_Line(link, url), link)
        return found


def _lights_on(line: _Line, port: Port) -> list[Found]:
    pacer = RealPacer([port])
    line.begin(pacer)
    end = pacer.now_us() + round(2 * PROBE_S * 1e6)
    while pacer.now_us() < end and not line.heard:
        line.step(pacer.now_us())
        pacer.pump(50_000)
    return line.lights()


class _Bus(_Source):
    """The nodes of a CAN bus; each is then asked through DroneCAN's tunnel."""

    def __init__(self, bus: str) -> None:
        from .can_node import CanPort, open_bus

        interface, _, channel = bus.partition("/")
        self.bus = bus
        self.port: CanPort = CanPort(open_bus(interface, channel))
        self._nodes: dict[int, None] = {}

    def begin(self, pacer: RealPacer) -> None:
        from dronecan import uavcan

        from .can_node import DronecanNode

        self.node = DronecanNode(self.port, pacer.now_us)
        self.node.subscribe(uavcan.protocol.NodeStatus, self._on_status)

    def _on_status(self, transfer: Any) -> None:
        self._nodes[transfer.header.source] = None

    def lights(self) -> list[Found]:
        from .tunnel import NODE_MAX, TunnelLink

        found: list[Found] = []
        for number in sorted(self._nodes):
            if number <= NODE_MAX:
                url = f"dronecan:{self.bus}?node={number}"
                found += _lights_on(_Line(TunnelLink(self.node, number), url), self.port)
        return found


class _AnnouncePort(Port):
    def __init__(self) -> None:
        super().__init__()
        self.datagrams: list[bytes] = []
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        for port in IMC_PORTS:
            with suppress(OSError):
                self._socket.bind(("0.0.0.0", port))
                break
        else:
            self._socket.close()
            raise LinkError(f"imc: all of UDP ports {IMC_PORTS[0]} to {IMC_PORTS[-1]} are taken")
        for interface in ("127.0.0.1", "0.0.0.0"):
            group = socket.inet_aton(IMC_GROUP) + socket.inet_aton(interface)
            with suppress(OSError):  # a host without a network
                self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)

    def fileno(self) -> int:
        return self._socket.fileno()

    def poll(self, timeout_s: float) -> bool:
        del timeout_s
        try:
            self.datagrams.append(self._socket.recv(DATAGRAM_MAX))
        except OSError:
            return False
        return True

    def close(self) -> None:
        self._socket.close()


class _Announcements(_Source):
    """Sensors that announce themselves: IMC has no better name for a light."""

    def __init__(self) -> None:
        self.announcements = self.port = _AnnouncePort()

    def lights(self) -> list[Found]:
        from .imc import ImcError, decode

        found = []
        for datagram in self.announcements.datagrams:
            try:
                packet = decode(datagram)
            except ImcError:
                continue
            if packet.name != "Announce" or packet.message.fields["sys_type"] not in IMC_SENSORS:
                continue
            fields = packet.message.fields
            where = re.search(rb"imc\+udp://([^/;]+)", bytes(fields["services"]))
            url = f"udp:{where[1].decode('ascii', 'backslashreplace')}" if where else "?"
            name = bytes(fields["sys_name"]).decode("utf-8", "backslashreplace")
            found.append(Found(url, name=f"IMC {packet.src:#06x} {name}"))
        return found
