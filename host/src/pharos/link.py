# SPDX-License-Identifier: Apache-2.0
"""Links: bytes to and from a light, over UDP, TCP, a pty or a serial line.

A link counts what it sent and received, and keeps what came in order in an inbox. Nothing here
waits on its own: whoever owns the time (`Pacer`) fetches, either until the number of bytes that the
simulator reported has come (lock-step), or whatever the host has within a real time-out.
"""

from __future__ import annotations

import os
import select
import socket
import termios
import time
import tty
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from typing import Protocol

from .errors import LinkError, UrlError

DATAGRAM_MAX = 65536
# Host time after which bytes that the simulator says it sent count as lost [s].
FETCH_TIMEOUT_S = 10.0
SOCKET_BUFFER = 4 << 20


class Link(ABC):
    """One end of a wire. `sent` and `received` count bytes since it was opened."""

    def __init__(self) -> None:
        self.sent = 0
        self.received = 0
        self.inbox: deque[bytes] = deque()

    @abstractmethod
    def fileno(self) -> int: ...

    @abstractmethod
    def _write(self, data: bytes) -> None: ...

    @abstractmethod
    def _read(self) -> bytes:
        """One datagram, or the bytes at hand; b"" if there are none now."""

    @abstractmethod
    def close(self) -> None: ...

    def send(self, data: bytes) -> None:
        """Sends all of `data`: one datagram on UDP."""
        self._write(data)
        self.sent += len(data)

    def poll(self, timeout_s: float) -> bool:
        """Moves what is at hand into the inbox; waits up to `timeout_s` of host time for it."""
        if not select.select([self.fileno()], [], [], timeout_s)[0]:
            return False
        data = self._read()
        if not data:
            return False
        self.received += len(data)
        self.inbox.append(data)
        return True

    def fetch(self, count: int, timeout_s: float | None = None) -> None:
        """Moves exactly `count` more bytes into the inbox."""
        want = self.received + count
        deadline = time.monotonic() + (FETCH_TIMEOUT_S if timeout_s is None else timeout_s)
        while self.received < want:
            if not self.poll(max(0.0, deadline - time.monotonic())) and (
                time.monotonic() >= deadline
            ):
                raise LinkError(f"{self}: {want - self.received} of {count} bytes did not arrive")

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

    def __init__(
        self, peer: tuple[str, int] | None = None, bind: tuple[str, int] | None = None
    ) -> None:
        super().__init__()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SOCKET_BUFFER)
        self._socket.setblocking(False)
        try:
            self._socket.bind(bind or ("127.0.0.1" if _is_loopback(peer) else "0.0.0.0", 0))
        except OSError as error:
            self._socket.close()
            raise UrlError(f"cannot bind {bind}: {error.strerror}") from error
        self._peer = peer
        self._fixed = peer is not None

    @property
    def address(self) -> tuple[str, int]:
        host, port = self._socket.getsockname()[:2]
        return str(host), int(port)

    def fileno(self) -> int:
        return self._socket.fileno()

    def _write(self, data: bytes) -> None:
        if self._peer is None:
            raise LinkError(f"{self}: nobody has spoken yet, so there is nowhere to send to")
        self._socket.sendto(data, self._peer)

    def _read(self) -> bytes:
        try:
            data, peer = self._socket.recvfrom(DATAGRAM_MAX)
        except (BlockingIOError, ConnectionRefusedError):
            return b""
        if not self._fixed:
            self._peer = (str(peer[0]), int(peer[1]))
        return data

    def close(self) -> None:
        self._socket.close()

    def __str__(self) -> str:
        return f"udp {self._peer or self.address}"


class TcpLink(Link):
    """A TCP client."""

    def __init__(self, peer: tuple[str, int], timeout_s: float = 5.0) -> None:
        super().__init__()
        self.peer = peer
        try:
            self._socket = socket.create_connection(peer, timeout_s)
        except OSError as error:
            raise LinkError(f"tcp {peer[0]}:{peer[1]}: {error.strerror or error}") from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.settimeout(timeout_s)

    def fileno(self) -> int:
        return self._socket.fileno()

    def _write(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise LinkError(f"{self}: {error.strerror or error}") from error

    def _read(self) -> bytes:
        try:
            data = self._socket.recv(DATAGRAM_MAX)
        except OSError as error:
            raise LinkError(f"{self}: {error.strerror or error}") from error
        if not data:
            raise LinkError(f"{self}: closed by the other side")
        return data

    def close(self) -> None:
        self._socket.close()

    def __str__(self) -> str:
        return f"tcp {self.peer[0]}:{self.peer[1]}"


class TerminalLink(Link):
    """A pty's or a serial line's device file, in raw mode."""

    def __init__(self, path: str, baud: int | None = None) -> None:
        super().__init__()
        self.path = path
        try:
            self._fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise UrlError(f"{path}: {error.strerror}") from error
        try:
            tty.setraw(self._fd, termios.TCSANOW)
            if baud is not None:
                self._set_baud(baud)
        except (termios.error, UrlError) as error:
            os.close(self._fd)
            raise UrlError(f"{path}: {error}") from error

    def _set_baud(self, baud: int) -> None:
        speed = getattr(termios, f"B{baud}", None)
        if speed is None:
            raise UrlError(f"{baud} Bd is not a speed of this host's serial lines")
        attributes = termios.tcgetattr(self._fd)
        attributes[4] = attributes[5] = speed
        termios.tcsetattr(self._fd, termios.TCSANOW, attributes)

    def fileno(self) -> int:
        return self._fd

    def _write(self, data: bytes) -> None:
        view = memoryview(data)
        while view:
            if not select.select([], [self._fd], [], FETCH_TIMEOUT_S)[1]:
                raise LinkError(f"{self}: the other side does not read")
            view = view[os.write(self._fd, view) :]

    def _read(self) -> bytes:
        try:
            return os.read(self._fd, DATAGRAM_MAX)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise LinkError(f"{self}: {error.strerror}") from error

    def close(self) -> None:
        os.close(self._fd)

    def __str__(self) -> str:
        return self.path


class Pacer(Protocol):
    """Who lets time pass for links: the simulator's clock or the host's."""

    def now_us(self) -> int: ...

    def pump(self, us: int) -> None:
        """Lets up to `us` pass. Afterwards all that arrived lies in the links' inboxes."""


class RealPacer:
    """The host's clock: returns as soon as one of its links has something."""

    def __init__(self, links: Sequence[Link]) -> None:
        self._links = list(links)

    def now_us(self) -> int:
        return time.monotonic_ns() // 1000

    def pump(self, us: int) -> None:
        ready = select.select(self._links, [], [], us / 1e6)[0]
        for link in ready:
            link.poll(0.0)


LINK_FORMS = "udp:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT, pty:PATH or serial:DEVICE,BAUD"


def open_link(url: str) -> Link:
    """Opens the link that `url` names; UrlError says what is wrong and what would be right."""
    kind, colon, rest = url.partition(":")
    if not colon or not rest:
        raise UrlError(f"'{url}' is no link; expected {LINK_FORMS}")
    if kind in ("udp", "udpout"):
        return UdpLink(peer=parse_address(rest, url))
    if kind == "udpin":
        return UdpLink(bind=parse_address(rest, url))
    if kind == "tcp":
        return TcpLink(parse_address(rest, url))
    if kind == "pty":
        return TerminalLink(rest)
    if kind == "serial":
        device, comma, baud = rest.partition(",")
        if comma and not baud.isdecimal():
            raise UrlError(f"'{baud}' in '{url}' is no baud rate; expected serial:DEVICE,BAUD")
        return TerminalLink(device, int(baud) if comma else 57600)
    raise UrlError(f"'{kind}' in '{url}' is no kind of link; expected {LINK_FORMS}")


def parse_address(text: str, url: str) -> tuple[str, int]:
    host, colon, port = text.rpartition(":")
    if not colon or not host or not port.isdecimal() or int(port) > 65535:
        raise UrlError(f"'{text}' in '{url}' is no HOST:PORT")
    return host, int(port)


def _is_loopback(peer: tuple[str, int] | None) -> bool:
    return peer is not None and peer[0] in ("127.0.0.1", "localhost")
