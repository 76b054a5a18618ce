# SPDX-License-Identifier: Apache-2.0
"""When every commander is silent, on every protocol, for longer than LGT_LOSS: the fallback."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import pytest
from dronecan import uavcan

from harness import ACCEPTED, BUS, CONSOLE, FULL_PPM, SECOND_US, WIRES, Light, Shell, light_on
from imc_light import join
from parameters import get_param, set_param
from pharos import Edge, MavlinkConnection, Simulator, Source

KEEP, OFF, BEACON = range(3)  # LGT_FALLBACK
FALLBACK = 5  # LGT_SRC_NOW
LOSS_S = 3


def arm(light: Light, fallback: int) -> None:
    set_param(light, "LGT_FALLBACK", fallback)
    set_param(light, "LGT_LOSS", LOSS_S)
    assert light.configure(40, 0, 100) == ACCEPTED
    assert light.on() == ACCEPTED


def silence(light: Light, us: int) -> None:
    """Time passes, and this client says nothing at all."""
    light.sim.advance(us)


def phases(edges: list[Edge]) -> list[tuple[int, int]]:
    return [(a.level_ppm, b.time_us - a.time_us) for a, b in itertools.pairwise(edges)]


def test_keep_keeps(light: Light) -> None:
    arm(light, KEEP)
    before = light.level_ppm()
    silence(light, 10 * SECOND_US)
    assert light.level_ppm() == before > 0
    assert get_param(light, "LGT_SRC_NOW") == 1


def test_off_is_off_after_the_time_and_not_before(light: Light) -> None:
    arm(light, OFF)
    silence(light, LOSS_S * SECOND_US - 100_000)
    assert light.level_ppm() > 0
    silence(light, 200_000)
    assert light.level_ppm() == 0
    assert light.status().enable == 0
    assert get_param(light, "LGT_SRC_NOW") == FALLBACK


def test_beacon_is_the_strobe_of_its_parameters(light: Light) -> None:
    assert set_param(light, "LGT_CURVE", 0) == 0  # brightness is light
    set_param(light, "BCN_PERIOD", 1.5)
    set_param(light, "BCN_DUTY", 20)
    assert set_param(light, "BCN_DUTY", 0) == 20  # refused: never lit
    set_param(light, "BCN_BRIGHT", 70)
    arm(light, BEACON)
    silence(light, 5 * SECOND_US)
    light.sim.edges()
    silence(light, 10 * SECOND_US)
    edges = light.sim.edges()
    assert set(phases(edges)) == {(700_000, 300_000), (0, 1_200_000)}
    status = light.status()
    assert (status.enable, status.mode) == (1, 1)
    assert status.brightness == pytest.approx(70)
    assert status.strobe_period == pytest.approx(1.5)
    assert status.strobe_duty_cycle == pytest.approx(20)


def test_beacon_by_default_is_60_flashes_a_minute_at_full(udp_light: Light) -> None:
    arm(udp_light, BEACON)
    silence(udp_light, 5 * SECOND_US)
    udp_light.sim.edges()
    silence(udp_light, 5 * SECOND_US)
    assert set(phases(udp_light.sim.edges())) == {(FULL_PPM, 100_000), (0, 900_000)}


def test_beacon_lights_a_lamp_that_was_off_and_ends_a_program(udp_light: Light) -> None:
    set_param(udp_light, "LGT_PROGRAM", 4)
    arm(udp_light, BEACON)
    udp_light.off()
    silence(udp_light, 5 * SECOND_US)
    udp_light.sim.edges()
    silence(udp_light, 5 * SECOND_US)
    assert set(phases(udp_light.sim.edges())) == {(FULL_PPM, 100_000), (0, 900_000)}


def test_beacon_is_no_brighter_than_heat_allows(udp_light: Light) -> None:
    safe = get_param(udp_light, "THR_SAFE") * 10_000  # % to ppm
    udp_light.sim.fault("thermistor", "open")
    arm(udp_light, BEACON)
    silence(udp_light, 5 * SECOND_US)
    udp_light.sim.edges()
    silence(udp_light, 5 * SECOND_US)
    assert {e.level_ppm for e in udp_light.sim.edges()} == {0, safe}


def test_heartbeats_of_a_ground_station_are_signs_of_life(light: Light) -> None:
    arm(light, OFF)
    for _ in range(10):
        light.mav.heartbeat()
        silence(light, SECOND_US)
    assert light.level_ppm() > 0
    silence(light, LOSS_S * SECOND_US)
    assert light.level_ppm() == 0


def test_heartbeats_of_peripherals_are_none(udp_light: Light) -> None:
    d = udp_light.mav.dialect
    camera = MavlinkConnection(udp_light.mav.link, udp_light.sim, d, Source(1, 100))
    arm(udp_light, OFF)
    for _ in range(5):
        camera.send(d.MAVLink_heartbeat_message(30, 8, 0, 0, 4, 3))
        silence(udp_light, SECOND_US)
    assert udp_light.level_ppm() == 0


def test_who_comes_back_commands_again(light: Light) -> None:
    arm(light, OFF)
    silence(light, 5 * SECOND_US)
    light.mav.heartbeat()
    light.sim.advance(s=1)
    assert light.level_ppm() == 0  # to be there is no command
    assert light.on() == ACCEPTED
    assert light.level_ppm() > 0
    assert get_param(light, "LGT_SRC_NOW") == 1
    silence(light, 5 * SECOND_US)  # and can be lost again
    assert light.level_ppm() == 0


def hardpoint(command: int) -> Any:
    return uavcan.equipment.hardpoint.Command(hardpoint_id=0, command=command)


@pytest.mark.parametrize("last", ["mavlink", "dronecan", "imc", "shell"])
def test_only_the_silence_of_all_protocols_counts(
    start: Callable[..., Simulator], last: str
) -> None:
    """MAVLink over UDP, DroneCAN, IMC over TCP and the shell: while one of them speaks nothing is
    lost."""
    wires = {"uart0": WIRES["udp"], "uart1": WIRES["tcp"], "can0": BUS, "console": CONSOLE}
    sim = start(wires)
    shell = Shell(sim)
    shell("param set UART1_PROTO 1")
    sim.advance(s=1)
    sim.reset()
    light = light_on(sim)
    node = sim.node(9)
    peer = join(sim, "uart1")
    arm(light, OFF)

    def speak() -> None:
        if last == "mavlink":
            light.mav.heartbeat()
        elif last == "dronecan":
            node.broadcast(hardpoint(1), priority=16)
        elif last == "imc":
            peer.send("Heartbeat")
        else:
            shell("light on")

    for _ in range(8):
        speak()
        silence(light, SECOND_US)
        assert light.level_ppm() > 0, last
    silence(light, LOSS_S * SECOND_US)
    assert light.level_ppm() == 0
    assert "commander     fallback" in shell("light status")
