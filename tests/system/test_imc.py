# SPDX-License-Identifier: Apache-2.0
"""The light as an IMC node, over TCP, UDP and a pty, in both byte orders."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from harness import WIRES, Shell, light_on
from imc_light import IMC_WIRES, LAMP, SYSTEM, THERMAL, ImcLight, join
from pharos import Simulator
from pharos.imc import ImcPeer, Packet, message
from pharos.link import TcpListenLink

MAVLINK_AND_IMC = {"uart0": WIRES["udp"], "uart1": WIRES["tcp"]}
NETWORK = IMC_WIRES["udp"][1]


def of(name: str, packets: list[Packet]) -> list[Packet]:
    return [packet for packet in packets if packet.name == name]


# --- entities ---------------------------------------------------------------------------------


def test_entity_list_names_what_there_is(imc: ImcLight) -> None:
    answer = imc.peer.ask("EntityList", "EntityList", op=1)
    assert answer["op"] == 0
    assert answer["list"].startswith(b"System=0;Lamp=1;Thermal=2;")
    assert (answer.src, answer.src_ent) == (0x8442, SYSTEM)
    assert (answer.dst, answer.dst_ent) == (imc.peer.id, imc.peer.entity)


def test_entity_state_of_one_and_of_all(imc: ImcLight) -> None:
    entities = imc.peer.ask("EntityList", "EntityList", op=1)["list"].count(b"=")
    state = imc.peer.ask("QueryEntityState", "EntityState", dst_ent=LAMP)
    assert (state["state"], state["description"]) == (1, b"active")
    assert state.src_ent == LAMP
    imc.peer.send("QueryEntityState")
    states = of("EntityState", imc.peer.pass_time(0))
    assert [packet.src_ent for packet in states] == list(range(entities))


def test_entity_info_follows_the_header(imc: ImcLight) -> None:
    info = imc.peer.ask("QueryEntityInfo", "EntityInfo", dst_ent=THERMAL, id=LAMP)
    assert (info["id"], info["label"]) == (THERMAL, b"Thermal")
    info = imc.peer.ask("QueryEntityInfo", "EntityInfo", id=LAMP)
    assert (info["id"], info["label"]) == (LAMP, b"Lamp")


def test_version_and_activation(imc: ImcLight) -> None:
    assert imc.peer.ask("VersionInfo", "VersionInfo", op=0)["version"] == b"0.1.0"
    activation = imc.peer.ask("QueryEntityActivationState", "EntityActivationState", dst_ent=LAMP)
    assert activation["state"] == 1


def test_a_hot_lamp_is_told_to_its_peers(imc: ImcLight) -> None:
    imc.sim.set(temp_mdegc=120_000)
    came = of("EntityState", imc.peer.pass_time(2_000_000))
    hot = [p for p in came if p.src_ent == LAMP and p["state"] != 1]
    assert hot, "nothing was told"
    assert hot[-1]["state"] == 3  # ERROR
    assert hot[-1].dst == 0xFFFF


# --- parameters -------------------------------------------------------------------------------


def parameters(packet: Packet) -> dict[bytes, bytes]:
    return {item["name"]: item["value"] for item in packet["params"]}


def wanted(**values: str) -> list[object]:
    return [message("EntityParameter", name=n, value=v) for n, v in values.items()]


def test_parameters_are_told_and_set(imc: ImcLight) -> None:
    told = imc.peer.ask("QueryEntityParameters", "EntityParameters", name="Thermal")
    assert told["name"] == b"Thermal"
    assert parameters(told)[b"THR_SHUTDOWN"] == b"100"
    answer = imc.peer.ask(
        "SetEntityParameters", "EntityParameters", name="Thermal",
        params=wanted(THR_SHUTDOWN="90.5", THR_RECOVER="95", NONE="1"),
    )  # fmt: skip
    assert parameters(answer) == {b"THR_SHUTDOWN": b"90.5"}
    told = imc.peer.ask("QueryEntityParameters", "EntityParameters", name="Thermal")
    assert parameters(told)[b"THR_SHUTDOWN"] == b"90.5"


def test_parameters_survive_a_power_cut(imc: ImcLight) -> None:
    imc.peer.ask(
        "SetEntityParameters", "EntityParameters", name="Lamp", params=wanted(LGT_CURVE="0")
    )
    imc.sim.advance(s=2)
    imc.sim.reset()
    imc.sim.advance(s=2)
    told = imc.peer.ask("QueryEntityParameters", "EntityParameters", name="Lamp")
    assert parameters(told)[b"LGT_CURVE"] == b"0"


def test_what_is_not_known_is_logged_once_a_second(start: Callable[..., Simulator]) -> None:
    wire, address, options = IMC_WIRES["tcp"]
    sim = start({wire: address}, options=options)
    peer = join(sim, wire)
    for _ in range(3):
        peer.send("QueryEntityParameters", name="Nothing")
        assert of("EntityParameters", peer.pass_time(100_000)) == []
    assert sim.console().count("QueryEntityParameters of 0x4001: unknown name") == 1


# --- addresses --------------------------------------------------------------------------------


@pytest.mark.parametrize(("dst", "dst_ent"), [(0x8443, 255), (0x8442, 200), (0, 255)])
def test_what_is_for_others_is_not_answered(imc: ImcLight, dst: int, dst_ent: int) -> None:
    imc.peer.send("QueryEntityState", dst=dst, dst_ent=dst_ent)
    assert of("EntityState", imc.peer.pass_time(500_000)) == []
    imc.peer.send("QueryEntityState", dst=0xFFFF, dst_ent=LAMP)
    assert len(of("EntityState", imc.peer.pass_time(500_000))) == 1


def test_heartbeats_come_once_a_second_until_the_peer_is_silent(imc: ImcLight) -> None:
    beats = of("Heartbeat", imc.peer.pass_time(20_000_000))
    assert len(beats) == 20
    assert {packet.dst for packet in beats} == {imc.peer.id}
    imc.sim.advance(s=20)
    imc.peer.take()
    for_it = of("Heartbeat", imc.peer.pass_time(20_000_000))
    assert {packet.dst for packet in for_it} <= {0xFFFF}
    assert (for_it == []) == (imc.wire == "imc")


def test_noise_and_malformed_packets_cost_nothing(imc: ImcLight) -> None:
    good = imc.peer.encode(imc.peer.packet("QueryEntityState", dst_ent=LAMP))
    broken = [good[:-1] + bytes([good[-1] ^ 1]), good[:19], b"\x54\xfe" + bytes(30), b"\xfe"]
    for bad in broken:
        imc.peer.link.send(bad)
    imc.peer.link.send(good)
    came = of("EntityState", imc.peer.pass_time(300_000))
    assert [packet.src_ent for packet in came] == [LAMP]


def test_a_claim_of_more_bytes_than_come_stalls_nothing(imc: ImcLight) -> None:
    good = imc.peer.encode(imc.peer.packet("QueryEntityState", dst_ent=LAMP))
    for claimed in (0xFFFF, 1400, 200):
        false_start = b"\x54\xfe\x3a\x01" + claimed.to_bytes(2, "little") + bytes(14)
        imc.peer.link.send(false_start)
        imc.peer.link.send(good)
        assert len(of("EntityState", imc.peer.pass_time(100_000))) == 1


# --- discovery --------------------------------------------------------------------------------


def test_announces_itself_every_ten_seconds(start: Callable[..., Simulator]) -> None:
    sim = start({"imc": NETWORK})
    assert sim.request("imc")["tx_datagrams"] == 5  # at once, to each of the five ports
    peer = sim.imc()
    announces = of("Announce", peer.pass_time(35_000_000))
    assert [packet.timestamp for packet in announces] == [10, 20, 30]
    first = announces[0]
    assert (first.src, first.dst, first["owner"]) == (0x8442, 0, 0xFFFF)
    assert first["sys_name"] == b"pharos-light"
    host, port = peer.link.light  # type: ignore[attr-defined]
    assert f"imc+udp://{host}:{port}/".encode() in first["services"]
    assert b"imc+info://0.0.0.0/version/5.4.31" in first["services"]


def test_nobody_gets_heartbeats_before_being_heard(start: Callable[..., Simulator]) -> None:
    sim = start({"imc": NETWORK})
    peer = sim.imc()
    assert of("Heartbeat", peer.pass_time(5_000_000)) == []
    peer.announce()
    assert len(of("Heartbeat", peer.pass_time(5_000_000))) == 5


@pytest.mark.parametrize("scope", [0, 1, 2])
def test_announcements_go_where_the_parameter_says(
    start: Callable[..., Simulator], scope: int
) -> None:
    sim = start({"imc": NETWORK})
    peer = join(sim, "imc")
    peer.ask(
        "SetEntityParameters", "EntityParameters", name="IMC",
        params=wanted(IMC_ANNOUNCE=str(scope)),
    )  # fmt: skip
    heard = of("Announce", peer.pass_time(10_000_000))
    # A socket on 127.0.0.1 hears neither broadcasts nor the group.
    assert bool(heard) == (scope == 0)
    assert sim.request("imc")["errors"] == 0


def test_its_port_stays_over_a_reset(start: Callable[..., Simulator]) -> None:
    sim = start({"imc": NETWORK})
    peer = join(sim, "imc")
    before = sim.request("imc")
    sim.reset()
    sim.advance(s=1)
    after = sim.request("imc")
    assert after["address"] == before["address"]
    assert after["discovery_port"] == before["discovery_port"]
    assert peer.ask("QueryEntityState", "EntityState", dst_ent=LAMP)["state"] == 1


def test_no_network_no_announcements(start: Callable[..., Simulator]) -> None:
    sim = start({"uart0": WIRES["udp"]})
    sim.advance(s=30)
    assert sim.request("imc")["tx_datagrams"] == 0


def test_a_light_that_connects_is_a_node_as_well(start: Callable[..., Simulator]) -> None:
    listener = TcpListenLink(("127.0.0.1", 0))
    sim = start({"uart0": "tcp:{}:{}".format(*listener.address)}, options=("--protocol", "imc"))
    sim.attach("uart0", listener, from_start=True)
    peer = ImcPeer(listener, sim)
    # Nobody has spoken yet: its heartbeats are for everyone.
    beats = of("Heartbeat", peer.pass_time(5_000_000))
    assert {packet.dst for packet in beats} == {0xFFFF}
    assert peer.ask("QueryEntityState", "EntityState", dst_ent=LAMP)["state"] == 1
    assert {p.dst for p in of("Heartbeat", peer.pass_time(5_000_000))} == {peer.id}


def test_the_shell_tells_of_links_and_peers(start: Callable[..., Simulator]) -> None:
    sim = start(
        {"console": "pty:{folder}/shell", "imc": NETWORK, "uart1": WIRES["tcp"]},
        options=("--protocol", "imc"),
    )
    join(sim, "imc", id=0x4001)
    join(sim, "uart1", id=0x4002)
    said = Shell(sim)("imc")
    assert "id            0x8442" in said
    assert "uart1         speaks IMC" in said
    assert "peers         2, of 8; refused 0" in said
    assert "0x4001        127.0.0.1:" in said
    assert "0x4002        uart1, " in said


# --- several peers, several protocols ---------------------------------------------------------


def test_peers_on_every_transport_at_once(start: Callable[..., Simulator]) -> None:
    sim = start(
        {"imc": NETWORK, "uart0": WIRES["udp"], "uart1": WIRES["tcp"]},
        options=("--protocol", "imc", "--uart2", "pty:{folder}/uart2", "--protocol", "imc"),
    )
    mavlink = light_on(sim)
    peers = [join(sim, wire, id=0x4001 + i) for i, wire in enumerate(("imc", "uart1", "uart2"))]
    for peer in peers:
        for other in peers:
            other.take()
        peer.send("QueryEntityState", dst_ent=LAMP)
        sim.advance(0)
        for other in peers:
            assert len(of("EntityState", other.take())) == (1 if other is peer else 0)
    for peer in peers:
        peer.take()
    sim.advance(s=5)
    for peer in peers:
        beats = of("Heartbeat", peer.take())
        assert {packet.dst for packet in beats} == {peer.id}
        assert len(beats) == 5
    assert mavlink.on() == 0


def test_the_parameter_says_what_a_uart_speaks(start: Callable[..., Simulator]) -> None:
    sim = start(MAVLINK_AND_IMC | {"console": "pty:{folder}/shell"})
    shell = Shell(sim)
    shell("param set UART1_PROTO 1")
    sim.advance(s=2)
    sim.reset()
    peer = join(sim, "uart1")
    assert peer.ask("QueryEntityState", "EntityState", dst_ent=LAMP)["state"] == 1


def test_the_command_line_outranks_the_parameter(start: Callable[..., Simulator]) -> None:
    sim = start(
        {"console": "pty:{folder}/shell", "uart0": WIRES["udp"]}, options=("--protocol", "mavlink")
    )
    Shell(sim)("param set UART0_PROTO 1")
    sim.advance(s=2)
    sim.reset()
    assert light_on(sim).on() == 0


def test_the_id_is_a_parameter(start: Callable[..., Simulator]) -> None:
    wire, address, options = IMC_WIRES["tcp"]
    sim = start({wire: address}, options=options)
    peer = join(sim, wire)
    peer.ask("SetEntityParameters", "EntityParameters", name="IMC", params=wanted(IMC_ID="36863"))
    sim.advance(s=2)
    sim.reset()
    sim.advance(s=2)
    peer.light = 0x8FFF
    assert peer.ask("QueryEntityState", "EntityState", dst_ent=LAMP).src == 0x8FFF


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--protocol", "imc"), "say after --uartN what that UART speaks"),
        (("--uart0", "none", "--protocol", "nmea"), '"nmea" is neither mavlink nor imc'),
        (("--imc", "tcp:127.0.0.1:1"), "say udp:HOST:PORT or none"),
        (("--imc", "udp:localhost:1"), "has no IPv4 address and port"),
        (("--imc", "udp:127.0.0.1"), "has no IPv4 address and port"),
        (("--imc", "udp:127.0.0.1:65536"), "port: "),
        (("--imc", "udp:127.0.0.1:0,discovery=0"), "discovery: "),
        (("--imc", "udp:127.0.0.1:0,multicast"), "say udp:HOST:PORT[,discovery=PORT]"),
    ],
)
def test_wrong_options_end_with_one_line(options: tuple[str, ...], reason: str) -> None:
    import subprocess

    from harness import BINARY

    done = subprocess.run([BINARY, *options], capture_output=True, text=True, timeout=20)
    assert done.returncode == 2
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1
