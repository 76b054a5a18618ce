# SPDX-License-Identifier: Apache-2.0
"""The command protocol, rule by rule, over every transport (https://mavlink.io/en/services/command.html
and the facts the project gathered)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import pytest

from harness import (
    ACCEPTED,
    COMPONENTS,
    CONFIGURE,
    DENIED,
    FULL_PPM,
    GET_MESSAGE_INTERVAL,
    HEARTBEAT,
    INF,
    INFORMATION,
    INTERNAL,
    MESSAGE_INTERVAL,
    NAN,
    ON_OFF,
    REQUEST_MESSAGE,
    SET_MESSAGE_INTERVAL,
    STATUS,
    UNSUPPORTED,
    Light,
    Transport,
    connect,
    f32,
    from_light,
    of,
)
from pharos import Simulator, Source, Target

GIMBAL_DEVICE_INFORMATION = 283
COMPONENT_METADATA_OF_QGC = 280  # GIMBAL_MANAGER_INFORMATION, what QGroundControl asks everyone for
DO_SET_SERVO = 183
COMPONENT_ARM_DISARM = 400
PREFLIGHT_REBOOT_SHUTDOWN = 246
ATTITUDE = 30
UNKNOWN_COMMAND = 31_999
UNKNOWN_MESSAGE = 1_234_567


def test_ack_names_the_senders_ids(light: Light) -> None:
    light.mav.source = Source(77, 88)
    light.mav.encoder.srcSystem, light.mav.encoder.srcComponent = 77, 88
    ack = light.mav.command_long(ON_OFF, 1)
    assert (ack.target_system, ack.target_component) == (77, 88)


@pytest.mark.parametrize("target", [Target(0, 0), Target(1, 0), Target(0, 243), Target(1, 243)])
def test_command_to_us_or_to_all_is_answered(light: Light, target: Target) -> None:
    assert light.mav.command_long(ON_OFF, 1, target=target).result == ACCEPTED
    assert light.mav.command_int(ON_OFF, 0, target=target).result == ACCEPTED


@pytest.mark.parametrize("target", [Target(2, 243), Target(1, 1), Target(1, 155), Target(2, 0)])
def test_command_to_someone_else_meets_silence_and_changes_nothing(
    light: Light, target: Target
) -> None:
    before = light.settings()
    light.collect(0)
    light.mav.send_command_long(ON_OFF, 1, target=target)
    light.mav.send_command_int(CONFIGURE, INTERNAL, 1, 0, 100, target=target)
    light.mav.send_command_long(UNKNOWN_COMMAND, target=target)
    assert of("COMMAND_ACK", light.mav.pass_time(5_000_000)) == []
    assert light.settings() == before
    assert light.level_ppm() == 0


@pytest.mark.parametrize("command", [UNKNOWN_COMMAND, DO_SET_SERVO, 0, 65535])
def test_unknown_command_is_unsupported(light: Light, command: int) -> None:
    assert light.mav.command_long(command, 1).result == UNSUPPORTED
    assert light.mav.command_int(command, 1).result == UNSUPPORTED


@pytest.mark.parametrize(
    "command",
    [
        (UNKNOWN_COMMAND,),
        (COMPONENT_ARM_DISARM, 1),
        (REQUEST_MESSAGE, UNKNOWN_MESSAGE),
        (SET_MESSAGE_INTERVAL, ATTITUDE, 100_000),
        (PREFLIGHT_REBOOT_SHUTDOWN, 1),
    ],
)
def test_what_is_unknown_meets_silence_when_all_are_asked(
    light: Light, command: tuple[int, ...]
) -> None:
    """MAVSDK ends a command to component 0 at the first acknowledgement of the system."""
    light.collect(0)
    for target in (Target(0, 0), Target(1, 0)):
        light.mav.send_command_long(*command, target=target)
        light.mav.send_command_int(*command, target=target)
        assert of("COMMAND_ACK", light.mav.pass_time(5_000_000)) == []
    assert light.mav.command_long(*command).result in (UNSUPPORTED, DENIED)


def test_command_int_switches_and_configures_like_command_long(light: Light) -> None:
    assert light.mav.command_int(CONFIGURE, INTERNAL, 33.3, 0, 100).result == ACCEPTED
    assert light.mav.command_int(ON_OFF, 1).result == ACCEPTED
    status = light.status()
    assert (status.enable, status.brightness) == (1, f32(33.3))
    assert light.mav.command_int(CONFIGURE, INTERNAL, NAN, 0, 100).result == DENIED
    assert light.mav.command_int(REQUEST_MESSAGE, STATUS).result == ACCEPTED
    light.mav.recv("ILLUMINATOR_STATUS", timeout_us=0)


@pytest.mark.parametrize("confirmation", [0, 1, 255])
def test_repeated_command_is_done_once_and_acknowledged_each_time(
    light: Light, confirmation: int
) -> None:
    light.configure(100)
    light.sim.edges()
    for _ in range(5):
        ack = light.mav.command_long(ON_OFF, 1, confirmation=confirmation)
        assert ack.result == ACCEPTED
    assert [e.level_ppm for e in light.sim.edges()] == [FULL_PPM]


def test_repeated_configure_does_not_restart_the_strobe(light: Light) -> None:
    light.configure(100, 1.0, 50)
    light.on()
    light.sim.advance(s=2)
    light.sim.edges()
    for _ in range(30):
        assert light.configure(100, 1.0, 50) == ACCEPTED
        light.sim.advance(130_000)
    edges = light.sim.edges()
    assert {b.time_us - a.time_us for a, b in zip(edges, edges[1:], strict=False)} == {500_000}


def test_the_same_sequence_number_is_not_taken_for_a_repetition(light: Light) -> None:
    for enable in (1, 0, 1):
        light.mav.encoder.seq = 7
        assert light.mav.command_long(ON_OFF, enable).result == ACCEPTED
        assert light.status().enable == enable


def test_request_for_a_message_we_lack_is_denied_once_each_time(light: Light) -> None:
    for message in (COMPONENT_METADATA_OF_QGC, UNKNOWN_MESSAGE, GIMBAL_DEVICE_INFORMATION):
        for _ in range(3):
            light.collect(0)
            light.mav.send_command_long(REQUEST_MESSAGE, message)
            acks = of("COMMAND_ACK", light.mav.pass_time(1_000_000))
            assert [(a.command, a.result) for a in acks] == [(REQUEST_MESSAGE, DENIED)]


@pytest.mark.parametrize("message", [NAN, INF, -1.0, 440.5, 1e9])
def test_request_for_no_message_id_is_denied(light: Light, message: float) -> None:
    assert light.mav.command_long(REQUEST_MESSAGE, message).result == DENIED


@pytest.mark.parametrize("message", [HEARTBEAT, STATUS, INFORMATION])
def test_requested_message_follows_its_ack_at_once(light: Light, message: int) -> None:
    light.collect(0)
    light.mav.send_command_long(REQUEST_MESSAGE, message)
    assert [m.get_msgId() for m in light.mav.pass_time(0)] == [77, message]  # 77: COMMAND_ACK


@pytest.mark.parametrize("interval_us", [100_000, 250_000, 2_000_000])
def test_set_message_interval_changes_the_rate(light: Light, interval_us: int) -> None:
    ack = light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, interval_us)
    assert ack.result == ACCEPTED
    light.collect(2)
    expected = 20_000_000 // interval_us
    assert abs(len(of("ILLUMINATOR_STATUS", light.collect(20))) - expected) <= 1


@pytest.mark.parametrize("interval_us", [-2.0, -0.5, -1e6, NAN, INF, -INF])
def test_wrong_interval_is_denied_and_the_rate_stays(light: Light, interval_us: float) -> None:
    assert light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, interval_us).result == DENIED
    assert len(of("ILLUMINATOR_STATUS", light.collect(10))) == 10


@pytest.mark.parametrize("message", [UNKNOWN_MESSAGE, NAN, -1.0, 440.5])
def test_interval_for_a_message_we_lack_is_denied(light: Light, message: float) -> None:
    assert light.mav.command_long(SET_MESSAGE_INTERVAL, message, 1_000_000).result == DENIED


def _interval_of(light: Light, message: int) -> int:
    assert light.mav.command_long(GET_MESSAGE_INTERVAL, message).result == ACCEPTED
    answer = light.mav.recv("MESSAGE_INTERVAL", timeout_us=0)
    assert answer.message_id == message
    return int(answer.interval_us)


def test_get_message_interval_tells_the_interval_minus_1_when_off(light: Light) -> None:
    assert _interval_of(light, STATUS) == 1_000_000
    light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, 200_000)
    assert _interval_of(light, STATUS) == 200_000
    light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, -1)
    assert _interval_of(light, STATUS) == -1
    light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, 0)
    assert _interval_of(light, STATUS) == 1_000_000


def test_get_message_interval_of_a_message_we_lack_tells_0(light: Light) -> None:
    light.mav.send_command_long(GET_MESSAGE_INTERVAL, 30)  # ATTITUDE: no illuminator has it
    answer = light.mav.recv("MESSAGE_INTERVAL", timeout_us=0)
    assert (answer.message_id, answer.interval_us) == (30, 0)


def test_request_message_244_tells_the_interval_of_param2(light: Light) -> None:
    light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, 300_000)
    ack = light.mav.command_long(REQUEST_MESSAGE, MESSAGE_INTERVAL, STATUS)
    assert ack.result == ACCEPTED
    answer = light.mav.recv("MESSAGE_INTERVAL", timeout_us=0)
    assert (answer.message_id, answer.interval_us) == (STATUS, 300_000)


def test_a_burst_of_commands_is_answered_one_by_one_in_order(light: Light) -> None:
    light.collect(0)
    commands = [ON_OFF, UNKNOWN_COMMAND, CONFIGURE, ON_OFF, REQUEST_MESSAGE, ON_OFF]
    for command in commands:
        light.mav.send_command_long(command, 1, 50, 0, 100)
    acks = of("COMMAND_ACK", light.mav.pass_time(0))
    assert [a.command for a in acks] == commands


def test_mavlink1_client_is_answered_in_mavlink1_until_it_speaks_mavlink2(
    start: Callable[..., Simulator], transport: Transport
) -> None:
    sim = start({transport.wire: transport.address})
    mav = connect(sim, transport)
    mav.version = 1
    mav.heartbeat()
    assert mav.command_long(ON_OFF, 1).get_msgbuf()[0] == 0xFE
    mav.pass_time(5_000_000)
    assert mav.command_long(ON_OFF, 0).get_msgbuf()[0] == 0xFE
    mav.version = 2
    assert mav.command_long(ON_OFF, 1).get_msgbuf()[0] == 0xFD
    mav.pass_time(0)
    assert mav.recv("HEARTBEAT").get_msgbuf()[0] == 0xFD


def test_sequence_numbers_on_a_link_have_no_gap(light: Light) -> None:
    light.collect(0)
    for _ in range(20):
        light.on()
        light.status()
    light.sim.advance(s=300)
    light.mav.drain()
    for component in COMPONENTS:
        sequence = [m.get_seq() for m in from_light(light.mav.history, component)]
        assert len(sequence) > 300
        assert {(b - a) % 256 for a, b in pairwise(sequence)} == {1}


def test_noise_between_frames_loses_no_command(light: Light) -> None:
    light.mav.link.send(bytes(range(256)) + b"\xfd\xff\xfe\x00\xfd")
    assert light.mav.command_long(ON_OFF, 1, timeout_us=100_000).result == ACCEPTED


def test_frame_after_a_false_start_is_found_by_rescanning(light: Light) -> None:
    # The false start claims 255 bytes of payload and so spans the frames behind it.
    light.mav.link.send(b"\xfd\xff\x00\x00\x07\xff\xbe\x4c\x00\x00")
    light.collect(0)
    for _ in range(12):
        light.mav.send_command_long(ON_OFF, 1)
    acks = of("COMMAND_ACK", light.mav.pass_time(1_000_000))
    assert len(acks) == 12


@pytest.mark.parametrize("apart_us", [100, 40_000])
def test_command_in_single_bytes_is_answered_with_its_last(light: Light, apart_us: int) -> None:
    message = light.mav.dialect.MAVLink_command_long_message(1, 243, ON_OFF, 0, 1, *[0] * 6)
    *first, last = light.mav.encode(message)
    light.collect(0)
    for byte in first:
        light.mav.link.send(bytes([byte]))
        assert of("COMMAND_ACK", light.mav.pass_time(apart_us)) == []
    light.mav.link.send(bytes([last]))
    assert len(of("COMMAND_ACK", light.mav.pass_time(1000))) == 1


def test_command_in_single_bytes_behind_a_false_start_waits_for_silence(light: Light) -> None:
    light.mav.link.send(b"\xfd\xff\x00\x00\x07\xff\xbe\x4c\x00\x00")
    message = light.mav.dialect.MAVLink_command_long_message(1, 243, ON_OFF, 0, 1, *[0] * 6)
    light.collect(0)
    for byte in light.mav.encode(message):
        light.mav.link.send(bytes([byte]))
        assert of("COMMAND_ACK", light.mav.pass_time(20_000)) == []
    # 50 ms of silence, of which 20 have passed, and up to 10 until it is noticed
    assert of("COMMAND_ACK", light.mav.pass_time(29_000)) == []
    assert len(of("COMMAND_ACK", light.mav.pass_time(12_000))) == 1


def test_90_good_of_100_frames_with_10_wrong_lengths_are_answered(light: Light) -> None:
    light.collect(0)
    for index in range(100):
        frame = bytearray(
            light.mav.encode(
                light.mav.dialect.MAVLink_command_long_message(1, 243, ON_OFF, 0, 1, *[0] * 6)
            )
        )
        if index % 10 == 3:
            frame[1] = (frame[1] + 17) % 256
        light.mav.link.send(bytes(frame))
    acks = of("COMMAND_ACK", light.mav.pass_time(1_000_000))
    assert len(acks) >= 90


def test_frame_with_a_wrong_checksum_is_ignored(light: Light) -> None:
    message = light.mav.dialect.MAVLink_command_long_message(1, 243, ON_OFF, 0, 1, *[0] * 6)
    frame = bytearray(light.mav.encode(message))
    frame[-1] ^= 0x01
    light.collect(0)
    light.mav.link.send(bytes(frame))
    assert of("COMMAND_ACK", light.mav.pass_time(2_000_000)) == []
    assert light.status().enable == 0
