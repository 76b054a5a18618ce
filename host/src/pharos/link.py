# SPDX-License-Identifier: Apache-2.0
"""Links: bytes to and from a light, over UDP, TCP, a pty, a serial line, or CAN (tunnel.py).

A link counts what it sent and received, and keeps what came in order in an inbox. Nothing here
waits on its own: whoever owns the time (`Pacer`) fetches, either until the number of bytes that the
simulator reported has come (lock-step), or whatever the host has within a real time-out.
"""

from __future__ import annotations

import math
import os
import select
import socket
import termios
import time
import tty
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from typing import Any, Protocol

from .errors import LinkError, UrlError

DATAGRAM_MAX = 65536
# Host time after which bytes that the simulator says it sent count as lost [s].
FETCH_TIMEOUT_S = 10.0
SOCKET_BUFFER = 4 << 20
# Ports that cannot be waited for together are asked in turn, each for so long [s].
POLL_SLICE_S = 0.005


class Port(ABC):
    """Where something arrives. `sent` and `received` count since it was opened: bytes of a link,
    frames of a CAN bus."""

    unit = "bytes"
    # How much of the host's buffers one of these takes, in bytes of a pty's.
    unit_weight = 1

    def __init__(self) -> None:
        self.sent = 0
        self.received = 0

    @abstractmethod
    def fileno(self) -> int:
        """To wait for input; -1: there is no such number."""

    @abstractmethod
    def poll(self, timeout_s: float) -> bool:
        """Takes what is at hand; waits up to `timeout_s` of host time for it. Whether there was
        something."""

    @abstractmethod
    def close(self) -> None: ...

    def step(self, now_us: int) -> int | None:
        """Sends what is due by the clock of the owner's `Pacer`. Returns when to call again; None:
        no need to."""
        del now_us
        return None

    def fetch(self, count: int, timeout_s: float | None = None) -> None:
        """Takes exactly `count` more."""
        want = self.received + count
        deadline = time.monotonic() + (FETCH_TIMEOUT_S if timeout_s is None else timeout_s)
        while self.received < want:
            if not self.poll(max(0.0, deadline - time.monotonic())) and (
                time.monotonic() >= deadline
            ):
                missing = f"{want - self.received} of {count} {self.unit}"
                raise LinkError(f"{self}: {missing} did not arrive")


class Link(Port):
    """One end of a wire. What came lies in `inbox`, in order."""

    # Whether what is sent at once arrives at once and whole (UDP), or is a stream of bytes.
    is_datagram = False

    def __init__(self) -> None:
        super().__init__()
        self.inbox: deque[bytes] = deque()

    @abstractmethod
    def _write(self, data: bytes) -> None: ...

    @abstractmethod
    def _read(self) -> bytes:
        """One datagram, or the bytes at hand; b"" if there are none now."""

    def can_send(self) -> bool:
        """Whether it is known where to send to: a listening link learns that from the light."""
        return True

    def send(self, data: bytes) -> None:
        """Sends all of `data`: one datagram on UDP."""
        self._write(data)
        self.sent += len(data)

    def poll(self, timeout_s: float) -> bool:
        """Moves what is at hand into the inbox; waits up to `timeout_s` of host time for it."""
        if not wait_readable(self.fileno(), timeout_s):
            return False
        data = self._read()
        if not data:
            return False
        self.received += len(data)
        self.inbox.append(data)
        return True

    def take(self) -> list[bytes]:
        """All that came since the last take, in order."""
        chunks = list(self.inbox)
        self.inbox.clear()
        return chunks

    def __enter__(self) -> Link:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()


class UdpLink(Link):
    """UDP. With a `peer` it talks to that one; without, to whoever spoke last (`bind` only)."""

    is_datagram = True

    def __init__(
        self, peer: tuple[str, int] | None = None, bind: tuple[str, int] | None = None
    ) -> None:
        super().__init__()
        family, address = _resolve(peer or bind or ("127.0.0.1", 0))
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SOCKET_BUFFER)
        self._socket.setblocking(False)
        self._peer = address if peer is not None else None
        self._fixed = peer is not None
        here = _resolve(bind)[1] if bind else _any_address(family, address)
        try:
            self._socket.bind(here)
        except OSError as error:
            self._socket.close()
            raise LinkError(f"udp {_show(here)}: {error.strerror}") from error

    @property
    def address(self) -> tuple[str, int]:
        host, port = self._socket.getsockname()[:2]
        return str(host), int(port)

    def fileno(self) -> int:
        return self._socket.fileno()

    def can_send(self) -> bool:
        return self._peer is not None

    def _write(self, data: bytes) -> None:
        if self._peer is None:
            raise LinkError(f"{self}: nobody has spoken yet, so there is nowhere to send to")
        try:
            self._socket.sendto(data, self._peer)
        except ConnectionRefusedError:
            pass  # an earlier datagram found nobody there; whoever starts later hears the next one
        except OSError as error:
            raise LinkError(f"{self}: {error.strerror}") from error

    def _read(self) -> bytes:
        try:
            data, peer = self._socket.recvfrom(DATAGRAM_MAX)
        except (BlockingIOError, ConnectionRefusedError):
            return b""
        if not self._fixed:
            self._peer = peer
        return data

    def close(self) -> None:
        self._socket.close()

    def __str__(self) -> str:
        return f"udp {_show(self._peer or self.address)}"


class TcpLink(Link):
    """A TCP client."""

    def __init__(self, peer: tuple[str, int], timeout_s: float = 5.0) -> None:
        super().__init__()
        self.peer = peer
        try:
            self._socket = socket.create_connection(peer, timeout_s)
        except OSError as error:
            raise LinkError(f"tcp {_show(peer)}: {error.strerror or error}") from error
        _prepare_stream(self._socket, timeout_s)

    def fileno(self) -> int:
        return self._socket.fileno()

    def _write(self, data: bytes) -> None:
        _write_stream(self, self._socket, data)

    def _read(self) -> bytes:
        return _read_stream(self, self._socket)

    def close(self) -> None:
        self._socket.close()

    def __str__(self) -> str:
        return f"tcp {_show(self.peer)}"


class TcpListenLink(Link):
    """Waits for a light that connects to us (its wire is `tcp:`); the latest connection counts."""

    def __init__(self, bind: tuple[str, int], timeout_s: float = 5.0) -> None:
        super().__init__()
        self._timeout_s = timeout_s
        self._connection: socket.socket | None = None
        family, address = _resolve(bind)
        try:
            self._listener = socket.create_server(address[:2], family=family)
        except OSError as error:
            raise LinkError(f"tcpin {_show(bind)}: {error.strerror}") from error

    @property
    def address(self) -> tuple[str, int]:
        host, port = self._listener.getsockname()[:2]
        return str(host), int(port)

    def fileno(self) -> int:
        return (self._connection or self._listener).fileno()

    def can_send(self) -> bool:
        return self._connection is not None

    def _write(self, data: bytes) -> None:
        if self._connection is None:
            raise LinkError(f"{self}: nobody has connected yet, so there is nowhere to send to")
        _write_stream(self, self._connection, data)

    def _read(self) -> bytes:
        if self._connection is None:
            self._connection = self._listener.accept()[0]
            _prepare_stream(self._connection, self._timeout_s)
            return b""
        return _read_stream(self, self._connection)

    def close(self) -> None:
        if self._connection is not None:
            self._connection.close()
        self._listener.close()

    def __str__(self) -> str:
        return f"tcpin {_show(self.address)}"


def _prepare_stream(stream: socket.socket, timeout_s: float) -> None:
    stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    stream.settimeout(timeout_s)


def _write_stream(link: Link, stream: socket.socket, data: bytes) -> None:
    try:
        stream.sendall(data)
    except OSError as error:
        raise LinkError(f"{link}: {error.strerror or error}") from error


def _read_stream(link: Link, stream: socket.socket) -> bytes:
    try:
        data = stream.recv(DATAGRAM_MAX)
    except OSError as error:
        raise LinkError(f"{link}: {error.strerror or error}") from error
    if not data:
        raise LinkError(f"{link}: closed by the other side")
    return data


class TerminalLink(Link):
    """A pty's or a serial line's device file, in raw mode."""

    def __init__(self, path: str, baud: int | None = None) -> None:
        super().__init__()
        self.path = path
        speed = None if baud is None else _speed(baud)
        try:
            self._fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise LinkError(f"{path}: {error.strerror}") from error
        except ValueError as error:  # a NUL, or half a character
            raise UrlError(f"'{path}' is no path: {error}") from error
        try:
            tty.setraw(self._fd, termios.TCSANOW)
            if speed is not None:
                attributes = termios.tcgetattr(self._fd)
                attributes[4] = attributes[5] = speed
                termios.tcsetattr(self._fd, termios.TCSANOW, attributes)
        except termios.error as error:
            os.close(self._fd)
            raise LinkError(f"{path}: {error.args[-1]}: no terminal") from error

    def fileno(self) -> int:
        return self._fd

    def _write(self, data: bytes) -> None:
        view = memoryview(data)
        while view:
            if not select.select([], [self._fd], [], FETCH_TIMEOUT_S)[1]:
                raise LinkError(f"{self}: the other side does not read")
            try:
                view = view[os.write(self._fd, view) :]
            except BlockingIOError:
                continue
            except OSError as error:
                raise LinkError(f"{self}: {error.strerror}") from error

    def _read(self) -> bytes:
        try:
            data = os.read(self._fd, DATAGRAM_MAX)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise LinkError(f"{self}: {error.strerror}") from error
        if not data:
            raise LinkError(f"{self}: hung up")
        return data

    def close(self) -> None:
        os.close(self._fd)

    def __str__(self) -> str:
        return self.path


def _speed(baud: int) -> int:
    # B0 is no speed: it hangs up.
    speed = getattr(termios, f"B{baud}", None) if baud else None
    if speed is None:
        raise UrlError(f"{baud} Bd is not a speed of this host's serial lines")
    return int(speed)


class Pacer(Protocol):
    """Who lets time pass for links: the simulator's clock or the host's."""

    def now_us(self) -> int: ...

    def pump(self, us: int) -> None:
        """Lets up to `us` pass. Afterwards all that arrived lies in the links' inboxes."""


class RealPacer:
    """The host's clock: returns as soon as one of its ports has something."""

    def __init__(self, ports: Sequence[Port]) -> None:
        self._ports = list(ports)

    def now_us(self) -> int:
        return time.monotonic_ns() // 1000

    def pump(self, us: int) -> None:
        now = self.now_us()
        dues = [due for port in self._ports if (due := port.step(now)) is not None]
        wait_us = max(0, min([us, *(due - now for due in dues)]))
        filenos = {port.fileno(): port for port in self._ports}
        if len(self._ports) == 1:
            self._ports[0].poll(wait_us / 1e6)
        elif -1 in filenos:
            for port in self._ports:
                port.poll(min(wait_us / 1e6, POLL_SLICE_S))
        else:
            for ready in select.select(list(filenos), [], [], wait_us / 1e6)[0]:
                filenos[ready].poll(0.0)


LINK_FORMS = (
    "udp:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT, pty:PATH, "
    "serial:DEVICE,BAUD or dronecan:INTERFACE/CHANNEL?node=N"
)
BAUD_DEFAULT = 57600


def open_link(url: str) -> Link:
    """Opens the link that `url` names (LINK_FORMS). UrlError says what is wrong with it and what
    would be right; LinkError that there is nothing at its other end."""
    kind, colon, rest = url.partition(":")
    if url.startswith("/"):
        return _open_serial(url, url)
    if not colon or (not rest and kind != "dronecan"):
        raise UrlError(f"'{url}' is no link; expected {LINK_FORMS}")
    if kind in ("udp", "udpout"):
        return UdpLink(peer=_parse_peer(rest, url))
    if kind == "udpin":
        return UdpLink(bind=parse_address(rest, url))
    if kind == "tcp":
        return TcpLink(_parse_peer(rest, url))
    if kind == "tcpin":
        return TcpListenLink(parse_address(rest, url))
    if kind == "pty":
        return TerminalLink(rest)
    if kind == "serial":
        return _open_serial(rest, url)
    if kind == "dronecan":
        from .tunnel import open_tunnel  # loads all DSDL definitions: only when asked for

        return open_tunnel(url)
    if parse_number(rest) is not None:
        raise UrlError(f"'{url}' says no kind of link: udp:{url}? Expected {LINK_FORMS}")
    raise UrlError(f"'{kind}' in '{url}' is no kind of link; expected {LINK_FORMS}")


def _open_serial(text: str, url: str) -> Link:
    device, comma, baud = text.partition(",")
    speed = parse_number(baud) if comma else BAUD_DEFAULT
    if not device or speed is None:
        raise UrlError(f"'{baud}' in '{url}' is no baud rate; expected serial:DEVICE,BAUD")
    return TerminalLink(device, speed)


def parse_number(text: str) -> int | None:
    """A whole number of ASCII digits, as long as one may sensibly be; None: it is none."""
    return int(text) if text.isascii() and text.isdecimal() and len(text) <= 10 else None


def parse_address(text: str, url: str) -> tuple[str, int]:
    """HOST:PORT. UrlError says in one line what is wrong with it; whether there is such a host is
    another matter."""
    host, colon, digits = text.rpartition(":")
    port = parse_number(digits)
    if not colon or not host or port is None or port > 65535:
        raise UrlError(f"'{text}' in '{url}' is no HOST:PORT")
    if host.startswith("[") and host.endswith("]"):
        host = host[1:-1]
    elif ":" in host:
        raise UrlError(f"'{text}' in '{url}' is no HOST:PORT; an IPv6 address goes in brackets")
    if not _is_host(host):
        raise UrlError(f"'{host}' in '{url}' is no host name or address")
    # RFC 6761: never asked of a resolver, which has no answer where there is no /etc/hosts.
    return "127.0.0.1" if host == "localhost" else host, port


def _parse_peer(text: str, url: str) -> tuple[str, int]:
    host, port = parse_address(text, url)
    if port == 0:
        raise UrlError(f"'{text}' in '{url}': nobody listens on port 0")
    return host, port


def _is_host(host: str) -> bool:
    """As far as its characters go: parts of 1 to 63 of them, no space and no control."""
    try:
        host.encode("idna")
    except UnicodeError:
        return False
    return host.isprintable() and not any(c.isspace() for c in host)


def _resolve(address: tuple[str, int]) -> tuple[socket.AddressFamily, Any]:
    try:
        found = socket.getaddrinfo(*address, type=socket.SOCK_DGRAM)
    except OSError as error:
        raise LinkError(f"{_show(address)}: {error.strerror or error}") from error
    # A name that has both kinds of address means the older one to most lights.
    best = next((row for row in found if row[0] == socket.AF_INET), found[0])
    return best[0], best[4]


def _any_address(family: socket.AddressFamily, peer: Any) -> tuple[str, int]:
    """Where to listen for that peer's answers: on loopback only, if it is there."""
    if family == socket.AF_INET6:
        return ("::1" if peer[0] == "::1" else "::"), 0
    return ("127.0.0.1" if str(peer[0]).startswith("127.") else "0.0.0.0"), 0


def _show(address: Any) -> str:
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in str(host) else f"{host}:{port}"


def wait_readable(fileno: int, timeout_s: float | None) -> bool:
    """Whether there is something to read. Unlike select(), any file number will do."""
    poller = select.poll()
    poller.register(fileno, select.POLLIN)
    return bool(poller.poll(None if timeout_s is None else math.ceil(timeout_s * 1000)))
