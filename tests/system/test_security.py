# SPDX-License-Identifier: Apache-2.0
"""docs/security.md, cell by cell: each way tries each right in each state, over the wire.

What came of it is read over DroneCAN, which may always look."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from dronecan import uavcan

from dronecan_peer import Peer
from ftp_client import WRITES, FtpClient
from harness import CONSOLE, ROOT, WIRES, Light, Shell, light_on, of
from imc_light import join
from parameters import ask, send_set
from pharos import SilentError, Simulator
from pharos.imc import ImcPeer, message
from signing_attacks import KEY, OTHER_KEY

Starts = Callable[..., Simulator]

UNIX = 1_720_000_000
STAMP = (UNIX - 1_420_070_400) * 100_000  # 10 us since 2015
# LGT_SRC_EXCL
EXCLUDED = {"MAVLink": 1, "DroneCAN": 2, "IMC": 4, "console": 8, "button": 8}
FALLBACK = 5  # LGT_SRC_NOW
PAN_ACTUATOR = 9
DO_MOUNT_CONTROL = 205
REBOOT = 246


@dataclass(frozen=True)
class Cell:
    """A way and a right, in a state; whether it may."""

    way: str
    right: str
    allowed: bool
    key: bool
    excluded: bool
    grant: int = 0

    def __str__(self) -> str:
        state = ("keyed" if self.key else "open") + ("-excluded" if self.excluded else "")
        return f"{self.way}-{self.grant}-{state}-{self.right}"


def _table(title: str) -> Iterator[tuple[str, str, str]]:
    """Way, right and cell of the table under that heading."""
    text = (ROOT / "docs" / "security.md").read_text().split(f"\n## {title}\n")[1]
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text.split("\n## ")[0].splitlines()
        if line.startswith("|")
    ]
    rights = rows[0][1:]
    for way, *cells in rows[2:]:
        for right, cell in zip(rights, cells, strict=True):
            yield way, right, cell


def _cells() -> Iterator[Cell]:
    for way, right, cell in _table("Without a key"):
        if cell != "–":
            yield Cell(way, right, cell == "yes", key=False, excluded=False)
    for way, right, cell in _table("With a key"):
        if cell != "–":
            grant = re.search(r"` (\d)$", way)
            name = way if way.startswith("MAVLink") else way.partition(",")[0]
            allowed = cell == "yes"
            yield Cell(name, right, allowed, True, False, int(grant[1]) if grant else 0)
    for way, right, cell in _table("Excluded, with a key or without"):
        for key in (False, True) if cell != "–" else ():
            signed = "MAVLink, signed" if key and way == "MAVLink" else way
            yield Cell(signed, right, cell == "yes", key, True, 2)


CELLS = list(_cells())


class World:
    """A light with all its ways in."""

    def __init__(self, sim: Simulator, cell: Cell) -> None:
        self.sim = sim
        self.cell = cell
        self.light = light_on(sim)
        self.shell = Shell(sim)
        self.imc: ImcPeer = join(sim, "imc")
        self.peer = Peer(sim)
        for line in (
            "param set MAV_SECURE 255",
            f"param set CAN_ACT_PAN {PAN_ACTUATOR}",
            f"param set MAV_KEY_CAN {cell.grant}",
            f"param set MAV_KEY_IMC {cell.grant}",
        ):
            self.shell(line)
        if cell.right == "exist":
            self.shell("param set LGT_LOSS 3")
            self.shell("param set LGT_FALLBACK 1")
            self.shell("light on")
        if cell.key:
            self.shell(f"signing key {UNIX}")
            self.shell(KEY.hex())
        if cell.excluded:
            self.shell(f"param set LGT_SRC_EXCL {EXCLUDED[cell.way.partition(',')[0]]}")
        if cell.way == "MAVLink, signed":
            self.light.mav.sign(KEY, STAMP + 100 * 100_000)
        sim.advance(s=1)

    def read(self, name: str) -> float:
        return self.peer.param(name)

    def output(self, name: str) -> int:
        return int(self.sim.outputs()[name])

    def pan(self) -> int:
        return int(self.sim.outputs()["servos"]["pan"]["angle_mdeg"])

    def aux(self) -> tuple[Any, ...]:
        outputs = self.sim.outputs()
        return tuple(p["pulse_ns"] for p in outputs["pwm"][3:5]), outputs["lines"]["power_aux"]


class MavlinkWay:
    def __init__(self, world: World) -> None:
        self.light: Light = world.light

    def _command(self, number: int, *params: float, component: int = 243) -> None:
        mav = self.light.mav
        seven = (list(params) + [0.0] * 7)[:7]
        mav.send(mav.dialect.MAVLink_command_long_message(1, component, number, 0, *seven))

    def read(self) -> bool:
        self.light.mav.drain()
        self.light.mav.inbox.clear()
        ask(self.light, "STRB_MIN")
        self.light.sim.advance(s=1)
        return len(of("PARAM_VALUE", self.light.mav.drain())) == 1

    def exist(self) -> None:
        self.light.mav.heartbeat()

    def light_on(self) -> None:
        self._command(405, 1.0)

    def gimbal(self) -> None:
        self._command(DO_MOUNT_CONTROL, 0.0, 0.0, 20.0, 0.0, 0.0, 0.0, 2.0, component=154)

    def set(self, name: str, value: float) -> None:
        send_set(self.light.mav, name, value)

    def key(self) -> None:
        mav = self.light.mav
        mav.send(mav.dialect.MAVLink_setup_signing_message(1, 243, OTHER_KEY, STAMP))

    def restart(self) -> None:
        self._command(REBOOT, 0.0, 0.0, 1.0, 0.0, 0.0, 20190226.0)  # forced

    def update(self) -> bool:
        try:
            return FtpClient(self.light.mav).ask(WRITES["create"], b"firmware.bin").error == 0
        except SilentError:
            return False


class DronecanWay:
    def __init__(self, world: World) -> None:
        self.peer = world.peer

    def read(self) -> bool:
        return self.peer.param("STRB_MIN") == 0.01

    def exist(self) -> None:
        self.light_on()

    def light_on(self) -> None:
        self.peer.tell(uavcan.equipment.hardpoint.Command(hardpoint_id=0, command=1))

    def gimbal(self) -> None:
        command = uavcan.equipment.actuator.Command(
            actuator_id=PAN_ACTUATOR, command_type=0, command_value=0.5
        )
        self.peer.tell(uavcan.equipment.actuator.ArrayCommand(commands=[command]))

    def set(self, name: str, value: float) -> None:
        self.peer.param(name, value)

    def restart(self) -> None:
        request = uavcan.protocol.RestartNode.Request()
        request.magic_number = request.MAGIC_NUMBER
        self.peer.ask(request)

    def update(self) -> bool:
        request = uavcan.protocol.file.BeginFirmwareUpdate.Request()
        request.image_file_remote_path.path.encode("light.bin")
        return int(self.peer.ask(request).error) == 0


class ImcWay:
    def __init__(self, world: World) -> None:
        self.imc = world.imc

    def read(self) -> bool:
        try:
            self.imc.ask("QueryLedBrightness", "LedBrightness", name="lamp")
        except SilentError:
            return False
        return True

    def _tell(self, name: str, /, **fields: Any) -> None:
        self.imc.send(name, **fields)
        self.imc.pass_time(0)

    def exist(self) -> None:
        self._tell("Heartbeat")

    def light_on(self) -> None:
        self._tell("SetLedBrightness", name="lamp", value=255)

    def gimbal(self) -> None:
        self._tell("SetServoPosition", id=0, value=0.5)

    def outputs(self) -> None:
        self._tell("SetPWM", id=1, period=2000, duty_cycle=500)

    def set(self, name: str, value: float) -> None:
        entity = {"THR": "Thermal", "MAV": "MAVLink"}.get(name[:3], "Lamp")
        wanted = [message("EntityParameter", name=name, value=str(value))]
        self._tell("SetEntityParameters", name=entity, params=wanted)


class ConsoleWay:
    def __init__(self, world: World) -> None:
        self.shell = world.shell

    def read(self) -> bool:
        return "brightness" in self.shell("light status")

    def exist(self) -> None:
        self.light_on()

    def light_on(self) -> None:
        self.shell("light on")

    def gimbal(self) -> None:
        self.shell("gimbal pan 20")

    def outputs(self) -> None:
        self.shell("power on aux")

    def set(self, name: str, value: float) -> None:
        self.shell(f"param set {name} {value}")

    def key(self) -> None:
        self.shell(f"signing key {UNIX + 100}")
        self.shell(OTHER_KEY.hex())

    def restart(self) -> None:
        self.shell("kernel reboot cold")


class ButtonWay:
    def __init__(self, world: World) -> None:
        self.sim = world.sim

    def exist(self) -> None:
        self.light_on()

    def light_on(self) -> None:
        for level in (False, True):  # low is pressed
            self.sim.gpio("button", level)
            self.sim.advance(200_000)


WAYS: dict[str, Callable[[World], Any]] = {
    "MAVLink": MavlinkWay,
    "MAVLink, signed": MavlinkWay,
    "MAVLink, unsigned": MavlinkWay,
    "DroneCAN": DronecanWay,
    "IMC": ImcWay,
    "console": ConsoleWay,
    "button": ButtonWay,
}


def _set(world: World, way: Any, name: str, value: float) -> bool:
    assert world.read(name) != value
    way.set(name, value)
    world.sim.advance(s=1)
    return world.read(name) == value


def _changes(world: World, act: Callable[[], None], look: Callable[[], Any]) -> bool:
    before = look()
    act()
    world.sim.advance(s=2)
    return bool(look() != before)


def _exists(world: World, way: Any) -> bool:
    for _ in range(10):
        way.exist()
        world.sim.advance(s=1)
    return world.read("LGT_SRC_NOW") != FALLBACK


def _tries(world: World, way: Any, right: str) -> bool:
    """Whether it has an effect."""
    # a parameter of the lock that does not grant this way anything
    lock = "MAV_KEY_CAN" if isinstance(way, ImcWay) else "MAV_KEY_IMC"
    other = 1 if world.cell.grant != 1 else 0
    return {
        "read": lambda: bool(way.read()),
        "exist": lambda: _exists(world, way),
        "light": lambda: _changes(world, way.light_on, lambda: world.output("enable")),
        "gimbal": lambda: _changes(world, way.gimbal, world.pan),
        "outputs": lambda: _changes(world, way.outputs, world.aux),
        "params": lambda: _set(world, way, "STRB_MIN", 0.05),
        "supervision": lambda: _set(world, way, "THR_SHUTDOWN", 99.5),
        "lock": lambda: _set(world, way, lock, other),
        "key": lambda: _changes(
            world, way.key, lambda: re.findall(r"(\d+) obeyed|key +(\w+)",
                                               world.shell("signing status"))
        ) if isinstance(way, MavlinkWay) else "signing is on" in _typed(world, way),
        "restart": lambda: _changes(world, way.restart, lambda: world.output("resets")),
        "update": lambda: bool(way.update()),
    }[right]()  # fmt: skip


def _typed(world: World, way: ConsoleWay) -> str:
    way.shell(f"signing key {UNIX + 100}")
    return way.shell(OTHER_KEY.hex())


@pytest.mark.parametrize("cell", CELLS, ids=str)
def test_cell(start: Starts, cell: Cell) -> None:
    sim = start(
        {"uart0": WIRES["udp"], "can0": "udp:127.255.255.255:{port}", "console": CONSOLE},
        options=("--imc", "udp:127.0.0.1:0,discovery={port}"),
    )
    world = World(sim, cell)
    assert _tries(world, WAYS[cell.way](world), cell.right) == cell.allowed


def test_every_row_is_tried() -> None:
    """So that a table which is read wrongly does not pass for nothing tried."""
    assert len(CELLS) > 150
    assert {cell.way for cell in CELLS} == set(WAYS)
    assert sum(cell.allowed for cell in CELLS) > 60


# --- what was scheduled before --------------------------------------------------------------------
SCHEDULE_ON = 3  # PowerChannelControl
PWR_DOWN, PWR_UP = 0, 4  # PowerOperation


@pytest.mark.parametrize(
    "line", ["", "param set LGT_SRC_EXCL 4", f"signing key {UNIX}\r{KEY.hex()}"],
    ids=["may", "excluded", "keyed"],
)  # fmt: skip
def test_schedules_lapse_with_the_right_to_have_them(start: Starts, line: str) -> None:
    sim = start(
        {"uart0": WIRES["udp"], "console": CONSOLE},
        options=("--imc", "udp:127.0.0.1:0,discovery={port}"),
    )
    light = light_on(sim)
    shell = Shell(sim)
    imc = join(sim, "imc")
    assert light.on() == 0
    imc.send("PowerChannelControl", name="aux", op=SCHEDULE_ON, sched_time=10.0)
    imc.send("PowerOperation", op=PWR_DOWN, time_remain=8.0)
    imc.pass_time(1_000_000)
    for part in line.split("\r"):
        shell(part)
    sim.advance(s=15)
    may = not line
    lines = sim.outputs()["lines"]
    assert (sim.outputs()["level_ppm"], lines["power_lamp"]) == ((0, 0) if may else (1_000_000, 1))
    assert "on in" not in shell("power status")
    imc.send("PowerOperation", op=PWR_UP)
    imc.pass_time(1_000_000)
    assert sim.outputs()["lines"]["power_aux"] == may
