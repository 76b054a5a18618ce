# SPDX-License-Identifier: Apache-2.0
"""What every system test builds on: a light under virtual time and a MAVLink client at its wire.

Numbers are wire values of MAVLink's common.xml, so that a test fails if ours drift."""

from __future__ import annotations

import math
import os
import re
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from dronecan import uavcan

from pharos import MavlinkConnection, Simulator, Source, Tunnel, find_dialect, load_dialect
from qemu import QemuSimulator

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()
BINARY = BUILD / "pharos"

# MAV_CMD
ON_OFF = 405
CONFIGURE = 406
GET_MESSAGE_INTERVAL = 510
SET_MESSAGE_INTERVAL = 511
REQUEST_MESSAGE = 512

# MAV_RESULT
ACCEPTED = 0
DENIED = 2
UNSUPPORTED = 3
FAILED = 4

# Message ids
HEARTBEAT = 0
MESSAGE_INTERVAL = 244
INFORMATION = 396
STATUS = 440

# ILLUMINATOR_ERROR_FLAGS
THROTTLING = 1
OVER_TEMPERATURE = 2
THERMISTOR_FAILURE = 4

INTERNAL = 1
EXTERNAL_SYNC = 2

# MAV_STATE
STATE_ACTIVE = 4
STATE_CRITICAL = 5
STATE_EMERGENCY = 6

NAN = math.nan
INF = math.inf
FULL_PPM = 1_000_000
SECOND_US = 1_000_000

# What a UART can be, as the light's command line takes it.
WIRES: dict[str, str] = {
    "udp": "udpin:127.0.0.1:0",
    "tcp": "tcpin:127.0.0.1:0",
    "pty": "pty:{folder}/uart0",
}
# A user-space CAN bus of the test's own; PHAROS_BUS=socketcan:vcan0 is one of the kernel's.
BUS = os.environ.get("PHAROS_BUS", "udp:127.255.255.255:{port}")
HAS_OWN_CONTROLLER = not BUS.startswith("udp")
NODE = 68  # CAN_NODE_ID by default


@dataclass(frozen=True)
class Transport:
    """How MAVLink reaches the light: a UART, or the tunnel over a CAN bus."""

    wire: str
    address: str
    fd: bool = False

    @property
    def is_can(self) -> bool:
        return self.wire.startswith("can")


TRANSPORTS = {name: Transport("uart0", address) for name, address in WIRES.items()} | {
    "can": Transport("can0", BUS),
    "canfd": Transport("can0", BUS, fd=True),
}


class OnlyQemu(dict[str, Transport]):
    """The one way to an image; a test that names another is skipped."""

    def __missing__(self, name: str) -> Transport:
        pytest.skip(f"needs the native port: over {name}")


# The same tests over the UART of a Zephyr image for mps2_an385, in QEMU.
QEMU_IMAGE = os.environ.get("PHAROS_QEMU_IMAGE")
if QEMU_IMAGE:
    TRANSPORTS = OnlyQemu(qemu=Transport("uart0", "qemu"))
# Who speaks on a wire: the illuminator, and the gimbal of a board with servos.
COMPONENTS = (243,) if QEMU_IMAGE else (243, 154)
# How much the clock may go on while a command is handled: the native port's code takes no time.
CODE_TAKES_MS = 1 if QEMU_IMAGE else 0

# What 440 says of the settings; the rest is time and temperature.
SETTINGS = (
    "enable",
    "mode",
    "brightness",
    "strobe_period",
    "strobe_duty_cycle",
    "mode_bitmask",
    "min_strobe_period",
    "max_strobe_period",
)


def f32(value: float) -> float:
    """The value as it is once it has crossed the wire as a 32-bit float."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


class Light:
    """A running light (`sim`) and a client (`mav`) on its `wire`, already introduced."""

    def __init__(self, sim: Simulator, mav: MavlinkConnection, wire: str = "uart0") -> None:
        self.sim = sim
        self.mav = mav
        self.wire = wire

    def greet(self) -> None:
        """Introduces the client, and waits until the light is up and has sampled its temperature
        (10 Hz), which lifts the limit that holds until then."""
        self.mav.heartbeat()
        self.sim.advance(s=1)
        self.mav.recv("HEARTBEAT")
        if QEMU_IMAGE:
            self.sim.advance(500_000)  # code takes time there: away from the instants of streams

    def on(self) -> int:
        return int(self.mav.command_long(ON_OFF, 1).result)

    def off(self) -> int:
        return int(self.mav.command_long(ON_OFF, 0).result)

    def configure(
        self,
        brightness: float = 100.0,
        period_s: float = 0.0,
        duty: float = 100.0,
        mode: float = INTERNAL,
    ) -> int:
        return int(self.mav.command_long(CONFIGURE, mode, brightness, period_s, duty).result)

    def status(self) -> Any:
        """A fresh ILLUMINATOR_STATUS, on request."""
        ack = self.mav.command_long(REQUEST_MESSAGE, STATUS)
        assert ack.result == ACCEPTED
        return self.mav.recv("ILLUMINATOR_STATUS", timeout_us=0)

    def settings(self) -> dict[str, Any]:
        status = self.status()
        return {name: getattr(status, name) for name in SETTINGS}

    def level_ppm(self) -> int:
        """The lamp's output now."""
        return int(self.sim.outputs()["level_ppm"])

    def collect(self, seconds: float) -> list[Any]:
        """Everything that comes within the next seconds; what lay there before is dropped."""
        self.mav.drain()
        self.mav.inbox.clear()
        return self.mav.pass_time(round(seconds * 1e6))


# The wire of the device's own shell.
CONSOLE = "pty:{folder}/shell"


class Shell:
    """Types lines at the console and reads what comes back, without colours and cursor movement."""

    def __init__(self, sim: Simulator) -> None:
        self.sim = sim
        self._link = sim.open("console")
        self("")

    def keys(self, keys: str, pass_us: int = 300_000) -> str:
        self._link.send(keys.encode())
        self.sim.advance(pass_us)
        text = b"".join(self._link.take()).decode(errors="replace")
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text).replace("\r", "")

    def __call__(self, line: str) -> str:
        return self.keys(line + "\r")


def of(kind: str, messages: Sequence[Any]) -> list[Any]:
    return [m for m in messages if m.get_type() == kind]


def from_light(messages: Iterable[Any], component: int = 243) -> list[Any]:
    """Those of the light, not of the device's gimbal, or the other way round."""
    return [m for m in messages if m.get_srcComponent() == component]


def payload_of(message: Any) -> bytes:
    """The payload as it came over the wire, in MAVLink 2: 10 bytes of header, 2 of checksum."""
    frame = bytes(message.get_msgbuf())
    assert frame[0] == 0xFD
    return frame[10:-2]


def texts(messages: Sequence[Any]) -> list[str]:
    """The STATUSTEXTs among `messages`."""
    return [str(m.text) for m in of("STATUSTEXT", messages)]


def simulator(wires: dict[str, str] | None = None, **kwargs: Any) -> Simulator:
    dialect = load_dialect(find_dialect(BUILD))
    if QEMU_IMAGE:
        return QemuSimulator(Path(QEMU_IMAGE), wires, dialect=dialect, **kwargs)
    return Simulator(BINARY, wires, dialect=dialect, **kwargs)


def light_on(
    sim: Simulator, source: Source | None = None, transport: Transport | None = None
) -> Light:
    """A client on a running simulator's wire of that transport; without one, uart0."""
    transport = transport or next(iter(TRANSPORTS.values()))
    light = Light(sim, connect(sim, transport, source), transport.wire)
    light.greet()
    return light


def connect(
    sim: Simulator, transport: Transport, source: Source | None = None
) -> MavlinkConnection:
    """The same, not yet introduced."""
    if transport.fd:
        set_over_can(sim, "CAN_FD", 1)
        sim.reset()
    return sim.connect(transport.wire, source, tunnel=Tunnel(fd=transport.fd))


def set_over_can(sim: Simulator, name: str, value: int) -> None:
    """Sets a parameter as a node on the bus does."""
    request = uavcan.protocol.param.GetSet.Request()
    request.name.encode(name)
    request.value.integer_value = value
    node = sim.node(9)
    assert node.ask(request, NODE, sim).value.integer_value == value
    node.close()
