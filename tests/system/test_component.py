# SPDX-License-Identifier: Apache-2.0
"""Being a component of a vehicle: versions, links, time, what is said to people, capabilities.

Parameters, the system id, link loss, signing, routing, metadata and the gimbal have files of their
own."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest

from harness import (
    ACCEPTED,
    BUS,
    INFORMATION,
    ON_OFF,
    REQUEST_MESSAGE,
    SECOND_US,
    STATUS,
    WIRES,
    Light,
    light_on,
    of,
    texts,
)
from parameters import OF_GIMBAL, OF_LIGHT, ask_list, set_param
from pharos import MavlinkConnection, Simulator, Source, Target, Tunnel

ILLUMINATOR = 243  # MAV_COMP_ID_ILLUMINATOR
AUTOPILOT_VERSION = 148
PROTOCOL_VERSION = 300

# MAV_PROTOCOL_CAPABILITY
COMMAND_INT = 8
PARAM_ENCODE_BYTEWISE = 16
MAVLINK2 = 8192

V1, V2 = 0xFE, 0xFD

LONG_IDS = {
    PROTOCOL_VERSION: "PROTOCOL_VERSION",
    INFORMATION: "COMPONENT_INFORMATION_BASIC",
    STATUS: "ILLUMINATOR_STATUS",
}


def heartbeats(messages: list[Any]) -> list[Any]:
    """Of the illuminator; the gimbal has its own."""
    return [m for m in of("HEARTBEAT", messages) if m.get_srcComponent() == ILLUMINATOR]


def version_of(message: Any) -> int:
    return int(bytes(message.get_msgbuf())[0])


# --- MAVLink 1 ------------------------------------------------------------------------------------
@pytest.fixture
def old(light: Light) -> Light:
    """A light whose peer has only ever spoken MAVLink 1."""
    light.sim.reset()
    light.mav.version = 1
    light.greet()
    return light


def test_a_mavlink_1_peer_hears_mavlink_1_and_no_id_above_255(old: Light) -> None:
    came = old.collect(5)
    assert {version_of(m) for m in came} == {V1}
    assert {m.get_type() for m in came} <= {"HEARTBEAT", "STATUSTEXT"}
    assert len(heartbeats(came)) == 5


def test_a_mavlink_1_peer_gets_what_it_asks_for_in_the_version_that_carries_it(old: Light) -> None:
    """The handshake of MAVLink's guide: PROTOCOL_VERSION asked for in 1 is answered in 2."""
    for message, name in LONG_IDS.items():
        ack = old.mav.command_long(REQUEST_MESSAGE, message)
        assert (ack.result, version_of(ack)) == (ACCEPTED, V1)
        assert version_of(old.mav.recv(name, timeout_us=0)) == V2
    assert old.mav.command_long(REQUEST_MESSAGE, AUTOPILOT_VERSION).result == ACCEPTED
    version = old.mav.recv("AUTOPILOT_VERSION", timeout_us=0)
    assert (version_of(version), version.capabilities & MAVLINK2) == (V1, MAVLINK2)
    assert old.on() == ACCEPTED
    assert old.level_ppm() > 0
    assert {version_of(m) for m in old.collect(3)} == {V1}


def test_the_first_mavlink_2_frame_ends_mavlink_1(old: Light) -> None:
    old.mav.version = 2
    old.mav.heartbeat()
    old.sim.advance(s=1)
    came = old.collect(3)
    assert {version_of(m) for m in came} == {V2}
    assert len(of("ILLUMINATOR_STATUS", came)) == 3
    # and MAVLink 1 frames after that do not bring it back
    old.mav.version = 1
    assert version_of(old.mav.command_long(ON_OFF, 1)) == V2


# --- links ----------------------------------------------------------------------------------------
def test_answers_go_where_the_question_came_from_and_broadcasts_everywhere(
    start: Callable[..., Simulator],
) -> None:
    """A UDP wire, a pseudo-terminal and the tunnel over CAN, at the same time."""
    sim = start({"uart0": WIRES["udp"], "uart1": "pty:{folder}/uart1", "can0": BUS})
    peers = {
        "udp": sim.connect("uart0", Source(255, 190)),
        "pty": sim.connect("uart1", Source(254, 190)),
        "can": sim.connect("can0", Source(253, 190), tunnel=Tunnel()),
    }
    for peer in peers.values():
        peer.heartbeat()
    sim.advance(s=2)
    for name, peer in peers.items():
        _empty(peers)
        peer.send_command_long(ON_OFF, 1)
        sim.advance(100_000)
        for other, its in peers.items():
            its.drain()
            acks = of("COMMAND_ACK", list(its.inbox))
            assert len(acks) == (1 if other == name else 0), (name, other)
    _empty(peers)
    sim.advance(s=3)
    for name, peer in peers.items():
        peer.drain()
        assert len(heartbeats(list(peer.inbox))) == 3, name
    # what people are told goes to all as well
    _empty(peers)
    sim.fault("thermistor", "open")
    sim.advance(s=2)
    for name, peer in peers.items():
        peer.drain()
        assert texts(list(peer.inbox)) == ["Temperature sensor failed: open"], name


def _empty(peers: dict[str, MavlinkConnection]) -> None:
    for peer in peers.values():
        peer.drain()
        peer.inbox.clear()


# --- time -----------------------------------------------------------------------------------------
def test_ping_to_all_is_answered_to_the_asker(light: Light) -> None:
    d = light.mav.dialect
    light.mav.send(d.MAVLink_ping_message(1_234_567, 9, 0, 0))
    answer = light.mav.recv("PING")
    assert (answer.time_usec, answer.seq) == (1_234_567, 9)
    assert (answer.target_system, answer.target_component) == (255, 190)


def test_an_answered_ping_is_not_answered(light: Light) -> None:
    d = light.mav.dialect
    light.mav.send(d.MAVLink_ping_message(1_234_567, 9, 1, 243))
    light.mav.send(d.MAVLink_ping_message(1_234_567, 9, 2, 1))
    assert of("PING", light.collect(1)) == []


def test_timesync_is_answered_with_our_clock_and_theirs_mirrored(light: Light) -> None:
    d = light.mav.dialect
    begin_us = light.sim.now_us()
    light.mav.send(d.MAVLink_timesync_message(0, 987_654_321_000))
    answer = light.mav.recv("TIMESYNC")
    assert answer.ts1 == 987_654_321_000
    assert begin_us * 1000 <= answer.tc1 <= light.sim.now_us() * 1000


def test_an_answered_timesync_is_not_answered(light: Light) -> None:
    d = light.mav.dialect
    light.mav.send(d.MAVLink_timesync_message(5, 987_654_321_000))
    assert of("TIMESYNC", light.collect(1)) == []


# --- who it is ------------------------------------------------------------------------------------
def test_protocol_version_comes_on_request(light: Light) -> None:
    assert of("PROTOCOL_VERSION", light.collect(2)) == []
    assert light.mav.command_long(REQUEST_MESSAGE, PROTOCOL_VERSION).result == ACCEPTED
    said = light.mav.recv("PROTOCOL_VERSION", timeout_us=0)
    assert (said.version, said.min_version, said.max_version) == (200, 100, 200)


def test_capabilities_are_the_same_in_both_messages(light: Light) -> None:
    assert light.mav.command_long(REQUEST_MESSAGE, INFORMATION).result == ACCEPTED
    basic = light.mav.recv("COMPONENT_INFORMATION_BASIC", timeout_us=0).capabilities
    assert light.mav.command_long(REQUEST_MESSAGE, AUTOPILOT_VERSION).result == ACCEPTED
    assert light.mav.recv("AUTOPILOT_VERSION", timeout_us=0).capabilities == basic
    assert basic & COMMAND_INT
    assert basic & PARAM_ENCODE_BYTEWISE
    assert basic & MAVLINK2


def test_the_set_of_parameters_is_fixed_after_boot(light: Light) -> None:
    def names() -> list[str]:
        ask_list(light.mav)
        came = of("PARAM_VALUE", light.collect(4))
        return [m.param_id for m in sorted(came, key=lambda m: int(m.param_index))]

    before = names()
    assert all(0 < len(name) <= 16 for name in before)
    set_param(light, "LGT_PROGRAM", 2)
    set_param(light, "MAV_COMPID", 200)
    assert names() == before


def test_the_gimbal_serves_its_own_parameters(light: Light) -> None:
    """Ground stations keep a table for each component that they hear: each is complete in itself,
    and what decides whether there is a gimbal is the light's."""
    tables = {}
    for component in (154, ILLUMINATOR):
        ask_list(light.mav, Target(1, component))
        came = of("PARAM_VALUE", light.collect(4))
        assert {m.get_srcComponent() for m in came} == {component}
        assert sorted(m.param_index for m in came) == list(range(came[0].param_count))
        tables[component] = {m.param_id for m in came}
    assert tables == {154: OF_GIMBAL, ILLUMINATOR: OF_LIGHT}


# --- what people are told -------------------------------------------------------------------------
@pytest.mark.parametrize("transport", sorted(WIRES), indirect=True)  # no tunnel is open at boot
def test_boot_is_told_once(light: Light) -> None:
    light.mav.drain()
    light.mav.inbox.clear()
    light.sim.reset()
    came = light.mav.pass_time(60 * SECOND_US)
    assert [re.sub(r"\d+\.\d+\.\d+", "N", t) for t in texts(came)] == ["Pharos N: reset pin"]
    assert of("STATUSTEXT", came)[0].severity == 6  # MAV_SEVERITY_INFO


def test_texts_come_in_a_burst_of_four_then_one_in_two_seconds(light: Light) -> None:
    """The sensor fails and heals again and again, which is four kinds of news in turn."""
    light.sim.advance(s=20)
    light.mav.drain()
    light.mav.inbox.clear()
    kinds = ("open", "none", "short", "none")
    came: list[str] = []
    for second in range(60):
        light.sim.fault("thermistor", kinds[second % 4])
        came += texts(light.mav.pass_time(SECOND_US))
    assert 4 <= len(came) <= 4 + 60 // 2
    # and the same is no news within ten seconds
    assert max(came.count(text) for text in set(came)) <= 1 + 60 // 10


def test_a_status_text_names_its_severity(udp_light: Light) -> None:
    udp_light.sim.fault("thermistor", "open")
    message = udp_light.mav.recv("STATUSTEXT", timeout_us=5 * SECOND_US)
    assert message.severity == 3  # MAV_SEVERITY_ERROR


def test_our_own_frames_that_come_back_are_not_obeyed(start: Callable[..., Simulator]) -> None:
    light = light_on(start({"uart0": WIRES["udp"]}))
    echo = MavlinkConnection(
        light.mav.link, light.sim, light.mav.dialect, Source(1, 243), Target(1, 243)
    )
    echo.send_command_long(ON_OFF, 1)
    assert of("COMMAND_ACK", light.collect(1)) == []
    assert light.level_ppm() == 0
