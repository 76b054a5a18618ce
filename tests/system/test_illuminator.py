# SPDX-License-Identifier: Apache-2.0
"""The illuminator service, rule by rule, over every transport. Origin of the numbers: MAVLink
common.xml and the illuminator protocol's page; see also the rule in each test's name."""

from __future__ import annotations

import struct
from typing import Any

import pytest

from harness import (
    ACCEPTED,
    CODE_TAKES_MS,
    CONFIGURE,
    DENIED,
    EXTERNAL_SYNC,
    FULL_PPM,
    INF,
    INFORMATION,
    INTERNAL,
    NAN,
    ON_OFF,
    REQUEST_MESSAGE,
    SET_MESSAGE_INTERVAL,
    STATE_ACTIVE,
    STATUS,
    Light,
    f32,
    from_light,
    of,
    payload_of,
)

pytestmark = pytest.mark.usefixtures("transport")


def test_heartbeat_comes_once_a_second(light: Light) -> None:
    assert len(of("HEARTBEAT", from_light(light.collect(10)))) == 10


def test_heartbeat_says_illuminator_without_autopilot(light: Light) -> None:
    heartbeat = of("HEARTBEAT", from_light(light.collect(2)))[0]
    assert heartbeat.type == 44  # MAV_TYPE_ILLUMINATOR
    assert heartbeat.autopilot == 8  # MAV_AUTOPILOT_INVALID
    assert heartbeat.system_status == STATE_ACTIVE


def test_component_ids_are_those_of_an_illuminator_and_a_gimbal_by_default(light: Light) -> None:
    assert {m.get_srcComponent() for m in light.collect(3)} == {243, 154}


def test_status_streams_once_a_second_unasked(light: Light) -> None:
    assert len(of("ILLUMINATOR_STATUS", light.collect(10))) == 10


def test_status_has_35_bytes_and_crc_extra_66_in_wire_order(light: Light) -> None:
    assert light.configure(brightness=40, period_s=0.5, duty=25) == ACCEPTED
    status = light.status()
    assert status.crc_extra == 66
    # MAVLink 2 cuts trailing zeros; the last byte is mode = 1, so nothing is cut.
    payload = payload_of(status)
    assert len(payload) == 35
    fields = struct.unpack("<IIffffffBBB", payload)
    assert fields[0] == status.uptime_ms
    assert fields[1] == 0  # error_status
    assert fields[2:5] == (40.0, 0.5, 25.0)
    assert fields[5] == status.temp_c
    assert fields[8:] == (0, 3, 1)  # enable, mode_bitmask, mode


def test_status_uptime_runs_with_time(light: Light) -> None:
    first = light.status().uptime_ms
    light.sim.advance(s=5)
    passed = light.status().uptime_ms - first
    assert 5000 <= passed <= 5000 + CODE_TAKES_MS


def test_status_names_both_modes_and_the_period_range(light: Light) -> None:
    status = light.status()
    assert status.mode_bitmask == 3
    assert status.mode == INTERNAL
    assert 0 < status.min_strobe_period < status.max_strobe_period


# The model's heat sink has a time constant of under two minutes.
SETTLED_S = 900


def test_temperature_follows_the_surroundings(light: Light) -> None:
    light.sim.set_ambient(10)
    light.sim.advance(s=SETTLED_S)
    cool = light.status().temp_c
    light.sim.set_ambient(40)
    light.sim.advance(s=SETTLED_S)
    # The device's own heat stays the same; an NTC's reading errs by less than a degree here.
    assert light.status().temp_c - cool == pytest.approx(30, abs=1)
    assert 10 < cool < 20


def test_lamp_is_off_after_boot(light: Light) -> None:
    assert light.status().enable == 0
    assert light.level_ppm() == 0


def test_on_and_off_are_accepted_and_switch_the_lamp(light: Light) -> None:
    assert light.configure(brightness=100) == ACCEPTED
    assert light.level_ppm() == 0
    assert light.on() == ACCEPTED
    assert light.level_ppm() == FULL_PPM
    assert light.status().enable == 1
    assert light.off() == ACCEPTED
    assert light.level_ppm() == 0
    assert light.status().enable == 0


@pytest.mark.parametrize("value", [0.5, -1.0, 2.0, 1.0000001, NAN, INF, -INF])
def test_on_off_with_anything_but_0_or_1_is_denied_and_nothing_changes(
    light: Light, value: float
) -> None:
    light.on()
    before, level = light.settings(), light.level_ppm()
    assert light.mav.command_long(ON_OFF, value).result == DENIED
    assert light.settings() == before
    assert light.level_ppm() == level


@pytest.mark.parametrize("illuminator_id", [0.0, NAN, 1.0])
def test_on_off_tolerates_an_illuminator_id_in_param2(light: Light, illuminator_id: float) -> None:
    assert light.mav.command_long(ON_OFF, 1, illuminator_id).result == ACCEPTED
    assert light.status().enable == 1


@pytest.mark.parametrize("illuminator_id", [0.0, NAN, 1.0])
def test_configure_tolerates_an_illuminator_id_in_param5(
    light: Light, illuminator_id: float
) -> None:
    ack = light.mav.command_long(CONFIGURE, INTERNAL, 70, 0, 100, illuminator_id)
    assert ack.result == ACCEPTED
    assert light.status().brightness == 70.0


@pytest.mark.parametrize(
    ("brightness", "period_s", "duty"),
    [
        (33.3, 0.123456, 12.3456),
        (0.1, 0.5, 99.9),
        (100.0, 0.0, 0.0),
        (0.0, 1.0, 100.0),
        (1e-7, 0.7654321, 50.00001),
    ],
)
def test_commanded_floats_are_echoed_exactly(
    light: Light, brightness: float, period_s: float, duty: float
) -> None:
    assert light.configure(brightness, period_s, duty) == ACCEPTED
    status = light.status()
    assert status.brightness == f32(brightness)
    assert status.strobe_period == f32(period_s)
    assert status.strobe_duty_cycle == f32(duty)


def _is_denied_and_nothing_changes(light: Light, **bad: float) -> None:
    assert light.configure(brightness=60, period_s=0.5, duty=50) == ACCEPTED
    assert light.on() == ACCEPTED
    before = light.settings()
    assert light.configure(**{"brightness": 10, "period_s": 1.0, "duty": 20, **bad}) == DENIED
    assert light.settings() == before
    # The strobe goes on as it was: 0.5 s, half of it lit.
    light.sim.edges()
    light.sim.advance(s=10)
    assert len(light.sim.edges()) == 40


@pytest.mark.parametrize("mode", [0.0, 3.0, -1.0, 1.5, 255.0, INF])
def test_mode_other_than_1_or_2_is_denied_and_nothing_changes(light: Light, mode: float) -> None:
    _is_denied_and_nothing_changes(light, mode=mode)


def test_nan_mode_is_denied_and_nothing_changes(light: Light) -> None:
    _is_denied_and_nothing_changes(light, mode=NAN)


@pytest.mark.parametrize("brightness", [-0.001, 100.001, 101.0, 1e30, INF, -INF])
def test_brightness_out_of_range_is_denied_and_nothing_changes(
    light: Light, brightness: float
) -> None:
    _is_denied_and_nothing_changes(light, brightness=brightness)


def test_nan_brightness_is_denied_and_nothing_changes(light: Light) -> None:
    _is_denied_and_nothing_changes(light, brightness=NAN)


@pytest.mark.parametrize("period_s", [-0.5, -1e-9, 1e30, INF, -INF])
def test_period_out_of_range_is_denied_and_nothing_changes(light: Light, period_s: float) -> None:
    _is_denied_and_nothing_changes(light, period_s=period_s)


def test_period_just_outside_the_reported_range_is_denied(light: Light) -> None:
    status = light.status()
    for period_s in (status.min_strobe_period * 0.99, status.max_strobe_period * 1.01):
        assert light.configure(period_s=period_s, duty=50) == DENIED


def test_period_at_both_ends_of_the_reported_range_is_accepted(light: Light) -> None:
    status = light.status()
    for period_s in (status.min_strobe_period, status.max_strobe_period):
        assert light.configure(period_s=period_s, duty=50) == ACCEPTED
        assert light.status().strobe_period == f32(period_s)


def test_nan_period_is_denied_and_nothing_changes(light: Light) -> None:
    _is_denied_and_nothing_changes(light, period_s=NAN)


@pytest.mark.parametrize("duty", [-0.001, 100.001, 1e30, INF, -INF])
def test_duty_out_of_range_is_denied_and_nothing_changes(light: Light, duty: float) -> None:
    _is_denied_and_nothing_changes(light, duty=duty)


def test_nan_duty_is_denied_and_nothing_changes(light: Light) -> None:
    _is_denied_and_nothing_changes(light, duty=NAN)


@pytest.mark.parametrize(
    ("period_s", "duty"), [(0.0, 50.0), (0.5, 0.0), (0.5, 100.0), (0.0, 0.0), (0.0, 100.0)]
)
def test_no_strobe_without_a_period_or_with_duty_0_or_100(
    light: Light, period_s: float, duty: float
) -> None:
    assert light.configure(100, period_s, duty) == ACCEPTED
    assert light.on() == ACCEPTED
    light.sim.edges()
    light.sim.advance(s=20)
    assert light.sim.edges() == []
    assert light.level_ppm() == FULL_PPM


def test_strobe_is_lit_for_its_duty(light: Light) -> None:
    assert light.configure(100, period_s=0.2, duty=30) == ACCEPTED
    assert light.on() == ACCEPTED
    light.sim.advance(s=1)
    light.sim.edges()
    light.sim.advance(s=2)
    edges = light.sim.edges()
    assert len(edges) == 20
    lit = [b.time_us - a.time_us for a, b in zip(edges, edges[1:], strict=False) if a.level_ppm]
    assert set(lit) == {60_000}


def test_brightness_0_is_dark_and_more_is_brighter(light: Light) -> None:
    light.on()
    levels = []
    for brightness in (0, 1, 10, 50, 90, 100):
        assert light.configure(brightness) == ACCEPTED
        levels.append(light.level_ppm())
    assert levels[0] == 0
    assert levels[-1] == FULL_PPM
    assert levels == sorted(set(levels))


def test_mode_external_sync_is_reported(light: Light) -> None:
    assert light.configure(mode=EXTERNAL_SYNC) == ACCEPTED
    assert light.status().mode == EXTERNAL_SYNC
    assert light.configure(mode=INTERNAL) == ACCEPTED
    assert light.status().mode == INTERNAL


def test_configure_does_not_switch_the_lamp(light: Light) -> None:
    light.configure(50)
    assert light.status().enable == 0
    light.on()
    light.configure(80)
    assert light.status().enable == 1


def test_settings_survive_off_and_on(light: Light) -> None:
    light.configure(80, 0.5, 25)
    light.on()
    light.off()
    light.on()
    status = light.status()
    assert (status.brightness, status.strobe_period, status.strobe_duty_cycle) == (80, 0.5, 25)


def test_status_reports_commanded_not_throttled_settings(light: Light) -> None:
    light.configure(100)
    light.on()
    light.sim.set_ambient(70)
    for _ in range(360):
        light.sim.advance(s=10)
        if light.level_ppm() not in (0, FULL_PPM):
            break
    assert 0 < light.level_ppm() < FULL_PPM, "70 °C around a full lamp must throttle it"
    assert light.status().brightness == 100.0


def _information(light: Light) -> Any:
    assert light.mav.command_long(REQUEST_MESSAGE, INFORMATION).result == ACCEPTED
    return light.mav.recv("COMPONENT_INFORMATION_BASIC", timeout_us=0)


def test_component_information_comes_only_on_request(light: Light) -> None:
    assert of("COMPONENT_INFORMATION_BASIC", light.collect(60)) == []
    _information(light)
    assert of("COMPONENT_INFORMATION_BASIC", light.collect(60)) == []


def test_component_information_strings_fit_and_are_zero_filled(light: Light) -> None:
    information = _information(light)
    assert information.crc_extra == 50
    payload = payload_of(information).ljust(160, b"\0")
    assert len(payload) == 160
    # capabilities u64, time_boot_ms u32, time_manufacture_s u32, then the strings
    offset = 16
    for size in (32, 32, 24, 24, 32):
        field = payload[offset : offset + size]
        text, _, rest = field.partition(b"\0")
        assert text.isascii()
        assert rest.strip(b"\0") == b"", f"bytes after the end of {text!r}"
        offset += size
    assert information.vendor_name
    assert information.model_name
    assert information.software_version


def test_component_information_says_mavlink2_and_command_int(light: Light) -> None:
    capabilities = _information(light).capabilities
    assert capabilities & 8192  # MAV_PROTOCOL_CAPABILITY_MAVLINK2
    assert capabilities & 8  # MAV_PROTOCOL_CAPABILITY_COMMAND_INT


def test_ack_comes_before_the_requested_message(light: Light) -> None:
    light.mav.drain()
    light.mav.inbox.clear()
    light.mav.send_command_long(REQUEST_MESSAGE, STATUS)
    kinds = [m.get_type() for m in light.mav.pass_time(0)]
    assert kinds == ["COMMAND_ACK", "ILLUMINATOR_STATUS"]


def test_first_status_after_an_ack_shows_the_new_state(light: Light) -> None:
    for enable in (1, 0, 1, 0):
        assert light.mav.command_long(ON_OFF, enable).result == ACCEPTED
        assert light.mav.recv("ILLUMINATOR_STATUS").enable == enable


def test_the_lamp_has_changed_when_the_ack_comes(light: Light) -> None:
    light.configure(100)
    assert light.on() == ACCEPTED  # no time has passed since
    assert light.level_ppm() == FULL_PPM


def test_a_command_gets_exactly_one_ack_and_no_in_progress(light: Light) -> None:
    light.mav.drain()
    light.mav.inbox.clear()
    light.mav.send_command_long(CONFIGURE, INTERNAL, 50, 0, 100)
    acks = of("COMMAND_ACK", light.mav.pass_time(10_000_000))
    assert [(a.command, a.result) for a in acks] == [(CONFIGURE, ACCEPTED)]


def test_interval_minus_1_silences_the_status_on_change_too(light: Light) -> None:
    assert light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, -1).result == ACCEPTED
    light.collect(0)
    light.on()
    light.configure(20)
    light.off()
    assert of("ILLUMINATOR_STATUS", light.collect(60)) == []


def test_interval_0_restores_the_default_rate(light: Light) -> None:
    light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, -1)
    light.collect(5)
    assert light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, 0).result == ACCEPTED
    assert len(of("ILLUMINATOR_STATUS", light.collect(10))) in (10, 11)


def test_status_on_request_comes_even_when_its_stream_is_off(light: Light) -> None:
    light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, -1)
    light.on()
    assert light.status().enable == 1
