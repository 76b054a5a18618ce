# SPDX-License-Identifier: Apache-2.0
"""The light as a DroneCAN node, with PyPI's dronecan as an independent peer, classic and FD."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import can
import pytest
from dronecan import uavcan
from dronecan.app.dynamic_node_id import CentralizedServer
from dronecan.app.node_monitor import NodeMonitor

from dronecan_peer import PEER, Peer
from harness import (
    ACCEPTED,
    BUILD,
    BUS,
    CONSOLE,
    NODE,
    ON_OFF,
    WIRES,
    Shell,
    light_on,
    of,
    set_over_can,
    texts,
)
from parameters import send_set
from pharos import Simulator, Source, Tunnel

log_level = uavcan.protocol.debug.LogLevel()
GOLDEN_STATUS = 0x18015544  # NodeStatus of node 68
Starts = Callable[..., Simulator]
pytestmark = pytest.mark.bus


@pytest.fixture(params=[False, True], ids=["classic", "fd"])
def peer(start: Starts, request: pytest.FixtureRequest) -> Peer:
    sim = start({"can0": BUS, "console": CONSOLE})
    sim.advance(s=1)
    if request.param:
        set_over_can(sim, "CAN_FD", 1)
        sim.reset()
    sim.advance(s=1)
    return Peer(sim, fd=request.param)


def lights(level: int, light_id: int = 254) -> Any:
    """LightsCommand of one light; level: green, 0…63."""
    command = uavcan.equipment.indication.SingleLightCommand(light_id=light_id)
    command.color.green = level
    return uavcan.equipment.indication.LightsCommand(commands=[command])


def hardpoint(command: int, hardpoint_id: int = 0) -> Any:
    return uavcan.equipment.hardpoint.Command(hardpoint_id=hardpoint_id, command=command)


def actuator(actuator_id: int, value: float, kind: int = 0) -> Any:
    command = uavcan.equipment.actuator.Command(
        actuator_id=actuator_id, command_type=kind, command_value=value
    )
    return uavcan.equipment.actuator.ArrayCommand(commands=[command])


def brightness_of(sim: Simulator) -> tuple[int, int]:
    """What was commanded: on or off, and how bright."""
    outputs = sim.outputs()
    return int(outputs["enable"]), int(outputs["brightness_ppm"])


# --- node -----------------------------------------------------------------------------------------
def test_node_status_each_second_with_the_golden_id(start: Starts) -> None:
    sim = start({"can0": BUS})
    frames: list[can.Message] = []
    sim.bus().listeners.append(frames.append)
    sim.advance(s=10)
    status = [f for f in frames if f.arbitration_id == GOLDEN_STATUS]
    assert status[0].is_extended_id
    # Uptime (the one at 0 s went before we listened), health ok, mode operational, no error.
    assert [bytes(f.data[:7]) for f in status] == [bytes([s, *[0] * 6]) for s in range(1, 11)]


def test_get_node_info(peer: Peer) -> None:
    info = peer.ask(uavcan.protocol.GetNodeInfo.Request())
    assert str(info.name) == "org.pharos.light"
    assert any(bytes(info.hardware_version.unique_id))
    # Bit 0 of the flags: there is a commit. What the build was told, 0 outside of a git tree.
    header = (BUILD / "app/generated/threads/vcs_commit.h").read_text()
    commit = int(header.split("PHAROS_VCS_COMMIT")[1].strip().removesuffix("u"), 16)
    software = info.software_version
    assert (software.vcs_commit, software.optional_field_flags) == (commit, int(commit != 0))
    assert info.status.health == info.status.HEALTH_OK
    assert info.status.mode == info.status.MODE_OPERATIONAL


def test_every_parameter_is_read_and_the_table_is_the_shells(peer: Peer) -> None:
    names: list[str] = []
    while True:
        answer = peer.ask(uavcan.protocol.param.GetSet.Request(index=len(names)))
        if len(answer.name) == 0:
            break
        names.append(str(answer.name))
    listed = Shell(peer.sim)("param list")
    assert [name for name in names if name not in listed] == []
    assert {"CAN_NODE_ID", "LGT_SRC_NOW", "STRB_MIN"} <= set(names)


def test_parameter_set_over_can_is_in_force_and_stored(peer: Peer) -> None:
    assert peer.param("STRB_MIN", 0.05) == 0.05
    assert peer.param("STRB_MIN", 17) == 0.05, "out of range: unchanged"
    assert peer.param("LGT_SRC_NOW", 4) == 0, "read-only"
    assert peer.ask(uavcan.protocol.param.ExecuteOpcode.Request(opcode=0)).ok
    peer.run(2_000_000)
    peer.sim.reset()
    peer.run(2_000_000)
    assert peer.param("STRB_MIN") == 0.05


def test_erase_brings_the_defaults_back(peer: Peer) -> None:
    peer.param("STRB_MIN", 0.05)
    assert peer.ask(uavcan.protocol.param.ExecuteOpcode.Request(opcode=1)).ok
    assert peer.param("STRB_MIN") == 0.01


def test_restart_answers_then_resets_with_the_lamp_off(peer: Peer) -> None:
    peer.tell(lights(63))
    boots = peer.sim.outputs()["resets"]
    request = uavcan.protocol.RestartNode.Request()
    request.magic_number = request.MAGIC_NUMBER
    assert peer.ask(request).ok
    peer.run(1_000_000)
    outputs = peer.sim.outputs()
    assert outputs["resets"] == boots + 1
    assert outputs["reset_cause"] == "software"
    assert outputs["level_ppm"] == 0


def test_each_boot_is_told_with_its_reason(peer: Peer) -> None:
    heard = peer.heard(uavcan.protocol.debug.LogMessage)
    peer.sim.reset()
    peer.run(2_000_000)
    told = [(log.level.value, str(log.source), str(log.text)) for log in heard]
    assert told == [(log_level.INFO, "light", "Pharos 0.1.0: reset pin")]


def test_transport_stats_count_without_errors(peer: Peer) -> None:
    peer.run(3_000_000)
    stats = peer.ask(uavcan.protocol.GetTransportStats.Request())
    assert stats.transfers_tx >= 6
    assert stats.transfer_errors == 0
    assert stats.can_iface_stats[0].errors == 0


def test_another_node_with_our_id_is_told_everywhere_and_forgotten(start: Starts) -> None:
    sim = start({"can0": BUS, "uart0": WIRES["udp"], "console": CONSOLE})
    peer = Peer(sim)
    shell = Shell(sim)
    light = light_on(sim)
    light.mav.heartbeat()
    logs = peer.heard(uavcan.protocol.debug.LogMessage)
    statuses = peer.heard(uavcan.protocol.NodeStatus)
    peer.run(3_000_000)
    assert statuses[-1].health == statuses[-1].HEALTH_OK
    assert "another node" not in shell("can")

    twin = sim.node(NODE)  # its unique id is of zeros
    peer.run(3_000_000)
    text = "CAN node id 68 is another node's too"
    assert (log_level.WARNING, text) in [(log.level.value, str(log.text)) for log in logs]
    assert text in texts(light.mav.pass_time(0))
    assert f"another node has it too; its unique id: {'00' * 16}" in shell("can")
    assert statuses[0].HEALTH_WARNING in {status.health for status in statuses[-4:]}

    twin.close()
    peer.run(11_000_000)
    assert statuses[-1].health == statuses[-1].HEALTH_OK
    assert "another node" not in shell("can")


def test_allocator_gives_an_id_that_is_used_at_once(start: Starts) -> None:
    sim = start({"can0": BUS})
    sim.advance(s=1)
    set_over_can(sim, "CAN_NODE_ID", 0)
    sim.reset()
    peer = Peer(sim, node_id=127)
    server = CentralizedServer(peer.node, NodeMonitor(peer.node))
    told = peer.heard(uavcan.protocol.debug.LogMessage)
    sources = []
    peer.node.add_handler(
        uavcan.protocol.NodeStatus, lambda event: sources.append(event.transfer.source_node_id)
    )
    peer.run(6_000_000)
    assert 125 in [node_id for _, node_id in server.get_allocation_table()]
    assert sources.count(125) >= 2
    assert [str(log.text) for log in told] == ["Pharos 0.1.0: reset pin"], "told once it may speak"
    info = peer.ask(uavcan.protocol.GetNodeInfo.Request(), node_id=125)
    assert str(info.name) == "org.pharos.light"
    client = sim.connect("can0", tunnel=Tunnel(node=125))
    client.heartbeat()
    assert client.command_long(ON_OFF, 1).result == ACCEPTED


def test_without_an_allocator_only_allocation_requests_are_sent(start: Starts) -> None:
    sim = start({"can0": BUS})
    sim.advance(s=1)
    set_over_can(sim, "CAN_NODE_ID", 0)
    sim.reset()
    frames: list[can.Message] = []
    sim.bus().listeners.append(frames.append)
    sim.advance(s=10)
    # A request every 600…1000 ms, from source 0, of type 1 in its two low bits.
    assert {f.arbitration_id & 0x3FF for f in frames} == {0x100}
    assert 10 <= len(frames) <= 17


# --- lamp -----------------------------------------------------------------------------------------
def test_lights_command_sets_brightness_and_switches(peer: Peer) -> None:
    peer.tell(lights(21))
    assert brightness_of(peer.sim) == (1, 333_333)  # 21/63
    peer.tell(lights(63, light_id=0))
    assert brightness_of(peer.sim) == (1, 333_333), "ArduPilot's status colour is not for us"
    peer.tell(lights(0))
    assert brightness_of(peer.sim) == (0, 333_333)
    assert peer.sim.outputs()["level_ppm"] == 0


def test_hardpoint_switches_and_its_status_follows(peer: Peer) -> None:
    heard = peer.heard(uavcan.equipment.hardpoint.Status)
    peer.tell(hardpoint(1))
    assert brightness_of(peer.sim)[0] == 1
    peer.run(50_000)
    assert heard[-1].status == 1
    peer.tell(hardpoint(0))
    assert brightness_of(peer.sim)[0] == 0
    assert heard[-1].status == 0
    peer.tell(hardpoint(1, hardpoint_id=1))
    assert brightness_of(peer.sim)[0] == 0


def test_servo_output_sets_brightness_once_configured(peer: Peer) -> None:
    peer.tell(actuator(9, 0.5))
    assert brightness_of(peer.sim)[0] == 0
    assert peer.param("CAN_ACT_BRT", 9) == 9
    peer.tell(actuator(9, 0.5))
    assert brightness_of(peer.sim) == (1, 750_000)  # -1…1 is dark to full
    peer.tell(actuator(9, 1250.0, kind=4))
    assert brightness_of(peer.sim) == (1, 250_000)  # pulses of 1000…2000 us


def test_temperature_is_told_in_kelvin(peer: Peer) -> None:
    heard = peer.heard(uavcan.equipment.device.Temperature)
    peer.run(2_000_000)
    assert heard[-1].temperature == pytest.approx(273.15 + 25, abs=2)


def test_overheated_lamp_shows_in_health_and_throttling_does_not(peer: Peer) -> None:
    heard = peer.heard(uavcan.protocol.NodeStatus)
    peer.tell(lights(63))
    peer.sim.set(temp_mdegc=90_000)
    peer.run(2_000_000)
    assert heard[-1].health == heard[-1].HEALTH_OK
    assert heard[-1].vendor_specific_status_code & 1  # THERMAL_THROTTLING
    peer.sim.set(temp_mdegc=110_000)
    peer.run(5_000_000)
    assert heard[-1].health == heard[-1].HEALTH_ERROR
    assert heard[-1].vendor_specific_status_code & 2  # OVERTEMPERATURE_SHUTDOWN
    peer.tell(lights(62))
    assert brightness_of(peer.sim)[1] == 1_000_000, "refused whole: not even the brightness"


# --- who is in command ----------------------------------------------------------------------------
def test_repetition_does_not_take_the_light_back(peer: Peer) -> None:
    client = peer.sim.connect("can0", tunnel=Tunnel(own=20))
    client.heartbeat()
    peer.tell(lights(63))
    assert peer.param("LGT_SRC_NOW") == 2
    assert client.command_long(ON_OFF, 0).result == ACCEPTED
    for _ in range(10):
        peer.tell(lights(63))
    assert brightness_of(peer.sim)[0] == 0
    assert peer.param("LGT_SRC_NOW") == 1
    assert "commander     mavlink" in Shell(peer.sim)("light status")
    peer.tell(lights(62))
    assert brightness_of(peer.sim)[0] == 1, "a new command does"


def test_excluded_and_outranked_dronecan_commands_change_nothing(peer: Peer) -> None:
    assert peer.param("LGT_SRC_EXCL", 2) == 2
    peer.tell(hardpoint(1))
    assert brightness_of(peer.sim)[0] == 0
    assert peer.param("LGT_SRC_EXCL", 0) == 2, "who is excluded does not let itself in again"
    client = peer.sim.connect("can0", tunnel=Tunnel(own=20))
    client.heartbeat()
    send_set(client, "LGT_SRC_EXCL", 0)
    assert peer.param("LGT_SRC_PRIO", 1) == 1
    assert client.command_long(ON_OFF, 0).result == ACCEPTED
    peer.tell(hardpoint(1))
    assert brightness_of(peer.sim)[0] == 0
    peer.run(5_000_000)  # LGT_SRC_HOLD
    peer.tell(hardpoint(1))
    assert brightness_of(peer.sim)[0] == 1


def test_silent_vehicle_that_comes_back_takes_command_from_the_fallback(peer: Peer) -> None:
    peer.param("LGT_LOSS", 2)
    peer.param("LGT_FALLBACK", 1)
    peer.tell(hardpoint(1))
    peer.run(1_000_000)
    assert brightness_of(peer.sim)[0] == 1
    peer.run(1_500_000)
    assert brightness_of(peer.sim)[0] == 0
    assert peer.param("LGT_SRC_NOW") == 5
    peer.tell(hardpoint(1))
    assert brightness_of(peer.sim)[0] == 1


# --- tunnel ---------------------------------------------------------------------------------------
MAVLINK, MAVLINK2, GPS_GENERIC, UNDEFINED = 0, 1, 2, 255


@pytest.mark.parametrize("protocol", [MAVLINK, MAVLINK2, UNDEFINED, GPS_GENERIC])
def test_peer_tunnels_mavlink_both_ways(peer: Peer, protocol: int) -> None:
    """ArduPilot up to 4.5 always says UNDEFINED. What says that it is something else is not."""
    heard = peer.heard(uavcan.tunnel.Targetted)
    sim = peer.sim
    dialect = sim.dialect
    codec = dialect.MAVLink(None, 255, 190)
    frame = dialect.MAVLink_command_long_message(1, 243, ON_OFF, 0, 1, 0, 0, 0, 0, 0, 0).pack(codec)
    message = uavcan.tunnel.Targetted(target_node=NODE, serial_id=3, options=1, baudrate=57600)
    message.protocol.protocol = protocol
    message.buffer.from_bytes(frame)
    peer.node.broadcast(message, priority=16)
    peer.run(1_000_000)
    if protocol == GPS_GENERIC:
        assert (brightness_of(sim)[0], heard) == (0, [])
        return
    assert brightness_of(sim)[0] == 1
    told = {(m.target_node, m.serial_id, m.protocol.protocol) for m in heard}
    assert told == {(PEER, 3, protocol)}
    parser = dialect.MAVLink(None)
    came = parser.parse_buffer(b"".join(bytes(m.buffer.to_bytes()) for m in heard)) or []
    assert [m.result for m in of("COMMAND_ACK", came)] == [ACCEPTED]
    assert of("HEARTBEAT", came)


def test_nothing_is_tunnelled_before_somebody_asks_nor_3_s_after(start: Starts) -> None:
    sim = start({"can0": BUS})
    targetted: list[float] = []

    def listen(frame: can.Message) -> None:
        if frame.arbitration_id >> 8 & 0xFFFF == 3001:
            targetted.append(sim.now_us())

    sim.bus().listeners.append(listen)
    sim.advance(s=5)
    assert targetted == []
    client = sim.connect("can0")
    client.heartbeat()
    sim.advance(s=2)
    assert targetted != []
    client.link.close()
    ended_us = sim.now_us()
    sim.advance(s=4)
    silent = len(targetted)
    sim.advance(s=10)
    assert len(targetted) == silent
    assert sim.now_us() - ended_us == 14_000_000


def test_four_askers_have_a_port_each_and_a_fifth_none(start: Starts) -> None:
    sim = start({"can0": BUS, "console": CONSOLE})
    clients = [
        sim.connect("can0", Source(255, 190 + own), tunnel=Tunnel(own=own, serial=own % 4))
        for own in range(20, 25)
    ]
    for client in clients:
        client.heartbeat()
    sim.advance(s=3)
    for client in clients[:4]:
        assert client.command_long(ON_OFF, 1).result == ACCEPTED
        assert of("HEARTBEAT", client.pass_time(2_000_000))
    assert clients[4].pass_time(1_000_000) == []
    assert "4 opened" in Shell(sim)("can")
    clients[0].link.close()
    sim.advance(s=4)
    clients[4].heartbeat()
    assert clients[4].command_long(ON_OFF, 0).result == ACCEPTED, "a port that became free"


def test_next_asker_of_a_port_inherits_neither_bytes_nor_version(start: Starts) -> None:
    sim = start({"can0": BUS})
    first = sim.connect("can0", tunnel=Tunnel(own=20))
    first.version = 1
    first.heartbeat()
    assert first.command_long(ON_OFF, 0).get_msgbuf()[0] == 0xFE
    first.link.send(b"\xfd\xff\x00\x00\x07\xff\xbe\x4c\x00\x00")  # of 267 bytes, ten
    sim.advance(10_000)
    first.link.close()
    sim.advance(s=4)
    second = sim.connect("can0", tunnel=Tunnel(own=21))
    second.link.send(b"")
    assert second.recv("HEARTBEAT", timeout_us=0).get_msgbuf()[0] == 0xFD
    assert second.command_long(ON_OFF, 1, timeout_us=0).result == ACCEPTED


def test_good_frame_behind_a_false_start_is_found_once_the_tunnel_is_silent(start: Starts) -> None:
    sim = start({"can0": BUS})
    client = sim.connect("can0")
    client.heartbeat()
    sim.advance(s=1)
    client.link.send(b"\xfd\xff\x00\x00\x07\xff\xbe\x4c\x00\x00")
    client.send_command_long(ON_OFF, 1)
    assert of("COMMAND_ACK", client.pass_time(49_000)) == []
    assert of("COMMAND_ACK", client.pass_time(2_000)) != []


def test_uart_and_can_at_once(start: Starts) -> None:
    sim = start({"can0": BUS, "uart0": "udpin:127.0.0.1:0"})
    over_can, over_uart = sim.connect("can0"), sim.connect("uart0", Source(255, 191))
    for client in (over_can, over_uart):
        client.heartbeat()
    sim.advance(s=2)
    for asking, other in ((over_can, over_uart), (over_uart, over_can)):
        other.pass_time(0)
        assert asking.command_long(ON_OFF, 1).result == ACCEPTED
        assert of("COMMAND_ACK", other.pass_time(0)) == []
    sim.advance(s=10)
    for client in (over_can, over_uart):
        assert len(of("HEARTBEAT", client.pass_time(0))) >= 10


# --- shell ----------------------------------------------------------------------------------------
def test_shell_tells_node_state_and_counters(peer: Peer) -> None:
    peer.tell(lights(63))
    shell = Shell(peer.sim)
    told = shell("can")
    assert f"node id       {NODE}" in told
    assert "error-active" in told
    assert "applied 1, refused 0" in told
    stats = shell("link stats")
    assert "can0    rx" in stats
    assert "tunnel0 rx" in stats
