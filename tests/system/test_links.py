# SPDX-License-Identifier: Apache-2.0
"""Several wires at once, and wires that lose, flip and double bytes."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import pytest

from harness import (
    ACCEPTED,
    CONFIGURE,
    DENIED,
    INFORMATION,
    INTERNAL,
    ON_OFF,
    REQUEST_MESSAGE,
    STATUS,
    WIRES,
    Light,
    from_light,
    light_on,
    of,
)
from pharos import MavlinkConnection, SilentError, Simulator, Source

FOUR = {
    "uart0": WIRES["udp"],
    "uart1": WIRES["tcp"],
    "uart2": "pty:{folder}/uart2",
    "uart3": WIRES["udp"],
}


@pytest.fixture
def four(start: Callable[..., Simulator]) -> tuple[Simulator, list[MavlinkConnection]]:
    sim = start(FOUR)
    clients = [
        sim.connect(name, Source(255, 190 + index)) for index, name in enumerate(sorted(FOUR))
    ]
    for client in clients:
        client.heartbeat()
    sim.advance(s=1)
    for client in clients:
        client.pass_time(0)
    return sim, clients


def test_each_of_four_links_gets_heartbeat_and_status(
    four: tuple[Simulator, list[MavlinkConnection]],
) -> None:
    sim, clients = four
    sim.advance(s=10)
    for client in clients:
        came = client.pass_time(0)
        assert len(of("HEARTBEAT", from_light(came))) == 10
        assert len(of("ILLUMINATOR_STATUS", came)) == 10


def test_each_link_has_its_own_sequence_numbers(
    four: tuple[Simulator, list[MavlinkConnection]],
) -> None:
    sim, clients = four
    for count, client in enumerate(clients, start=1):
        for _ in range(count):
            assert client.command_long(REQUEST_MESSAGE, STATUS).result == ACCEPTED
    sim.advance(s=5)
    for client in clients:
        client.drain()
        for component in (243, 154):
            numbers = [m.get_seq() for m in from_light(client.history, component)]
            assert {(b - a) % 256 for a, b in pairwise(numbers)} == {1}


def test_answer_goes_to_the_link_that_asked_and_to_no_other(
    four: tuple[Simulator, list[MavlinkConnection]],
) -> None:
    sim, clients = four
    for asking in clients:
        assert asking.command_long(ON_OFF, 1).result == ACCEPTED
        for other in clients:
            if other is not asking:
                assert of("COMMAND_ACK", other.pass_time(0)) == []


def test_all_four_links_command_at_once(
    four: tuple[Simulator, list[MavlinkConnection]],
) -> None:
    sim, clients = four
    for round_ in range(50):
        for client in clients:
            client.send_command_long(CONFIGURE, INTERNAL, round_, 0, 100)
    sim.advance(s=1)
    for client in clients:
        acks = of("COMMAND_ACK", client.pass_time(0))
        assert [a.result for a in acks] == [ACCEPTED] * 50


def test_each_link_keeps_its_own_protocol_version(start: Callable[..., Simulator]) -> None:
    sim = start(FOUR)
    clients = {name: sim.connect(name) for name in sorted(FOUR)}
    clients["uart1"].version = 1
    for client in clients.values():
        client.heartbeat()
    sim.advance(s=5)
    for name, client in clients.items():
        ack = client.command_long(ON_OFF, 0)
        assert ack.get_msgbuf()[0] == (0xFE if name == "uart1" else 0xFD)


@pytest.mark.parametrize(
    ("param7", "who"), [(0.0, "asker"), (1.0, "asker"), (math.nan, "asker"), (2.0, "all")]
)
def test_param7_says_who_gets_the_requested_message(
    four: tuple[Simulator, list[MavlinkConnection]], param7: float, who: str
) -> None:
    sim, clients = four
    for client in clients:
        ack = client.command_long(REQUEST_MESSAGE, INFORMATION, 0, 0, 0, 0, 0, param7)
        assert ack.result == ACCEPTED
        for other in clients:
            got = len(of("COMPONENT_INFORMATION_BASIC", other.pass_time(0)))
            assert got == (1 if other is client or who == "all" else 0)


def test_unknown_param7_is_denied(light: Light) -> None:
    for param7 in (3, -1, 0.5, math.inf):
        ack = light.mav.command_long(REQUEST_MESSAGE, STATUS, 0, 0, 0, 0, 0, param7)
        assert ack.result == DENIED


def test_several_tcp_clients_are_served(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["tcp"]})
    light = light_on(sim)
    assert light.on() == ACCEPTED
    sim.detach("uart0")
    sim.advance(s=3)
    again = light_on(sim)
    assert again.status().enable == 1


def _on_with_retries(light: Light, enable: int, tries: int = 30) -> int:
    for attempt in range(1, tries + 1):
        try:
            ack = light.mav.command_long(
                ON_OFF, enable, confirmation=min(attempt - 1, 255), timeout_us=200_000
            )
        except SilentError:
            continue
        assert ack.result == ACCEPTED
        return attempt
    raise AssertionError(f"no answer to {tries} tries")


# What bytes can meet; what frames on a CAN bus can is in test_can_faults.py.
@pytest.mark.parametrize("transport", sorted(WIRES), indirect=True)
@pytest.mark.parametrize("kind", ["lost", "flipped", "doubled"])
def test_commands_are_answered_on_retry_over_a_bad_wire(light: Light, kind: str) -> None:
    # 1 % of bytes: about every third command of 44 bytes is hit.
    light.sim.fault("uart0", kind, rate_ppm=10_000)
    tries = [_on_with_retries(light, index % 2) for index in range(60)]
    assert max(tries) > 1, "the fault hit nothing"
    light.sim.fault("uart0", kind, rate_ppm=0)
    light.sim.advance(s=1)
    light.mav.pass_time(0)
    assert light.on() == ACCEPTED


@pytest.mark.parametrize("transport", sorted(WIRES), indirect=True)
def test_a_flipped_byte_is_never_taken_for_a_command(light: Light) -> None:
    light.sim.fault("uart0", "flipped", rate_ppm=30_000)
    for _ in range(300):
        light.mav.send_command_long(CONFIGURE, INTERNAL, 42, 0, 100)
        light.sim.advance(10_000)
    light.sim.fault("uart0", "flipped", rate_ppm=0)
    light.sim.advance(s=1)
    light.mav.pass_time(0)
    settings = light.settings()
    assert settings["enable"] == 0
    assert settings["brightness"] == 42.0
    assert settings["mode"] == INTERNAL
