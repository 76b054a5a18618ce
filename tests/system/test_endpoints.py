# SPDX-License-Identifier: Apache-2.0
"""A wire whose other end is absent, or goes away, is retried and counted; the light goes on."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from harness import ACCEPTED, WIRES, Light, from_light, light_on, of
from pharos import MavlinkConnection, Simulator
from pharos.link import UdpLink


@pytest.fixture
def server() -> Iterator[socket.socket]:
    """A bound TCP socket that does not listen yet: connecting to it is refused."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        yield listener


def _endpoint(listener: socket.socket) -> str:
    return f"tcp:127.0.0.1:{listener.getsockname()[1]}"


def _errors(sim: Simulator, name: str) -> int:
    return int(sim.request("wires")["wires"][name]["errors"])


def test_refused_tcp_is_retried_and_counted(
    start: Callable[..., Simulator], server: socket.socket
) -> None:
    sim = start({"uart0": WIRES["udp"], "uart1": _endpoint(server)})
    light = light_on(sim)
    sim.advance(s=30)
    first = _errors(sim, "uart1")
    assert first >= 1
    sim.advance(s=60)
    assert _errors(sim, "uart1") > first
    assert light.on() == ACCEPTED


def test_tcp_server_that_appears_later_is_found(
    start: Callable[..., Simulator], server: socket.socket
) -> None:
    sim = start({"uart0": WIRES["udp"], "uart1": _endpoint(server)})
    sim.advance(s=10)
    server.listen()
    server.settimeout(10)
    sim.advance(s=60)
    peer, _ = server.accept()
    with peer:
        peer.settimeout(10)
        sim.advance(s=3)
        assert peer.recv(1)[0] in (0xFD, 0xFE)


def test_tcp_server_that_goes_away_is_reconnected(
    start: Callable[..., Simulator], server: socket.socket
) -> None:
    server.listen()
    server.settimeout(10)
    sim = start({"uart0": WIRES["udp"], "uart1": _endpoint(server)})
    sim.advance(s=10)
    server.accept()[0].close()
    sim.advance(s=60)
    server.accept()[0].close()
    assert light_on(sim).on() == ACCEPTED


def test_udp_port_in_use_is_retried_until_it_is_free(start: Callable[..., Simulator]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        sim = start({"uart0": WIRES["udp"], "uart1": f"udpin:127.0.0.1:{port}"})
        sim.advance(s=30)
        assert _errors(sim, "uart1") >= 1
    sim.advance(s=30)
    assert sim.connect("uart1").command_long(405, 1).result == ACCEPTED


def test_udp_peer_that_refuses_is_no_error_of_the_light(start: Callable[..., Simulator]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as closed:
        closed.bind(("127.0.0.1", 0))
        port = closed.getsockname()[1]
    sim = start({"uart0": WIRES["udp"], "uart1": f"udpout:127.0.0.1:{port}"})
    light = light_on(sim)
    sim.advance(s=60)
    assert light.on() == ACCEPTED


def test_udpout_speaks_first_and_takes_answers(start: Callable[..., Simulator]) -> None:
    link = UdpLink(bind=("127.0.0.1", 0))
    host, port = link.address
    sim = start({"uart0": f"udpout:{host}:{port}"})
    sim.attach("uart0", link, from_start=True)
    sim.advance(s=3)
    mav = MavlinkConnection(link, sim, sim.dialect)
    mav.recv("HEARTBEAT")
    assert mav.command_long(405, 1).result == ACCEPTED


def test_udppair_receives_on_one_port_and_sends_to_the_other(
    start: Callable[..., Simulator],
) -> None:
    ear = UdpLink(bind=("127.0.0.1", 0))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    sim = start({"uart0": f"udppair:127.0.0.1:{port},127.0.0.1:{ear.address[1]}"})
    sim.attach("uart0", ear, from_start=True)
    sim.advance(s=3)
    assert ear.received > 0
    mouth = UdpLink(peer=("127.0.0.1", port))
    talker = MavlinkConnection(mouth, sim, sim.dialect)
    talker.send_command_long(405, 1)
    ear.sent = mouth.sent  # the wire has been sent this much, from another socket
    sim.advance(s=1)
    assert mouth.poll(0.0) is False, "the answer must not go to where the command came from"
    listener = MavlinkConnection(ear, sim, sim.dialect)
    assert listener.recv("COMMAND_ACK").result == ACCEPTED
    mouth.close()


def test_pty_whose_reader_hangs_up_can_be_opened_again(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["pty"]})
    assert light_on(sim).on() == ACCEPTED
    sim.detach("uart0")
    sim.advance(s=600)
    assert light_on(sim).status().enable == 1


def test_pty_link_is_removed_at_the_end(start: Callable[..., Simulator], tmp_path: Path) -> None:
    path = tmp_path / "tty"
    sim = start({"uart0": f"pty:{path}"})
    assert path.is_symlink()
    assert sim.quit() == 0
    assert not path.is_symlink()


def test_serial_device_that_is_absent_is_retried_and_counted(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    sim = start({"uart0": WIRES["udp"], "uart1": f"serial:{tmp_path}/absent,57600"})
    light = light_on(sim)
    sim.advance(s=30)
    assert _errors(sim, "uart1") >= 1
    assert light.on() == ACCEPTED


def test_serial_device_that_appears_later_is_used(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    import os
    import tty

    path = tmp_path / "ttyUSB0"
    sim = start({"uart0": WIRES["udp"], "uart1": f"serial:{path},57600"})
    sim.advance(s=5)
    master, slave = os.openpty()
    tty.setraw(slave)
    path.symlink_to(os.ttyname(slave))
    sim.advance(s=30)
    os.set_blocking(master, False)
    assert os.read(master, 1)[0] in (0xFD, 0xFE)
    os.close(slave)
    os.close(master)
    sim.advance(s=30)
    light: Light = light_on(sim)
    assert light.on() == ACCEPTED
    assert len(of("HEARTBEAT", from_light(light.collect(3)))) == 3
