# SPDX-License-Identifier: Apache-2.0
"""One light of a world: its process, its wires, its oracle, and what is said to it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dronecan import uavcan

from attacker import REAL32
from lamp import Effect
from oracle import ACCEPTED, FLIGHT_US, Oracle, Sent
from parties import KEY, STAMP, Party
from pharos import Simulator
from pharos.can_node import DronecanNode
from pharos.can_transfer import Transfer
from plan import SECOND_US

if TYPE_CHECKING:
    from world import World

HARDPOINT = 3
NODE = 10
OWN_NODE = 68  # the light's, by default
GIMBAL = 154
CAN_MOST = 5 * 400  # frames of one light in 5 s
IMC_MOST = 5 * 100  # datagrams
# docs/imc.md: one a second to each peer; and the time may have been cut in the middle of one.
IMC_HEARTBEATS_MOST = 5 + 3
HEARTBEAT = 150


class Light:
    """One light of the world: its process, its wires, its oracle."""

    def __init__(self, world: World, number: int) -> None:
        self.world = world
        self.number = number
        self.system = 1 + number
        features = world.plan.features
        wires = {"uart0": "tcpin:127.0.0.1:0"}
        if "ring" in features:
            wires |= {"uart1": "tcpin:127.0.0.1:0", "uart2": "tcpin:127.0.0.1:0"}
        if "imc" in features:
            wires["imc"] = "udp:127.0.0.1:0,discovery={port}"
        if "can" in features and number == 0:
            wires["can0"] = "udp:127.255.255.255:{port}"
        self.sim = Simulator(
            world.binary, wires, seed=world.plan.seed * 8 + number + 1, dialect=world.dialect
        )
        fallback = next((f for f in features if f.startswith("loss-")), "")
        self.oracle = Oracle(
            key="key" in features, restore="restore" in features, fallback=fallback
        )
        self.recorded: list[tuple[int, bytes]] = []
        self.twin: DronecanNode | None = None
        self.frames = 0
        self.far: Party
        self.is_silent = False
        self.insists = -1
        self.greets = False
        self.began_us = 0

    @property
    def address(self) -> tuple[int, int]:
        return self.system, 243

    def start(self) -> None:
        self.sim.start()
        self.links = {
            name: self.sim.open(name)
            for name in self.sim.wires()
            if self.sim.wires()[name].address.startswith("tcpin")
        }
        self.decoder = self.world.dialect.MAVLink(None, 255, 190)
        self.decoder.robust_parsing = True
        self.node = (
            self.sim.node(NODE)
            if "can" in self.world.plan.features and (self.number == 0)
            else None
        )
        if self.node is not None:
            self.node.subscribe(uavcan.protocol.NodeStatus, self._hears_node)
            self.oracle.around.node_us = 0
        self.imc = self.sim.imc() if "imc" in self.world.plan.features else None
        self.configure()

    def _hears_node(self, transfer: Transfer) -> None:
        if transfer.header.source != OWN_NODE:
            return
        self.oracle.around.node_us = self.now_us()
        if self.began_us:
            self.oracle.node_health(self.now_us(), int(transfer.message.health))

    # --- before the story begins --------------------------------------------------------------
    def configure(self) -> None:
        features = self.world.plan.features
        wanted = {"MAV_SYSID": self.system}
        if "restore" in features:
            wanted["LGT_RESTORE"] = 1
        if self.oracle.fallback:
            wanted |= {
                "LGT_LOSS": 5,
                "LGT_FALLBACK": 1 if self.oracle.fallback == "loss-off" else 2,
            }
        if "ring" in features:
            wanted["MAV_ROUTE"] = 1
        if "can" in features:
            wanted["CAN_HARDPT_ID"] = HARDPOINT
        if "exclusion" in features:
            wanted["LGT_SRC_EXCL"] = 2 + 4
        if "key" in features:
            wanted["MAV_SECURE"] = 1
        owner = Party(self.world.dialect, 255, 190)
        self.sim.advance(s=1)
        for name, value in wanted.items():
            self._set(owner, name, value)
        if "key" in features:
            setup = owner.d.MAVLink_setup_signing_message(1, 243, list(KEY), STAMP)
            if self.system != 1:  # its new id is in force after a reset
                setup.target_system = 1
            self.links["uart0"].send(owner.frame(setup, 0))
        self.sim.advance(s=3)
        self.sim.request("reset", cause="power-on")
        self.sim.advance(s=2)
        for link in self.links.values():
            link.take()
        outputs = self.sim.outputs()
        self.oracle.resets_seen = int(outputs["resets"])
        self.sim.skip_edges()
        self.began_us = self.sim.now_us()

    def _set(self, owner: Party, name: str, value: int) -> None:
        message = owner.d.MAVLink_param_set_message(1, 243, name.encode(), value, REAL32)
        self.links["uart0"].send(owner.frame(message, 0))
        self.sim.advance(100_000)

    # --- time ---------------------------------------------------------------------------------
    def now_us(self) -> int:
        """World time: since the story began."""
        return self.sim.now_us() - self.began_us

    def advance(self, us: int) -> None:
        """What came in a step in which the light was reset is not judged: part of it was sent
        before, part after."""
        outputs, edges = self.sim.observe(us)
        was_reset = int(outputs["resets"]) != self.oracle.resets_seen
        self.oracle.edges([(edge.time_us - self.began_us, edge.level_ppm) for edge in edges])
        if was_reset:
            self.world.tell(self, f"was reset: {outputs['reset_cause']}")
            self.links["uart0"].take()
        self.oracle.sample(self.now_us(), outputs)
        self.take()
        self.oracle.look_again(self.now_us(), outputs)

    def take(self) -> None:
        now_us = self.now_us()
        if self.node is not None:
            frames, self.frames = self.node.port.received - self.frames, self.node.port.received
            self.oracle.traffic(now_us, "can0", frames, CAN_MOST)
        if self.imc is not None:
            came = self.imc.link.take()
            beats = sum(int.from_bytes(each[2:4], "little") == HEARTBEAT for each in came)
            self.oracle.traffic(now_us, "imc", len(came), IMC_MOST)
            self.oracle.traffic(now_us, "imc heartbeats", beats, IMC_HEARTBEATS_MOST)
        data = b"".join(self.links["uart0"].take())
        if not data:
            return
        self.oracle.traffic(now_us, "uart0", len(data))
        for message in self.decoder.parse_buffer(data) or []:
            if message.get_type() == "BAD_DATA":
                continue
            source = (message.get_srcSystem(), message.get_srcComponent())
            if source == self.address:
                self._heard(now_us, message)
            elif message.get_type() == "COMMAND_ACK":
                self._heard_ack(now_us, source, message)

    def _heard_ack(self, now_us: int, source: tuple[int, int], message: Any) -> None:
        """Of the gimbal, or of another light to one of ours who asked it from here."""
        to = (message.target_system, message.target_component)
        if source == (self.system, GIMBAL):
            self.world.tell(self, f"gimbal answers {message.command}: {message.result}")
            self.oracle.acknowledged(now_us, to, message.command, message.result)
            self.oracle.gimbal.acknowledged(now_us, message.result == ACCEPTED)
        elif to == self.far.address:
            there = next(light for light in self.world.lights if light.address == source)
            there.oracle.acknowledged(there.now_us(), to, message.command, message.result)

    def _heard(self, now_us: int, message: Any) -> None:
        kind = message.get_type()
        if kind == "COMMAND_ACK":
            to = (message.target_system, message.target_component)
            self.world.tell(self, f"answers {message.command} of {to[0]}/{to[1]}: {message.result}")
            if self.world.is_far(to):
                return  # counts where it arrives
            self.oracle.acknowledged(now_us, to, message.command, message.result)
        elif kind == "ILLUMINATOR_STATUS":
            self.oracle.status(now_us, message)
        elif kind == "STATUSTEXT":
            self.world.tell(self, f"says '{message.text}'")

    # --- what is sent to it -------------------------------------------------------------------
    def hears_others(self) -> bool:
        """DroneCAN and IMC may command it, and are signs of life."""
        return "exclusion" not in self.world.plan.features and not self.oracle.key

    def greet(self) -> None:
        """A heartbeat of the IMC peer."""
        if self.imc is None:
            return
        self.imc.send("Heartbeat")
        if self.hears_others():
            self.oracle.life(self.now_us(), False)

    def is_sure(self) -> bool:
        around = self.oracle.around
        now_us = self.now_us()
        return (
            not around.wire_faulty
            and around.stalled_us is None
            and now_us - around.wire_clean_us > FLIGHT_US
            and now_us - around.up_us > SECOND_US
        )

    def write(self, party: Party, message: Any, *, record: bool = True) -> None:
        frame = party.frame(message, self.now_us())
        if record:
            self.recorded.append((self.now_us(), frame))
        self.links["uart0"].send(frame)

    def send(self, party: Party, message: Any, *, record: bool = False) -> None:
        self.write(party, message, record=record)
        self.advance(0)

    def command(
        self,
        party: Party,
        number: int,
        params: tuple[float, ...],
        effect: Effect,
        results: frozenset[int],
        to: tuple[int, int] | None = None,
    ) -> None:
        authorised = not self.oracle.key or party.key is not None
        one = Sent(party.address, number, effect, results, self.now_us(), self.is_sure())
        self.oracle.sent(one, authorised=authorised)
        self.send(party, party.command(number, *params, to=to or self.address), record=True)
