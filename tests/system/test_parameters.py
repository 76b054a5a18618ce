# SPDX-License-Identifier: Apache-2.0
"""Parameters over the wire: every read, list and set, on each transport, and across a reset.

Values are REAL32 (MAV_PARAM_TYPE 9) in the units that people use."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from harness import (
    COMPONENTS,
    CONSOLE,
    WIRES,
    Light,
    Shell,
    Transport,
    light_on,
    set_over_can,
)
from parameters import (
    INT32,
    REAL32,
    as_float,
    ask,
    ask_list,
    get_param,
    send_set,
    set_param,
    value_of,
)
from pharos import MavlinkConnection, Simulator, Source, Target

# MAV_PARAM_ERROR
DOES_NOT_EXIST = 1
OUT_OF_RANGE = 2
READ_ONLY = 5
TYPE_UNSUPPORTED = 6

EVERYONE = Target(0, 0)


def values(messages: list[Any]) -> list[Any]:
    return [m for m in messages if m.get_type() == "PARAM_VALUE"]


def listed(light: Light, seconds: float = 3.0) -> dict[str, float]:
    """A whole list: every index once, names unique."""
    light.mav.drain()
    light.mav.inbox.clear()
    ask_list(light.mav)
    came = values(light.mav.pass_time(round(seconds * 1e6)))
    count = came[0].param_count
    assert sorted(m.param_index for m in came) == list(range(count))
    table = {m.param_id: value_of(m) for m in came}
    assert len(table) == count
    return table


def test_the_list_is_complete_and_says_what_the_shell_says(
    start: Callable[..., Simulator], transport: Transport
) -> None:
    sim = start({transport.wire: transport.address, "console": CONSOLE})
    light = light_on(sim, transport=transport)
    table = listed(light)
    shell = Shell(sim)
    for name in ("MAV_SYSID", "THR_SHUTDOWN", "CAN_LIGHT_ID", "THR_SENS_MIN"):
        line = next(li for li in shell(f"param get {name}").splitlines() if li.startswith(name))
        assert float(line.split()[1]) == table[name]
    assert table["THR_SENS_MIN"] == -55  # CONFIG_PHAROS_THERMAL_SENSOR_MIN_MDEGC


def test_a_parameter_reads_by_name_and_by_index(light: Light) -> None:
    ask(light, "STRB_MIN")
    by_name = light.mav.recv("PARAM_VALUE")
    assert (by_name.param_id, value_of(by_name)) == ("STRB_MIN", 0.01)
    ask(light, index=by_name.param_index)
    by_index = light.mav.recv("PARAM_VALUE")
    assert (by_index.param_id, value_of(by_index)) == ("STRB_MIN", 0.01)
    assert by_index.param_count == by_name.param_count


def test_a_set_is_in_force_and_outlives_a_reset(
    start: Callable[..., Simulator], transport: Transport
) -> None:
    wires = {transport.wire: transport.address}
    sim = start(wires, options=["--settings", "{folder}/settings"])
    light = light_on(sim, transport=transport)
    assert light.status().min_strobe_period == pytest.approx(0.01)
    assert set_param(light, "STRB_MIN", 0.02) == 0.02
    assert light.status().min_strobe_period == pytest.approx(0.02)
    light.sim.advance(s=1)  # the storage thread has written it
    light.sim.reset()
    light.greet()
    assert get_param(light, "STRB_MIN") == 0.02
    assert light.status().min_strobe_period == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("name", "value", "kind", "error"),
    [
        ("LGT_SRC_NOW", as_float(1), INT32, READ_ONLY),
        ("LGT_CURVE", as_float(2), INT32, OUT_OF_RANGE),
        ("LGT_CURVE", as_float(-1), INT32, OUT_OF_RANGE),
        ("THR_RECOVER", as_float(90), INT32, OUT_OF_RANGE),  # above THR_THROTTLE
        ("LGT_CURVE", math.nan, INT32, OUT_OF_RANGE),  # the bits of a NaN, 0x7FC00000
        ("LGT_CURVE", math.nan, REAL32, OUT_OF_RANGE),
        ("LGT_CURVE", math.inf, REAL32, OUT_OF_RANGE),
        ("LGT_CURVE", 0.5, REAL32, OUT_OF_RANGE),
        ("LGT_CURVE", as_float(0), 8, TYPE_UNSUPPORTED),  # INT64
        ("LGT_CURVE", as_float(0), 10, TYPE_UNSUPPORTED),  # REAL64
        ("LGT_CURVE", as_float(0), 0, TYPE_UNSUPPORTED),
        ("LGT_CURVE", as_float(0), 255, TYPE_UNSUPPORTED),
    ],
)
def test_a_refused_set_says_why_and_what_is_in_force(
    udp_light: Light, name: str, value: float, kind: int, error: int
) -> None:
    before = get_param(udp_light, name)
    send_set(udp_light.mav, name, value, kind)
    refusal = udp_light.mav.recv("PARAM_ERROR")
    assert (refusal.param_id, refusal.param_index, refusal.error) == (name, -1, error)
    assert (refusal.target_system, refusal.target_component) == (255, 190)
    answer = udp_light.mav.recv("PARAM_VALUE", timeout_us=0)
    assert (answer.param_id, value_of(answer)) == (name, before)
    assert get_param(udp_light, name) == before


def test_a_refused_set_is_answered_on_every_transport(light: Light) -> None:
    send_set(light.mav, "LGT_CURVE", 7)
    assert light.mav.recv("PARAM_ERROR").error == OUT_OF_RANGE
    assert value_of(light.mav.recv("PARAM_VALUE", timeout_us=0)) == 1


@pytest.mark.parametrize(
    ("name", "asked", "taken"),
    [
        ("STRB_MIN", 0.03, 0.03),
        ("STRB_MAX", 12.3456789, 12.345679),  # the nearest step: a microsecond
        ("THR_SHUTDOWN", 99.9996, 100),
        ("SYNC_FILT", 49.6, 50),  # whole microseconds
        ("LGT_LOSS", 0.0004, 0),
        ("LGT_CURVE", 0.0, 0),
    ],
)
def test_between_two_steps_the_nearer_one_is_taken_and_told(
    udp_light: Light, name: str, asked: float, taken: float
) -> None:
    assert set_param(udp_light, name, asked) == taken
    assert get_param(udp_light, name) == taken
    assert not [m for m in udp_light.mav.inbox if m.get_type() == "PARAM_ERROR"]


def test_an_integer_is_that_number_of_the_unit(udp_light: Light) -> None:
    send_set(udp_light.mav, "THR_SHUTDOWN", as_float(95), INT32)
    assert value_of(udp_light.mav.recv("PARAM_VALUE")) == 95
    send_set(udp_light.mav, "LGT_LOSS", as_float(3600), INT32)
    assert value_of(udp_light.mav.recv("PARAM_VALUE")) == 3600


def test_a_name_that_nobody_has_is_refused_to_him_who_asked_this_component(light: Light) -> None:
    ask(light, "NOT_A_NAME")
    refusal = light.mav.recv("PARAM_ERROR")
    assert (refusal.param_id, refusal.error) == ("NOT_A_NAME", DOES_NOT_EXIST)
    send_set(light.mav, "NOT_A_NAME", 1)
    refusal = light.mav.recv("PARAM_ERROR")
    assert (refusal.param_id, refusal.error) == ("NOT_A_NAME", DOES_NOT_EXIST)
    ask(light, index=9_999)
    refusal = light.mav.recv("PARAM_ERROR")
    assert (refusal.param_index, refusal.error) == (9_999, DOES_NOT_EXIST)
    for target in (EVERYONE, Target(1, 0)):
        ask(light, "SERVO1_MIN", target=target)  # the autopilot's
        send_set(light.mav, "SERVO1_MIN", 1, target=target)
    came = light.collect(1)
    assert not [m for m in came if m.get_type().startswith("PARAM_")]


def test_everyone_is_asked_and_the_light_answers(light: Light) -> None:
    for target in (EVERYONE, Target(1, 0), Target(1, 243)):
        ask(light, "LGT_CURVE", target=target)
        assert light.mav.recv("PARAM_VALUE").param_id == "LGT_CURVE"
        send_set(light.mav, "LGT_RESTORE", 1, target=target)
        assert value_of(light.mav.recv("PARAM_VALUE")) == 1
        ask_list(light.mav, target)
        lists: dict[int, list[Any]] = {}
        for message in values(light.collect(3)):
            lists.setdefault(message.get_srcComponent(), []).append(message)
        assert set(lists) == ({243} if target.component == 243 else set(COMPONENTS))
        for came in lists.values():
            assert sorted(m.param_index for m in came) == list(range(came[0].param_count))


def test_others_are_not_answered_for(light: Light) -> None:
    for target in (Target(1, 1), Target(2, 243), Target(2, 0)):
        ask(light, "LGT_CURVE", target=target)
        send_set(light.mav, "LGT_CURVE", 0, target=target)
        ask_list(light.mav, target)
    assert not [m for m in light.collect(3) if m.get_type().startswith("PARAM_")]
    assert get_param(light, "LGT_CURVE") == 1


def test_a_mavlink_1_ground_station_sets_parameters(light: Light) -> None:
    light.sim.reset()
    light.mav.version = 1
    light.greet()
    assert set_param(light, "LGT_RESTORE", 1) == 1
    send_set(light.mav, "LGT_RESTORE", 2)
    came = [m for m in light.collect(1) if m.get_type().startswith("PARAM_")]
    # PARAM_ERROR 345 can't be said in MAVLink 1: the value in force has to do.
    assert [(m.get_type(), value_of(m)) for m in came] == [("PARAM_VALUE", 1)]
    assert bytes(came[0].get_msgbuf())[0] == 0xFE
    table = listed(light)
    assert table["LGT_RESTORE"] == 1


@pytest.mark.parametrize("baud", [9600, 57600, 115200])
@pytest.mark.parametrize("wire", ["udp", "pty"])
def test_a_list_takes_30_to_50_percent_of_the_wire(
    start: Callable[..., Simulator], wire: str, baud: int
) -> None:
    light = light_on(start({"uart0": f"{WIRES[wire]},paced,baud={baud}"}))
    light.collect(1)
    ask_list(light.mav)
    times: list[int] = []
    count = 1
    while len(times) < count:
        for message in light.mav.pass_time(1_000):
            if message.get_type() == "PARAM_VALUE":
                times.append(light.sim.now_us())
                count = message.param_count
    # 37 bytes of 10 bits each; 1 ms is how exactly the client looks.
    used = 37 * 10 * (count - 1) / baud / ((times[-1] - times[0]) / 1e6)
    assert 0.30 <= used <= 0.50


def test_commands_get_through_during_a_list(start: Callable[..., Simulator]) -> None:
    light = light_on(start({"uart0": "udpin:127.0.0.1:0,paced,baud=57600"}))
    light.collect(1)
    ask_list(light.mav)
    light.sim.advance(100_000)
    before = light.sim.now_us()
    assert light.on() == 0
    # Out 44 bytes, back at most 37 + 37 of a list and 22 of the answer, at 5760 bytes/s; and the
    # client looks every few ms.
    assert light.sim.now_us() - before < 40_000


def test_lists_on_two_links_at_once_are_both_complete(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"], "uart1": WIRES["tcp"]})
    light = light_on(sim)
    other = sim.connect("uart1", Source(254, 190))
    other.heartbeat()
    sim.advance(s=1)
    light.collect(0.1)
    other.drain()
    other.inbox.clear()
    ask_list(light.mav)
    ask_list(other)
    for came in (light.collect(2), other.pass_time(0)):
        mine = values(came)
        assert sorted(m.param_index for m in mine) == list(range(mine[0].param_count))


def test_two_ground_stations_on_one_link_both_get_everything(
    start: Callable[..., Simulator],
) -> None:
    light = light_on(start({"uart0": "udpin:127.0.0.1:0,paced,baud=57600"}))
    light.collect(0.1)
    ask_list(light.mav)
    first = values(light.mav.pass_time(300_000))
    assert 0 < len(first) < first[0].param_count  # it is under way
    other = MavlinkConnection(light.mav.link, light.sim, light.mav.dialect, Source(254, 190))
    ask_list(other)
    second = values(other.pass_time(3_000_000))
    assert {m.param_index for m in second} == set(range(first[0].param_count))


def test_a_set_on_one_link_is_told_on_the_other(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"], "uart1": WIRES["tcp"]})
    light = light_on(sim)
    other = sim.connect("uart1", Source(254, 190))
    other.heartbeat()
    sim.advance(s=1)
    assert set_param(light, "SYNC_POL", 1) == 1
    told = other.recv("PARAM_VALUE")
    assert (told.param_id, value_of(told)) == ("SYNC_POL", 1)
    assert not values(light.collect(1))  # its own set was answered once


def test_what_the_shell_and_can_change_is_told(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE, "can0": "udp:127.255.255.255:{port}"})
    light = light_on(sim)
    shell = Shell(sim)
    shell("param set SYNC_POL 1")
    told = light.mav.recv("PARAM_VALUE")
    assert (told.param_id, value_of(told)) == ("SYNC_POL", 1)
    set_over_can(sim, "SYNC_RETRIG", 1)
    told = light.mav.recv("PARAM_VALUE")
    assert (told.param_id, value_of(told)) == ("SYNC_RETRIG", 1)
