# SPDX-License-Identifier: Apache-2.0
"""What IMC actuates, beside everything else: MAVLink, heat, the arbiter, power cuts, the shell."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from harness import CONSOLE, WIRES, Light, Shell, light_on
from imc_light import join
from pharos import Simulator
from pharos.imc import ImcPeer, message

ON, SCHEDULE_ON, SCHEDULE_OFF, SAVE = 1, 3, 4, 6
HOURS_US = 21_600_000_000

Boot = Callable[[], tuple[ImcPeer, Shell]]


@pytest.fixture
def boot(start: Callable[..., Simulator], tmp_path: Path) -> Boot:
    """Starts a light with an IMC peer and a shell, whose settings lie in one file."""

    def begin() -> tuple[ImcPeer, Shell]:
        sim = start(
            {"uart1": WIRES["tcp"]},
            options=(
                "--protocol", "imc", "--console", CONSOLE,
                "--settings", str(tmp_path / "settings"),
            ),
        )  # fmt: skip
        peer = join(sim, "uart1")
        return peer, Shell(sim)

    return begin


@pytest.fixture
def both(start: Callable[..., Simulator]) -> tuple[Light, ImcPeer]:
    """A light with a MAVLink client and an IMC peer."""
    sim = start({"uart0": WIRES["udp"], "uart1": WIRES["tcp"]}, options=("--protocol", "imc"))
    light = light_on(sim)
    return light, join(sim, "uart1")


def lamp(peer: ImcPeer, value: int) -> int:
    answer = peer.ask("SetLedBrightness", "LedBrightness", name="lamp", value=value)
    return int(answer["value"])


def lamp_now(peer: ImcPeer) -> int:
    return int(peer.ask("QueryLedBrightness", "LedBrightness", name="lamp")["value"])


def set_param(peer: ImcPeer, name: str, value: int) -> None:
    wanted = [message("EntityParameter", name=name, value=str(value))]
    peer.ask("SetEntityParameters", "EntityParameters", name="Lamp", params=wanted)


def control(peer: ImcPeer, name: str, op: int, sched_time: float = 0.0) -> None:
    peer.send("PowerChannelControl", name=name, op=op, sched_time=sched_time)
    peer.pass_time(0)


# --- MAVLink, heat, the arbiter -------------------------------------------------------------------


def test_brightness_is_the_same_over_mavlink(both: tuple[Light, ImcPeer]) -> None:
    light, peer = both
    assert lamp(peer, 51) == 51
    status = light.status()
    assert (status.enable, status.brightness) == (1, pytest.approx(20.0))
    light.configure(60.0)
    assert lamp_now(peer) == 153  # 0.6 * 255
    light.off()
    assert lamp_now(peer) == 0


def test_power_of_the_lamp_shows_over_mavlink(both: tuple[Light, ImcPeer]) -> None:
    light, peer = both
    light.on()
    control(peer, "lamp", 0)
    assert light.status().enable == 0
    assert light.level_ppm() == 0
    assert light.on() == 4  # FAILED: it has no power
    control(peer, "lamp", ON)
    assert light.status().enable == 0
    assert light.on() == 0
    assert light.level_ppm() > 0


def test_heat_wins(both: tuple[Light, ImcPeer]) -> None:
    light, peer = both
    assert lamp(peer, 255) == 255
    light.sim.set(temp_mdegc=120_000)
    light.sim.advance(s=3)
    assert light.level_ppm() == 0
    assert lamp_now(peer) == 0
    peer.send("SetLedBrightness", name="lamp", value=255)
    peer.send("SetPWM", id=0, period=1000, duty_cycle=1000)
    peer.send("RemoteActions", actions="Brightness=127")
    peer.pass_time(0)
    assert light.level_ppm() == 0


def test_the_arbiter_decides(both: tuple[Light, ImcPeer]) -> None:
    light, peer = both
    set_param(peer, "LGT_SRC_PRIO", 1)
    light.configure(40.0)
    light.on()
    assert lamp(peer, 255) == 102, "MAVLink outranks IMC: as it is"
    light.sim.advance(s=6)
    assert lamp(peer, 255) == 255
    set_param(peer, "LGT_SRC_EXCL", 4)
    light.sim.advance(s=6)
    assert lamp(peer, 1) == 255


def test_only_the_asker_is_answered(both: tuple[Light, ImcPeer]) -> None:
    light, peer = both
    sim = light.sim
    peer.send("QueryLedBrightness", name="lamp")
    mine = peer.pass_time(0)
    assert [p.dst for p in mine if p.name == "LedBrightness"] == [peer.id]
    sim.advance(s=1)
    for name in ("LedBrightness", "PWM", "PowerChannelState", "GpioState", "ButtonEvent"):
        peer.take()
        peer.send(name)
        assert [p.name for p in peer.pass_time(0)] == [], f"{name} is no request"


# --- time and power cuts --------------------------------------------------------------------------


def test_schedules_are_exact_after_six_hours(boot: Boot) -> None:
    peer, shell = boot()
    sim = shell.sim
    control(peer, "aux", SCHEDULE_ON, 21_600.0)
    control(peer, "aux", SCHEDULE_OFF, 21_600.25)
    assert "on in 21600 s, off in 21600.25 s" in shell("power status").replace("\n", " ")
    for wire in ("uart1", "console"):  # nobody has to read what the light says all the time
        sim.detach(wire)
    sim.advance(HOURS_US - 300_001)  # the shell took 300 ms
    assert sim.outputs()["lines"]["power_aux"] == 0
    sim.advance(1)
    assert sim.outputs()["lines"]["power_aux"] == 1
    sim.advance(249_999)
    assert sim.outputs()["lines"]["power_aux"] == 1
    sim.advance(1)
    assert sim.outputs()["lines"]["power_aux"] == 0


def _aux(shell: Shell) -> tuple[str, str]:
    found = re.search(r"^aux\s+(\w+), after a start (\w+)", shell("power status"), re.MULTILINE)
    assert found is not None
    return found[1], found[2]


def test_what_was_saved_is_on_after_a_reset_and_a_restart(boot: Boot) -> None:
    peer, shell = boot()
    control(peer, "aux", ON)
    assert _aux(shell) == ("on", "off")
    shell.sim.reset()
    assert _aux(shell) == ("off", "off"), "not saved"
    peer.send("Heartbeat")
    control(peer, "aux", ON)
    control(peer, "aux", SAVE)
    control(peer, "camera", 0)
    shell.sim.advance(s=2)
    shell.sim.reset()
    assert _aux(shell) == ("on", "on")
    assert shell.sim.outputs()["lines"]["power_camera"] == 1, "not saved"
    assert shell.sim.quit() == 0
    _, shell = boot()
    assert _aux(shell) == ("on", "on")
    assert shell.sim.outputs()["lines"]["power_aux"] == 1


@pytest.mark.parametrize("byte", [*range(40), 100])
def test_power_cut_at_any_byte_of_a_save_leaves_the_old_or_the_new(boot: Boot, byte: int) -> None:
    peer, shell = boot()
    sim = shell.sim
    control(peer, "aux", ON)
    sim.fault("storage", "torn", byte=byte)
    control(peer, "aux", SAVE)
    sim.advance(s=2)
    sim.request("reset", cause="brownout")
    now, after = _aux(shell)
    assert now == after
    lines = sim.outputs()["lines"]
    assert (lines["power_lamp"], lines["power_gimbal"], lines["power_camera"]) == (1, 1, 1)
    # The store works again, and a later save is kept.
    peer.send("Heartbeat")
    control(peer, "aux", ON)
    control(peer, "aux", SAVE)
    sim.advance(s=2)
    sim.reset()
    assert _aux(shell) == ("on", "on")


def test_reset_stops_motors_and_lets_go_of_lines(boot: Boot) -> None:
    peer, shell = boot()
    sim = shell.sim
    sim.advance(s=3)
    peer.send("SetThrusterActuation", id=0, value=1.0)
    peer.send("CameraZoom", id=0, action=1)
    peer.send("GpioStateSet", name="out0", value=1)
    peer.pass_time(100_000)
    assert sim.outputs()["pwm"][5]["pulse_ns"] == 2_000_000
    sim.reset()
    out = sim.outputs()
    assert out["pwm"][5]["pulse_ns"] == 1_500_000
    assert (out["lines"]["focus_in"], out["lines"]["out0"]) == (0, 0)


# --- shell and log --------------------------------------------------------------------------------


def test_shell_shows_and_switches_power(boot: Boot) -> None:
    peer, shell = boot()
    assert "ok" in shell("power on aux")
    assert shell.sim.outputs()["lines"]["power_aux"] == 1
    assert "no channel 'sun'" in shell("power off sun")
    assert "ok" in shell("power off lamp")
    assert lamp(peer, 255) == 0


def test_shell_shows_display_and_outputs(boot: Boot) -> None:
    peer, shell = boot()
    peer.send("LcdControl", op=4, text="second line")
    peer.send("LcdControl", op=1)
    peer.send("SetPWM", id=2, period=1000, duty_cycle=250)
    peer.pass_time(0)
    text = shell("display")
    assert "|                |" in text
    assert "|second line     |" in text
    outputs = shell("outputs")
    assert re.search(r"^aux1\s+250 of 1000 us", outputs, re.MULTILINE)
    assert re.search(r"^commands\s+3 done, 0 unknown", outputs, re.MULTILINE)


def test_what_is_refused_is_counted_and_logged(boot: Boot) -> None:
    peer, shell = boot()
    peer.send("SetLedBrightness", name="sun", value=1)
    text = shell.keys("\r")
    assert "SetLedBrightness 'sun': not on this board" in text
    shell.sim.advance(s=1)
    peer.send("SetServoPosition", id=0, value=9.0)
    assert "SetServoPosition 0: out of range" in shell.keys("\r")
    for _ in range(20):
        peer.send("SetPWM", id=99, period=1000, duty_cycle=1)
    assert shell.keys("\r").count("SetPWM") <= 1, "one line a second"
    assert "21 unknown, 1 out of range" in shell("outputs")


def test_parameters_of_the_thruster(boot: Boot) -> None:
    peer, shell = boot()
    sim = shell.sim
    shell("param set ESC_MIN 1100")
    shell("param set ESC_MAX 1900")
    sim.advance(s=3)
    assert sim.outputs()["pwm"][5]["pulse_ns"] == 1_500_000
    peer.send("SetThrusterActuation", id=0, value=1.0)
    peer.pass_time(0)
    assert sim.outputs()["pwm"][5]["pulse_ns"] == 1_900_000
