# SPDX-License-Identifier: Apache-2.0
"""Which vehicle the light belongs to: it takes the autopilot's system id, as all that is bolted to
a vehicle does, unless MAV_SYSID names one."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from harness import (
    ACCEPTED,
    COMPONENTS,
    CONSOLE,
    ON_OFF,
    WIRES,
    Light,
    Shell,
    Transport,
    light_on,
    of,
    texts,
)
from parameters import set_param
from pharos import MavlinkConnection, SilentError, Simulator, Source, Target

AUTOPILOT = 1  # MAV_COMP_ID_AUTOPILOT1


def heartbeat(mav: MavlinkConnection, type_: int = 2, autopilot: int = 3) -> None:
    """A quadrotor with ArduPilot, by default."""
    mav.send(mav.dialect.MAVLink_heartbeat_message(type_, autopilot, 0, 0, 4, 3))


def beside(light: Light, source: Source) -> MavlinkConnection:
    """Somebody else who sends on the light's wire."""
    return MavlinkConnection(light.mav.link, light.sim, light.mav.dialect, source)


def system_of(light: Light) -> int:
    return int(of("HEARTBEAT", light.collect(1))[-1].get_srcSystem())


def fly(mav: MavlinkConnection, light: Light, seconds: int) -> None:
    """An autopilot's heartbeats at 1 Hz."""
    for _ in range(seconds):
        heartbeat(mav)
        light.sim.advance(s=1)


@pytest.mark.parametrize("system", [5, 255])
def test_the_vehicles_system_id_is_adopted(light: Light, system: int) -> None:
    assert system_of(light) == 1
    heartbeat(beside(light, Source(system, AUTOPILOT)))
    came = light.collect(2.9)
    assert {m.get_srcSystem() for m in came} == {1}
    came = light.collect(2)
    assert f"System id is now the vehicle's: {system}" in texts(came)
    both = {(m.get_srcSystem(), m.get_srcComponent()) for m in light.collect(2)}
    assert both == {(system, component) for component in COMPONENTS}
    assert light.mav.command_long(ON_OFF, 1, target=Target(system)).result == ACCEPTED
    with pytest.raises(SilentError):
        light.mav.command_long(ON_OFF, 0, target=Target(1))


def test_two_vehicles_leave_it_as_it_is(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"], "uart1": WIRES["tcp"], "console": CONSOLE})
    light = light_on(sim)
    one = beside(light, Source(5, AUTOPILOT))
    two = sim.connect("uart1", Source(6, AUTOPILOT))
    heartbeat(one)
    sim.advance(s=1)
    heartbeat(two)
    came = light.collect(4)
    assert texts(came).count("Several vehicles heard, system id stays 1") == 1
    fly(one, light, 10)
    assert system_of(light) == 1
    assert "several vehicles are heard" in Shell(sim)("mavlink")


def test_ground_stations_and_peripherals_are_no_vehicles(
    start: Callable[..., Simulator], transport: Transport
) -> None:
    light = light_on(start({transport.wire: transport.address}), transport=transport)
    for source, type_, autopilot in (
        (Source(255, 190), 6, 8),  # a ground station
        (Source(9, AUTOPILOT), 6, 3),  # one that says it is component 1, with an autopilot
        (Source(9, 154), 26, 8),  # a gimbal
        (Source(9, AUTOPILOT), 26, 8),  # the same as component 1
        (Source(9, 191), 18, 8),  # a companion computer
        (Source(9, 100), 30, 8),  # a camera
    ):
        heartbeat(beside(light, source), type_, autopilot)
        light.sim.advance(s=1)
    light.sim.advance(s=5)
    assert system_of(light) == 1


def test_mav_sysid_fixes_it(start: Callable[..., Simulator]) -> None:
    sim = start(
        {"uart0": WIRES["udp"], "console": CONSOLE}, options=["--settings", "{folder}/settings"]
    )
    light = light_on(sim)
    assert set_param(light, "MAV_SYSID", 77) == 77
    assert system_of(light) == 1  # after a reset
    sim.reset()
    light.greet()
    assert system_of(light) == 77
    autopilot = beside(light, Source(5, AUTOPILOT))
    fly(autopilot, light, 5)
    assert system_of(light) == 77
    shell = Shell(sim)("mavlink")
    assert "77" in shell
    assert "configured" in shell


def test_it_stays_with_its_vehicle(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    light = light_on(sim)
    fly(beside(light, Source(5, AUTOPILOT)), light, 4)
    assert system_of(light) == 5
    # its own falls silent, another comes within earshot
    fly(beside(light, Source(6, AUTOPILOT)), light, 60)
    assert system_of(light) == 5
    assert "the vehicle's" in Shell(sim)("mavlink")
    # a reset is how it gets to another vehicle
    sim.reset()
    fly(beside(light, Source(6, AUTOPILOT)), light, 4)
    assert system_of(light) == 6
