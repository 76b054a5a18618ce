# SPDX-License-Identifier: Apache-2.0
"""The URL parser and what is behind each form, without a light."""

from __future__ import annotations

import os
import pty
import socket
from pathlib import Path
from typing import Any, NoReturn

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pharos import LinkError, PharosError, RealPacer, UrlError, open_link
from pharos.link import Link, TcpListenLink, UdpLink, parse_address
from pharos.tunnel import TunnelUrl, parse_tunnel_url

PATIENCE_US = 10_000_000


def _receive(link: Link, count: int) -> bytes:
    pacer = RealPacer([link])
    end = pacer.now_us() + PATIENCE_US
    data = b""
    while len(data) < count:
        assert pacer.now_us() < end, f"only {data!r} came"
        pacer.pump(100_000)
        data += b"".join(link.take())
    return data


@pytest.mark.parametrize(
    ("url", "hint"),
    [
        ("", "expected udp:"),
        ("14550", "expected udp:"),
        ("udp", "expected udp:"),
        ("udp:", "expected udp:"),
        ("carrier-pigeon:home", "'carrier-pigeon'"),
        ("udp:nowhere", "no HOST:PORT"),
        ("udp:127.0.0.1:", "no HOST:PORT"),
        ("udp:127.0.0.1:70000", "no HOST:PORT"),
        ("udp:::1:14550", "brackets"),
        ("tcp:host:port", "no HOST:PORT"),
        ("tcpin:1", "no HOST:PORT"),
        ("serial:,9600", "no baud rate"),
        ("serial:/dev/ttyUSB0,fast", "'fast'"),
        ("/dev/ttyUSB0,", "no baud rate"),
        ("dronecan:", "no CAN interface"),
        ("dronecan:socketcan/can0", "?node=N"),
        ("dronecan:socketcan/can0?node=x", "no number"),
        ("dronecan:socketcan/can0?node=0", "not within 1 … 125"),
        ("dronecan:socketcan/can0?node=68&own=128", "not within 1 … 127"),
        ("dronecan:socketcan/can0?node=68&own=68", "both 68"),
        ("dronecan:socketcan/can0?node=68&speed=1", "'speed'"),
        ("dronecan:socketcan/can0?node=68&fd=yes", "no number"),
        ("dronecan:tin-cans/string?node=68", "'tin-cans'"),
        ("dronecan:pharos-udp/x?node=68", "'x'"),
        ("udp:" + "a" * 300 + ":1", "no host name"),
        ("udp:a b:1", "no host name"),
        ("udp:..:1", "no host name"),
        ("tcp:host\0:1", "no host name"),
        ("udp:127.0.0.1:0", "port 0"),
        ("tcp:127.0.0.1:0", "port 0"),
        ("udp:127.0.0.1:" + "1" * 5000, "no HOST:PORT"),
        ("udp:127.0.0.1:٣", "no HOST:PORT"),
        ("pty:/dev/\0", "no path"),
        ("/dev/ttyUSB0,0", "0 Bd"),
        ("/dev/ttyUSB0," + "9" * 5000, "no baud rate"),
        ("dronecan:socketcan/can0?node=" + "9" * 5000, "no number"),
        ("udp:\x1b[2J\n:1", "\\x1b[2J\\n"),
    ],
)
def test_bad_url_says_in_one_line_what_is_wrong(url: str, hint: str) -> None:
    with pytest.raises(UrlError) as caught:
        open_link(url)
    assert hint in str(caught.value)
    assert "\n" not in str(caught.value)


KINDS = ["udp", "udpout", "udpin", "tcp", "tcpin", "pty", "serial", "dronecan", "nonsense", ""]
# What URLs are made of, and whatever else a character may be.
PARTS = st.one_of(
    st.sampled_from([":", "/", ",", "?", "&", "=", "[", "]", "::1", ".", "..", "node=5", "fd=1"]),
    st.sampled_from(["127.0.0.1", "0", "1", "70000", "57600", "pharos-udp", "socketcan", "/dev/"]),
    st.text(max_size=8),
    st.text(alphabet="a1.-", min_size=60, max_size=300),
    st.characters(categories=["Cc", "Cf", "Cs", "Nd", "Zl"]),
)


@settings(max_examples=600, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(kind=st.sampled_from(KINDS), parts=st.lists(PARTS, max_size=8))
def test_any_text_opens_or_says_in_one_line_why_not(kind: str, parts: list[str]) -> None:
    """Without asking a name server, and with no more than the time of a refused connection."""
    url = f"{kind}:{''.join(parts)}"
    ask = socket.getaddrinfo

    def numeric(host: Any, port: Any, type: int = 0) -> Any:
        return ask(host, port, type=type, flags=socket.AI_NUMERICHOST)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket, "getaddrinfo", numeric)
        patch.setattr(socket, "create_connection", _refuse)
        patch.setattr(socket, "gethostbyname", lambda host: numeric(host, 0)[0][4][0])
        reason = ""
        try:
            open_link(url).close()
        except (UrlError, LinkError) as error:
            reason = str(error)
        assert reason.isprintable()  # so, one line


def _refuse(*_args: object, **_kwargs: object) -> NoReturn:
    raise ConnectionRefusedError(111, "refused")


@pytest.mark.parametrize(
    ("url", "hint"),
    [
        ("pty:/nonexistent/tty", "No such file"),
        ("/nonexistent/tty,9600", "No such file"),
        ("serial:/dev/null,9600", "no terminal"),
        ("tcp:127.0.0.1:1", "refused"),
        ("udpin:192.0.2.1:14550", "annot assign"),  # TEST-NET-1 (RFC 5737): no host has it
        ("dronecan:socketcan/nonexistent0?node=68", "socketcan/nonexistent0"),
    ],
)
def test_absent_interface_says_so_in_one_line(url: str, hint: str) -> None:
    with pytest.raises(LinkError) as caught:
        open_link(url)
    assert hint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_addresses_in_brackets_are_ipv6() -> None:
    assert parse_address("[::1]:14550", "") == ("::1", 14550)
    assert parse_address("127.0.0.1:14550", "") == ("127.0.0.1", 14550)
    assert parse_address("localhost:14550", "") == ("127.0.0.1", 14550)


def test_tunnel_url_has_every_field() -> None:
    url = "dronecan:socketcan/can0?node=68&own=11&serial=3&fd=1&bitrate=500000"
    assert parse_tunnel_url(url) == TunnelUrl("socketcan", "can0", 68, 11, 3, True, 500_000)
    assert parse_tunnel_url("dronecan:pharos-udp?node=68") == TunnelUrl("pharos-udp", "", 68)
    other = parse_tunnel_url("dronecan:pharos-udp/239.65.82.1:57732?node=5")
    assert (other.channel, other.node) == ("239.65.82.1:57732", 5)


@pytest.mark.parametrize("host", ["127.0.0.1", "[::1]", "localhost"])
def test_udp_reaches_a_listener_and_is_answered(host: str) -> None:
    address = "[::1]:0" if host == "[::1]" else "127.0.0.1:0"
    with open_link(f"udpin:{address}") as listener:
        assert isinstance(listener, UdpLink)
        assert not listener.can_send()
        with open_link(f"udp:{host}:{listener.address[1]}") as caller:
            caller.send(b"hello")
            assert _receive(listener, 5) == b"hello"
            assert listener.can_send()
            listener.send(b"welcome")
            assert _receive(caller, 7) == b"welcome"


def test_listener_that_has_heard_nobody_says_so() -> None:
    with open_link("udpin:127.0.0.1:0") as link, pytest.raises(LinkError, match="nobody"):
        link.send(b"hello")


def test_tcp_both_ways() -> None:
    with open_link("tcpin:127.0.0.1:0") as listener:
        assert isinstance(listener, TcpListenLink)
        with open_link(f"tcp:127.0.0.1:{listener.address[1]}") as caller:
            caller.send(b"hello")
            assert _receive(listener, 5) == b"hello"
            listener.send(b"welcome")
            assert _receive(caller, 7) == b"welcome"
        with pytest.raises(LinkError, match="closed by the other side"):
            _receive(listener, 1)


def test_pty_and_serial_are_raw() -> None:
    master, slave = pty.openpty()
    path = os.ttyname(slave)
    try:
        for url in (f"pty:{path}", f"serial:{path},115200", f"{path},57600", path):
            with open_link(url) as link:
                link.send(b"\x03\n\x00")
                assert os.read(master, 10) == b"\x03\n\x00"
                os.write(master, b"\x11\r\xff")
                assert _receive(link, 3) == b"\x11\r\xff"
    finally:
        os.close(master)
        os.close(slave)


def test_speed_that_the_host_does_not_have_is_refused() -> None:
    master, slave = pty.openpty()
    try:
        with pytest.raises(UrlError, match="12345 Bd"):
            open_link(f"serial:{os.ttyname(slave)},12345")
    finally:
        os.close(master)
        os.close(slave)


def test_everything_that_is_raised_is_of_one_root(tmp_path: Path) -> None:
    for url in ("", "tcp:127.0.0.1:1", f"pty:{tmp_path}"):
        with pytest.raises(PharosError):
            open_link(url)


def test_udp_survives_a_peer_that_is_not_there_yet() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with open_link(f"udp:127.0.0.1:{port}") as link:
        for _ in range(3):
            link.send(b"anybody?")
            RealPacer([link]).pump(1000)
        assert link.take() == []
