# SPDX-License-Identifier: Apache-2.0
"""The gimbal on a vehicle, over every transport: what ArduPilot and PX4 send reaches "gimbal
healthy" and turns the servos; and each rule of being a gimbal device."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import pytest

from autopilots import (
    LOCKS,
    NO_QUATERNION,
    NO_RATES,
    ArduPilot,
    Attitude,
    OldArduPilot,
    OldPx4,
    Px4,
    Vehicle,
    pan_and_tilt,
    quaternion,
)
from harness import (
    ACCEPTED,
    CONSOLE,
    DENIED,
    ON_OFF,
    REQUEST_MESSAGE,
    SET_MESSAGE_INTERVAL,
    WIRES,
    Light,
    Shell,
    Transport,
    connect,
    from_light,
    light_on,
    of,
)
from parameters import set_param
from pharos import Simulator, Target

V = TypeVar("V", bound=Vehicle)
Starts = Callable[..., Simulator]
Fleet = Callable[[type[V]], V]
GIMBAL = Target(1, 154)
INFORMATION = 283
STATUS = 285


def angles(sim: Simulator) -> tuple[float, float]:
    """Pan and tilt of the model's servos [deg]."""
    servos = sim.outputs()["servos"]
    return servos["pan"]["angle_mdeg"] / 1000, servos["tilt"]["angle_mdeg"] / 1000


def points(pan: float, tilt: float) -> tuple[float, float]:
    return pytest.approx((pan, tilt), abs=0.05)  # type: ignore[return-value]


@pytest.fixture
def fleet(start: Starts, transport: Transport) -> Fleet[Vehicle]:
    """Makes the vehicle of a kind that the device is bolted to."""

    def make(kind: type[Vehicle]) -> Vehicle:
        sim = start({transport.wire: transport.address})
        vehicle = kind(sim, connect(sim, transport))
        vehicle.fly(1)
        return vehicle

    return make


# --- autopilots -----------------------------------------------------------------------------------
def test_ardupilot_finds_it_healthy_and_steers_it(fleet: Fleet[ArduPilot]) -> None:
    vehicle = fleet(ArduPilot)
    vehicle.fly(4)
    assert vehicle.is_healthy()
    vehicle.angles = Attitude(0, -30, 45)
    vehicle.fly(2)
    assert angles(vehicle.sim) == points(45, -30)
    assert vehicle.is_healthy()
    vehicle.retracted = True
    vehicle.fly(2)
    assert angles(vehicle.sim) == points(0, -90)


def test_ardupilot_points_at_the_earth_while_it_turns(fleet: Fleet[ArduPilot]) -> None:
    vehicle = fleet(ArduPilot)
    vehicle.earth = True
    vehicle.angles = Attitude(0, -20, 120)
    vehicle.attitude = Attitude(10, 5, 90)
    vehicle.fly(5)
    assert angles(vehicle.sim) == points(*pan_and_tilt(120, -20, vehicle.attitude))
    for _ in range(100):  # 20 degrees per second to the right
        vehicle.attitude.yaw += 0.4
        vehicle.attitude.roll -= 0.2
        vehicle.tick()
    assert vehicle.attitude.yaw == pytest.approx(130)
    vehicle.fly(0.1)
    assert angles(vehicle.sim) == points(*pan_and_tilt(120, -20, vehicle.attitude))
    status = vehicle.status()
    assert status.flags & LOCKS == LOCKS
    assert status.q == pytest.approx(quaternion(Attitude(0, -20, 120)), abs=0.01)


def test_ardupilot_turns_it_by_rates(fleet: Fleet[ArduPilot]) -> None:
    vehicle = fleet(ArduPilot)
    vehicle.fly(3)
    before = angles(vehicle.sim)
    vehicle.rates = (0.0, math.radians(-5), math.radians(10))
    vehicle.fly(2)
    vehicle.rates = (0.0, 0.0, 0.0)
    vehicle.fly(0.5)
    pan, tilt = angles(vehicle.sim)
    assert pan - before[0] == pytest.approx(20, abs=0.5)
    assert tilt - before[1] == pytest.approx(-10, abs=0.3)


def test_rates_stop_when_the_autopilot_falls_silent(fleet: Fleet[ArduPilot]) -> None:
    vehicle = fleet(ArduPilot)
    vehicle.rates = (0.0, 0.0, math.radians(20))
    vehicle.fly(4)
    started = angles(vehicle.sim)[0]
    vehicle.sim.advance(s=0.6)
    stopped = angles(vehicle.sim)[0]
    assert stopped - started == pytest.approx(10, abs=1.5)  # half a second of it
    vehicle.sim.advance(s=5)
    assert angles(vehicle.sim)[0] == pytest.approx(stopped, abs=0.5)


def test_ardupilots_storm32_driver_steers_it_with_its_own_signs(
    fleet: Fleet[OldArduPilot],
) -> None:
    vehicle = fleet(OldArduPilot)
    set_param(Light(vehicle.sim, vehicle.mav), "GMB_MNT_SIGN", 3, target=GIMBAL)
    vehicle.angles = Attitude(0, -25, 40)
    vehicle.fly(3)
    assert vehicle.has_gimbal()
    assert angles(vehicle.sim) == points(40, -25)
    acks = [m for m in vehicle.heard if m.get_type() == "COMMAND_ACK"]
    assert acks
    assert {(m.command, m.result) for m in acks} == {(205, ACCEPTED)}


def test_px4_finds_it_healthy_and_steers_it(fleet: Fleet[Px4]) -> None:
    vehicle = fleet(Px4)
    vehicle.fly(4)
    assert vehicle.is_healthy()
    vehicle.attitude = Attitude(0, 10, 200)
    vehicle.angles = Attitude(0, -30, 45)
    vehicle.fly(2)
    assert angles(vehicle.sim) == points(*pan_and_tilt(245, -30, vehicle.attitude))
    vehicle.lock_yaw = True
    vehicle.angles = Attitude(0, 0, 180)
    vehicle.fly(2)
    assert angles(vehicle.sim) == points(*pan_and_tilt(180, 0, vehicle.attitude))
    vehicle.angles, vehicle.rates = None, (0.0, math.radians(-10), 0.0)
    vehicle.fly(1)
    pan, tilt = pan_and_tilt(180, -10, vehicle.attitude)
    assert angles(vehicle.sim) == pytest.approx((pan, tilt), abs=0.5)


def test_px4s_mount_commands_steer_it(fleet: Fleet[OldPx4]) -> None:
    vehicle = fleet(OldPx4)
    vehicle.angles = Attitude(0, -15, 60)
    vehicle.fly(3)
    assert angles(vehicle.sim) == points(60, -15)
    vehicle.attitude = Attitude(0, 20, 30)
    vehicle.frames = (0, 2, 2)  # pitch and yaw are the earth's now
    vehicle.fly(3)
    assert angles(vehicle.sim) == points(*pan_and_tilt(60, -15, vehicle.attitude))
    acks = {(m.command, m.result) for m in vehicle.heard if m.get_type() == "COMMAND_ACK"}
    assert acks == {(204, ACCEPTED), (205, ACCEPTED)}


# --- data of the vehicle --------------------------------------------------------------------------
def test_data_are_asked_for_until_they_come_and_again_when_they_stop(
    fleet: Fleet[Vehicle],
) -> None:
    vehicle = fleet(Vehicle)
    vehicle.answers = False
    vehicle.fly(5)
    for message_id in (30, 33):
        # in 6 s: each second, in both ways
        assert 10 <= [m for _, m in vehicle.asked].count(message_id) <= 12
    vehicle.answers = True
    vehicle.fly(3)
    assert vehicle.streams == {30: 50_000, 33: 500_000}
    vehicle.asked.clear()
    vehicle.fly(10)
    assert vehicle.asked == []
    vehicle.streams.pop(30)
    vehicle.answers = False
    vehicle.fly(6)
    assert {m for _, m in vehicle.asked} == {30}
    assert len(vehicle.asked) >= 6


def test_the_vehicle_asked_is_the_one_whose_id_was_adopted(
    start: Starts, transport: Transport
) -> None:
    sim = start({transport.wire: transport.address})
    vehicle = Vehicle(sim, connect(sim, transport), system=7)
    vehicle.fly(8)
    assert vehicle.has_gimbal()
    assert set(vehicle.streams) == {30, 33}


def test_nobody_is_asked_when_the_parameter_says_so(start: Starts) -> None:
    light = light_on(start({"uart0": WIRES["udp"]}))
    set_param(light, "GMB_ASK_DATA", 0, target=GIMBAL)
    vehicle = Vehicle(light.sim, light.mav)
    vehicle.fly(5)
    assert vehicle.asked == []


# --- rules of a gimbal device ---------------------------------------------------------------------
def test_heartbeat_says_gimbal_each_second(light: Light) -> None:
    beats = of("HEARTBEAT", from_light(light.collect(10), 154))
    assert len(beats) == 10
    assert {(b.type, b.autopilot, b.system_status) for b in beats} == {(26, 8, 4)}


def test_attitude_status_is_never_older_than_a_second(light: Light) -> None:
    assert len(of("GIMBAL_DEVICE_ATTITUDE_STATUS", light.collect(10))) == 50
    assert light.mav.command_long(SET_MESSAGE_INTERVAL, STATUS, 20_000, target=GIMBAL).result == 0
    assert len(of("GIMBAL_DEVICE_ATTITUDE_STATUS", light.collect(2))) == 100


def test_information_has_the_limits_of_the_parameters(light: Light) -> None:
    set_param(light, "GMB_PAN_MIN", -60, target=GIMBAL)
    set_param(light, "GMB_TLT_MAX", 30, target=GIMBAL)
    assert light.mav.command_long(REQUEST_MESSAGE, INFORMATION, target=GIMBAL).result == ACCEPTED
    info = light.mav.recv("GIMBAL_DEVICE_INFORMATION", timeout_us=0)
    limits = (info.yaw_min, info.yaw_max, info.pitch_min, info.pitch_max)
    assert [math.degrees(x) for x in limits] == pytest.approx([-60, 90, -90, 30], abs=1e-3)
    assert (info.roll_min, info.roll_max) == (0, 0)
    assert info.vendor_name == "Pharos"


def test_bad_numbers_are_refused_and_counted(start: Starts) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    light = light_on(sim)
    vehicle = Vehicle(sim, light.mav)
    bad = [(math.nan, 0, 0, 1), (0.5, 0, 0, 0), (math.inf, 0, 0, 0), (0, 0, 0, 0)]
    for q in bad:
        vehicle.set_attitude(0, q)
    vehicle.set_attitude(0, NO_QUATERNION, (0, math.inf, 0))
    vehicle.set_attitude(32 | 64, quaternion(Attitude(0, 0, 45)))
    for angle in (math.nan, math.inf, 361.0):
        ack = light.mav.command_long(205, angle, 0, 10, 0, 0, 0, 2, target=GIMBAL)
        assert ack.result == DENIED
    sim.advance(s=1)
    assert angles(sim) == (0, 0)
    assert "mode          neutral" in (status := Shell(sim)("gimbal status"))
    assert "0 set, 0 refused, 6 without meaning" in status


def test_beyond_the_limits_is_the_limit_and_told(light: Light) -> None:
    vehicle = Vehicle(light.sim, light.mav)
    vehicle.set_attitude(0, quaternion(Attitude(0, 0, 170)), NO_RATES)
    vehicle.fly(2)
    assert angles(light.sim) == points(90, 0)
    status = vehicle.status()
    assert status.failure_flags == 4  # AT_YAW_LIMIT
    assert status.q == pytest.approx(quaternion(Attitude(0, 0, 90)), abs=1e-4)


def test_lock_without_the_vehicles_attitude_holds_and_is_a_failure(light: Light) -> None:
    vehicle = Vehicle(light.sim, light.mav)
    vehicle.set_attitude(LOCKS, quaternion(Attitude(0, 0, 45)))
    vehicle.fly(0.8)
    assert angles(light.sim) == (0, 0)
    assert vehicle.status().failure_flags == 128  # COMMS_ERROR
    vehicle.fly(3)  # its heartbeat has come, and so its attitude
    assert angles(light.sim) == points(45, 0)
    assert vehicle.status().failure_flags == 0


def test_command_to_all_is_answered_by_who_knows_it(light: Light) -> None:
    light.collect(0)
    for command, results in ((ON_OFF, [ACCEPTED]), (205, [ACCEPTED]), (31_999, [])):
        light.mav.send_command_long(command, 1, 0, 0, 0, 0, 0, 2, target=Target(0, 0))
        acks = of("COMMAND_ACK", light.mav.pass_time(1_000_000))
        assert [m.result for m in acks] == results


def test_component_id_is_a_parameter(start: Starts) -> None:
    light = light_on(start({"uart0": WIRES["udp"]}))
    set_param(light, "GMB_COMPID", 171)
    light.sim.advance(s=2)
    light.sim.reset()
    light.sim.advance(s=2)
    assert {m.get_srcComponent() for m in light.collect(3)} == {243, 171}


def test_turned_off_it_is_no_component(light: Light) -> None:
    set_param(light, "GMB_ENABLE", 0)
    light.sim.advance(s=2)
    light.sim.reset()
    light.sim.advance(s=2)
    light.mav.heartbeat()
    assert {m.get_srcComponent() for m in light.collect(3)} == {243}
    light.mav.send_command_long(205, 0, 0, 0, 0, 0, 0, 2, target=GIMBAL)
    assert of("COMMAND_ACK", light.mav.pass_time(2_000_000)) == []


def test_a_link_of_version_1_steers_it_with_mount_commands(start: Starts) -> None:
    sim = start({"uart0": WIRES["udp"]})
    mav = connect(sim, Transport("uart0", WIRES["udp"]))
    mav.version = 1
    mav.heartbeat()
    sim.advance(s=1)
    ack = mav.command_long(205, -10, 0, 20, 0, 0, 0, 2, target=GIMBAL)
    assert ack.result == ACCEPTED
    sim.advance(s=2)
    mav.drain()
    assert angles(sim) == points(20, -10)
    assert of("GIMBAL_DEVICE_ATTITUDE_STATUS", mav.history) == []
    assert of("HEARTBEAT", from_light(mav.history, 154))
