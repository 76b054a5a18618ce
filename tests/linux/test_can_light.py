# SPDX-License-Identifier: Apache-2.0
"""The light on a real kernel's CAN: its tunnel, and the `pharos` command, as users run them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import pytest

from guest_can import (
    ERR_BUSOFF,
    ERR_RESTARTED,
    HeldQueue,
    add_vcan,
    error_frame,
    link,
    vxcan,
)
from guest_gpio import GpioSim
from guest_light import BUILD, PATIENCE_S, ROOT, Light, Start, until
from pharos import MavlinkConnection, SilentError, find_dialect, load_dialect, open_link
from pharos.cli import main
from pharos.link import RealPacer

# MAV_CMD_ILLUMINATOR_ON_OFF, MAV_CMD_DO_ILLUMINATOR_CONFIGURE, MAV_RESULT_ACCEPTED
ON_OFF, CONFIGURE, ACCEPTED = 405, 406, 0
INTERNAL = 1  # ILLUMINATOR_MODE
NODE = 68  # CAN_NODE_ID by default
SILENT = 3  # what `pharos` ends with when somebody is


# The command, as an installation runs it.
PHAROS = (sys.executable, "-m", "pharos")
# At most; it reads every DSDL definition.
START_S = 60.0
DIALECT = find_dialect(BUILD)
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": str(ROOT / "host" / "src"),
    "PHAROS_DIALECT": str(DIALECT),
}


def url_of(interface: str) -> str:
    return f"dronecan:socketcan/{interface}?node={NODE}"


@contextmanager
def client(interface: str) -> Iterator[MavlinkConnection]:
    """A MAVLink client in real time, through the tunnel to the light."""
    with open_link(url_of(interface)) as tunnel:
        yield MavlinkConnection(tunnel, RealPacer([tunnel]), load_dialect(DIALECT))


def command(mav: MavlinkConnection, number: int, *params: float) -> None:
    """Repeated until it is acknowledged, as autopilots do."""

    def is_acknowledged() -> bool:
        try:
            return bool(mav.command_long(number, *params).result == ACCEPTED)
        except SilentError:
            return False

    until(f"command {number}", is_acknowledged)


def count(light: Light, name: str) -> int:
    return int(light.do("buses")["buses"]["can0"][name])


def is_on(light: Light) -> bool:
    return int(light.do("outputs")["enable"]) == 1


@dataclass
class Said:
    """What a command ended with, and what it printed."""

    status: int
    out: str
    err: str

    @property
    def objects(self) -> list[dict[str, Any]]:
        """The lines of --json."""
        return [json.loads(line) for line in self.out.splitlines()]


@pytest.fixture
def pharos(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., Said]:
    """pharos(ARG, …) in this process: without the seconds that Python takes to start here."""
    monkeypatch.setenv("PHAROS_DIALECT", str(DIALECT))

    def run(*args: str) -> Said:
        status = main(args)
        return Said(status, *capsys.readouterr())

    return run


@pytest.fixture
def light(start_can: Start, vcan0: str) -> Light:
    return start_can("--can0", f"socketcan:{vcan0}")


# --- the pharos command --------------------------------------------------------------------------


def test_shell_through_the_tunnel(light: Light, vcan0: str) -> None:
    done = subprocess.run(
        [*PHAROS, "shell", url_of(vcan0), "--json"], input="on\nbrightness 40\nstatus\n",
        capture_output=True, text=True, timeout=START_S + PATIENCE_S, env=ENVIRONMENT,
    )  # fmt: skip
    said = Said(done.returncode, done.stdout, done.stderr)
    assert (said.status, said.err) == (0, "")
    replies = [reply for reply in said.objects if "command" in reply]
    assert [reply["command"] for reply in replies] == ["on", "brightness", "status"]
    assert all(reply["ok"] for reply in replies)
    assert replies[-1]["brightness"] == 40
    outputs = light.do("outputs")
    assert (outputs["enable"], outputs["brightness_ppm"]) == (1, 400_000)


def test_nodes(light: Light, vcan0: str, pharos: Callable[..., Said]) -> None:
    said = pharos("can", "nodes", f"socketcan/{vcan0}", "--json", "--seconds", "4")
    assert (said.status, said.err) == (0, "")
    (node,) = said.objects
    assert (node["node"], node["name"], node["health"]) == (NODE, "org.pharos.light", "ok")


def test_monitor(light: Light, vcan0: str, pharos: Callable[..., Said]) -> None:
    count = ("--count", "2", "--only", "NodeStatus")
    said = pharos("can", "monitor", f"socketcan/{vcan0}", "--json", *count)
    assert (said.status, said.err) == (0, "")
    status = ("uavcan.protocol.NodeStatus", NODE)
    assert [(heard["type"], heard["source"]) for heard in said.objects] == [status] * 2


@pytest.mark.parametrize("via", ["hardpoint", "lights", "tunnel"])
def test_can_light(light: Light, vcan0: str, pharos: Callable[..., Said], via: str) -> None:
    how = ("--bus", f"socketcan/{vcan0}", "--via", via, "--node", str(NODE))
    for action, on in (("on", True), ("off", False)):
        said = pharos("can", "light", action, *how)
        assert (said.status, said.err) == (0, "")
        assert is_on(light) == on


def test_what_is_not_there_is_said_in_one_line(vcan0: str, pharos: Callable[..., Said]) -> None:
    silent = pharos("shell", url_of(vcan0), "--timeout", "1", "-c", "on")
    absent = pharos("shell", url_of("vcan9"), "-c", "on")
    for said, hint in ((silent, "no illuminator answered"), (absent, "vcan9: No such device")):
        assert (said.status, said.out) == (SILENT, "")
        assert hint in said.err
        assert said.err.count("\n") == 1


def test_shell_ends_with_one_line_when_its_interface_goes_down(light: Light, vcan0: str) -> None:
    process = subprocess.Popen(
        [*PHAROS, "shell", url_of(vcan0)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, env=ENVIRONMENT,
    )  # fmt: skip
    assert process.stdin is not None
    process.stdin.write("on\n")
    process.stdin.flush()
    until("on", lambda: is_on(light), START_S)
    link("set", vcan0, "down")
    out, err = process.communicate("off\n", timeout=PATIENCE_S)
    assert process.returncode == SILENT
    assert "Network is down" in err
    assert err.count("\n") == 1
    assert is_on(light)


# --- what goes wrong -----------------------------------------------------------------------------


def down(interface: str) -> None:
    link("set", interface, "down")


def up(interface: str) -> None:
    link("set", interface, "up")


def deleted(interface: str) -> None:
    link("del", interface)


@pytest.mark.parametrize(("go", "come_back"), [(down, up), (deleted, add_vcan)])
def test_lamp_stays_on_while_the_interface_is_gone_and_obeys_when_it_is_back(
    light: Light, vcan0: str, go: Callable[[str], None], come_back: Callable[[str], None]
) -> None:
    with client(vcan0) as mav:
        command(mav, ON_OFF, 1)
    go(vcan0)
    until("an error", lambda: count(light, "errors") > 0)
    assert is_on(light)
    come_back(vcan0)
    until("it works again", lambda: count(light, "reconnects") == 1)
    with client(vcan0) as mav:
        command(mav, ON_OFF, 0)
    assert not is_on(light)
    told = light.console()
    assert [told.count(words) for words in ("trying again", "works again")] == [1, 1]


def test_bus_off_of_the_controller_below(light: Light, vcan0: str) -> None:
    def state() -> str:
        return light.ask("can", r" +\S+, error counters .*").strip()

    with client(vcan0) as mav:
        command(mav, ON_OFF, 1)
        error_frame(vcan0, ERR_BUSOFF)
        until("bus-off", lambda: state().startswith("bus-off"))
        assert is_on(light)
        error_frame(vcan0, ERR_RESTARTED)
        command(mav, ON_OFF, 0)
    assert not is_on(light)
    assert state() == "error-active, error counters tx 0 rx 0, bus-offs 1"


def test_full_send_queue_loses_nothing_that_was_acknowledged(start_can: Start) -> None:
    with vxcan("vxcan0", "vxcan1") as (near, far), client(far) as mav:
        light = start_can("--can0", f"socketcan:{near}")
        # Two frames; an acknowledgement takes five.
        queue = HeldQueue(near, 2 * 16)
        for percent in range(10, 60, 10):
            refused = count(light, "tx_retries")
            mav.send_command_long(CONFIGURE, INTERNAL, percent, 0, 100)
            until("a full queue", lambda: count(light, "tx_retries") > refused)  # noqa: B023
            queue.release()
            command(mav, CONFIGURE, INTERNAL, percent, 0, 100)
            assert light.do("outputs")["brightness_ppm"] == percent * 10_000
            queue.hold()
        assert count(light, "errors") == 0


def test_killed_light_leaves_the_lamp_dark_and_the_next_one_the_bus(
    start_can: Start, gpio_sim: Callable[..., GpioSim], vcan0: str
) -> None:
    chip = gpio_sim("LAMP")
    lamp = ("--gpio", f"gpiochip:{chip.device},enable=LAMP", "--unsafe-simulated-sensor")
    options = ("--can0", f"socketcan:{vcan0}", *lamp)
    light = start_can(*options)
    with client(vcan0) as mav:
        command(mav, ON_OFF, 1)
        until("lit", lambda: chip.value("LAMP") == 1)
        light.signal(signal.SIGKILL)
        until("dark", lambda: chip.value("LAMP") == 0)
        with pytest.raises(SilentError):
            mav.command_long(ON_OFF, 1)
        mav.drain()
        again = start_can(*options)
        assert not is_on(again)
        command(mav, ON_OFF, 1)
        until("lit", lambda: chip.value("LAMP") == 1)
