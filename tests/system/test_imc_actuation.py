# SPDX-License-Identifier: Apache-2.0
"""IMC's actuation group, each message over TCP, UDP and a pty, in both byte orders: what the board
does, and what is answered. Numbers are the wire's, from the IMC 5.4 specification."""

from __future__ import annotations

import math
from typing import Any

import pytest

from imc_light import ImcLight
from pharos import Simulator
from pharos.imc import ImcPeer, Packet, message

# PWM channels and probes of the native board (boards/native/native.dts).
AUX0, AUX1, THRUSTER, STATUS = 3, 4, 5, 6


def pwm(imc: ImcLight, channel: int) -> tuple[int, int]:
    """Period and pulse of a PWM channel [us]."""
    now = imc.sim.outputs()["pwm"][channel]
    return now["period_ns"] // 1000, now["pulse_ns"] // 1000


def line(sim: Simulator, name: str) -> int:
    return int(sim.outputs()["lines"][name])


def of(name: str, packets: list[Packet]) -> list[Packet]:
    return [packet for packet in packets if packet.name == name]


def tell(peer: ImcPeer, name: str, /, **fields: Any) -> list[Packet]:
    """Sends a message and lets the light see to it; what it sends at once."""
    peer.take()
    peer.send(name, **fields)
    return peer.pass_time(0)


def unanswered(peer: ImcPeer, name: str, /, **fields: Any) -> None:
    answers = [p.name for p in tell(peer, name, **fields) if p.name != "Heartbeat"]
    assert answers == []


# --- LedBrightness, QueryLedBrightness, SetLedBrightness ------------------------------------------


def test_lamp_is_an_led(imc: ImcLight) -> None:
    answer = imc.peer.ask("SetLedBrightness", "LedBrightness", name="lamp", value=128)
    assert (answer["name"], answer["value"]) == (b"lamp", 128)
    assert (answer.dst, answer.dst_ent) == (imc.peer.id, imc.peer.entity)
    out = imc.sim.outputs()
    assert (out["enable"], out["brightness_ppm"]) == (1, 501_961)  # 128 / 255
    assert imc.peer.ask("QueryLedBrightness", "LedBrightness", name="lamp")["value"] == 128
    assert imc.peer.ask("SetLedBrightness", "LedBrightness", name="lamp", value=0)["value"] == 0
    assert imc.sim.outputs()["level_ppm"] == 0


def test_indicator_leds(imc: ImcLight) -> None:
    answer = imc.peer.ask("SetLedBrightness", "LedBrightness", name="status", value=51)
    assert answer["value"] == 51
    assert pwm(imc, STATUS) == (1000, 200)  # 51 / 255 of 1 ms
    assert imc.peer.ask("QueryLedBrightness", "LedBrightness", name="signal")["value"] == 0
    unanswered(imc.peer, "QueryLedBrightness", name="no such LED")


# --- SetPWM, PWM ----------------------------------------------------------------------------------


def test_auxiliary_pwm(imc: ImcLight) -> None:
    answer = imc.peer.ask("SetPWM", "PWM", id=1, period=3003, duty_cycle=1001)
    assert (answer["id"], answer["period"], answer["duty_cycle"]) == (1, 3003, 1001)
    assert pwm(imc, AUX0) == (3003, 1001)
    unanswered(imc.peer, "SetPWM", id=1, period=1000, duty_cycle=1001)
    unanswered(imc.peer, "SetPWM", id=77, period=1000, duty_cycle=1)
    assert pwm(imc, AUX0) == (3003, 1001)


def test_pwm_of_the_lamp_strobes_it(imc: ImcLight) -> None:
    imc.peer.ask("SetLedBrightness", "LedBrightness", name="lamp", value=255)
    imc.peer.ask("SetPWM", "PWM", id=0, period=200_000, duty_cycle=20_000)
    imc.sim.advance(s=1)
    imc.sim.skip_edges()
    imc.sim.advance(s=1)
    edges = imc.sim.edges()
    assert len(edges) == 10
    lit = [b.time_us - a.time_us for a, b in zip(edges, edges[1:], strict=False) if a.level_ppm > 0]
    assert set(lit) == {20_000}
    imc.peer.ask("SetPWM", "PWM", id=0, period=1000, duty_cycle=250)
    out = imc.sim.outputs()
    assert (out["strobe_period_us"], out["brightness_ppm"]) == (0, 250_000)


# --- GpioState, GpioStateGet, GpioStateSet --------------------------------------------------------


def test_gpio_lines(imc: ImcLight) -> None:
    answer = imc.peer.ask("GpioStateSet", "GpioState", name="out1", value=1)
    assert (answer["name"], answer["value"]) == (b"out1", 1)
    assert line(imc.sim, "out1") == 1
    assert imc.peer.ask("GpioStateGet", "GpioState", name="in0")["value"] == 0
    imc.sim.gpio("in0", True)
    assert imc.peer.ask("GpioStateGet", "GpioState", name="in0")["value"] == 1
    assert imc.peer.ask("GpioStateSet", "GpioState", name="in0", value=0)["value"] == 1
    unanswered(imc.peer, "GpioStateSet", name="out1", value=2)
    unanswered(imc.peer, "GpioStateGet", name="")
    assert line(imc.sim, "out1") == 1


# --- PowerChannelControl, QueryPowerChannelState, PowerChannelState -------------------------------

OFF, ON, TOGGLE, SCHEDULE_ON, SCHEDULE_OFF, RESET, SAVE, RESTART = range(8)


def channels(peer: ImcPeer) -> dict[bytes, int]:
    told = of("PowerChannelState", tell(peer, "QueryPowerChannelState"))
    assert {packet.dst for packet in told} == {peer.id}
    return {packet["name"]: packet["state"] for packet in told}


def control(peer: ImcPeer, name: str, op: int, sched_time: float = 0.0) -> None:
    unanswered(peer, "PowerChannelControl", name=name, op=op, sched_time=sched_time)


def test_power_channels(imc: ImcLight) -> None:
    assert channels(imc.peer) == {b"lamp": 1, b"gimbal": 1, b"camera": 1, b"aux": 0}
    control(imc.peer, "aux", ON)
    control(imc.peer, "gimbal", OFF)
    control(imc.peer, "camera", TOGGLE)
    assert channels(imc.peer) == {b"lamp": 1, b"gimbal": 0, b"camera": 0, b"aux": 1}
    lines = imc.sim.outputs()["lines"]
    assert [lines[f"power_{n}"] for n in ("lamp", "gimbal", "camera", "aux")] == [1, 0, 0, 1]
    control(imc.peer, "camera", TOGGLE)
    control(imc.peer, "camera", RESTART)
    assert line(imc.sim, "power_camera") == 0
    imc.sim.advance(1_999_999)
    assert line(imc.sim, "power_camera") == 0
    imc.sim.advance(1)
    assert line(imc.sim, "power_camera") == 1


def test_schedules_are_exact(imc: ImcLight) -> None:
    control(imc.peer, "aux", SCHEDULE_ON, 90.0)
    control(imc.peer, "aux", SCHEDULE_OFF, 90.5)
    control(imc.peer, "camera", SCHEDULE_OFF, 1.0)
    control(imc.peer, "camera", RESET)
    imc.sim.advance(89_999_999)
    assert line(imc.sim, "power_aux") == 0
    imc.sim.advance(1)
    assert line(imc.sim, "power_aux") == 1
    imc.sim.advance(499_999)
    assert line(imc.sim, "power_aux") == 1
    imc.sim.advance(1)
    assert line(imc.sim, "power_aux") == 0
    assert line(imc.sim, "power_camera") == 1


@pytest.mark.parametrize("delay", [math.nan, -1.0, math.inf, 1.8e9, 31_536_001.0])
def test_schedules_that_are_none_are_refused(imc: ImcLight, delay: float) -> None:
    control(imc.peer, "camera", SCHEDULE_OFF, delay)
    imc.sim.advance(s=5)
    assert line(imc.sim, "power_camera") == 1


# --- PowerOperation -------------------------------------------------------------------------------

DOWN, DOWN_IP, ABORTED, SCHED_DOWN, UP, UP_IP, SCHED_UP = range(7)


def operate(peer: ImcPeer, op: int, **fields: Any) -> list[tuple[int, float]]:
    return notices(tell(peer, "PowerOperation", op=op, **fields))


def notices(packets: list[Packet]) -> list[tuple[int, float]]:
    told = of("PowerOperation", packets)
    assert {packet.dst for packet in told} <= {0xFFFF}
    return [(packet["op"], packet["time_remain"]) for packet in told]


def test_power_down_is_announced_and_comes_up_again(imc: ImcLight) -> None:
    imc.peer.ask("SetLedBrightness", "LedBrightness", name="lamp", value=255)
    imc.peer.ask("SetLedBrightness", "LedBrightness", name="status", value=255)
    assert operate(imc.peer, DOWN, time_remain=3.0) == [(DOWN_IP, 3.0)]
    assert notices(imc.peer.pass_time(2_999_999)) == [(DOWN_IP, 2.0), (DOWN_IP, 1.0)]
    assert imc.sim.outputs()["level_ppm"] > 0
    assert notices(imc.peer.pass_time(1)) == [(DOWN_IP, 0.0)]
    assert imc.sim.outputs()["level_ppm"] == 0
    assert set(channels(imc.peer).values()) == {0}
    assert pwm(imc, STATUS)[1] == 0
    unanswered(imc.peer, "SetPWM", id=1, period=100, duty_cycle=1)
    assert operate(imc.peer, UP) == [(UP_IP, 0.0)]
    assert channels(imc.peer) == {b"lamp": 1, b"gimbal": 1, b"camera": 1, b"aux": 0}
    assert pwm(imc, STATUS)[1] == 1000
    assert imc.sim.outputs()["level_ppm"] == 0, "the lamp is dark until commanded"
    answer = imc.peer.ask("SetLedBrightness", "LedBrightness", name="lamp", value=255)
    assert answer["value"] == 255


def test_power_down_is_aborted(imc: ImcLight) -> None:
    assert operate(imc.peer, DOWN, dst_ent=0) == [(DOWN_IP, 10.0)]  # DOWN_TIME
    assert operate(imc.peer, ABORTED) == [(ABORTED, 0.0)]
    assert notices(imc.peer.pass_time(20_000_000)) == []
    assert channels(imc.peer)[b"lamp"] == 1


def test_scheduled_down_and_up(imc: ImcLight) -> None:
    assert operate(imc.peer, SCHED_DOWN, sched_time=5.0) == []
    assert operate(imc.peer, SCHED_UP, sched_time=20.0) == []
    imc.sim.advance(14_999_999)
    assert line(imc.sim, "power_camera") == 1
    imc.sim.advance(1)
    assert line(imc.sim, "power_camera") == 0
    imc.sim.advance(4_999_999)
    assert line(imc.sim, "power_camera") == 0
    imc.sim.advance(1)
    assert line(imc.sim, "power_camera") == 1


@pytest.mark.parametrize(
    "fields",
    [
        {"op": DOWN, "time_remain": math.nan},
        {"op": DOWN, "time_remain": -1.0},
        {"op": SCHED_DOWN, "sched_time": math.nan},
        {"op": SCHED_DOWN, "sched_time": 1.8e9},
        {"op": 99},
        {"op": DOWN, "dst_ent": 1},  # the lamp alone has no power-down
    ],
)
def test_power_operations_that_are_none(imc: ImcLight, fields: dict[str, Any]) -> None:
    unanswered(imc.peer, "PowerOperation", **fields)
    assert notices(imc.peer.pass_time(15_000_000)) == []
    assert line(imc.sim, "power_camera") == 1


# --- what IMC has no answer to --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("CameraZoom", {"id": 0, "action": 1}),
        ("SetThrusterActuation", {"id": 0, "value": 0.5}),
        ("SetServoPosition", {"id": 0, "value": 0.5}),
        ("SetControlSurfaceDeflection", {"id": 0, "angle": 0.5}),
        ("RemoteActions", {"actions": "Light=1"}),
        ("LcdControl", {"op": 3, "text": "Depth"}),
        ("PowerChannelControl", {"name": "aux", "op": 1}),
    ],
)
def test_seven_messages_have_no_answer(imc: ImcLight, name: str, fields: dict[str, Any]) -> None:
    """Not one packet, at once or later, but what comes once a second anyhow."""
    imc.peer.pass_time(2_000_000)
    usual = {(p.name, p.dst) for p in imc.peer.pass_time(12_000_000)}  # with an announcement
    assert usual
    imc.peer.take()
    imc.peer.send(name, **fields)
    assert {(p.name, p.dst) for p in imc.peer.pass_time(5_000_000)} <= usual


# --- SetServoPosition, SetControlSurfaceDeflection ------------------------------------------------


def test_servos_turn_the_gimbal(imc: ImcLight) -> None:
    unanswered(imc.peer, "SetServoPosition", id=0, value=math.radians(30))
    unanswered(imc.peer, "SetControlSurfaceDeflection", id=1, angle=math.radians(-20))
    imc.sim.advance(s=5)
    servos = imc.sim.outputs()["servos"]
    assert servos["pan"]["angle_mdeg"] == pytest.approx(30_000, abs=100)
    assert servos["tilt"]["angle_mdeg"] == pytest.approx(-20_000, abs=100)
    for angle in (math.nan, 1.6, -1.6, math.inf):
        unanswered(imc.peer, "SetServoPosition", id=0, value=angle)
    imc.sim.advance(s=5)
    assert imc.sim.outputs()["servos"] == servos


def test_servos_on_auxiliary_outputs(imc: ImcLight) -> None:
    unanswered(imc.peer, "SetServoPosition", id=2, value=math.pi / 4)
    assert pwm(imc, AUX0) == (20_000, 1750)
    unanswered(imc.peer, "SetControlSurfaceDeflection", id=3, angle=-math.pi / 2)
    assert pwm(imc, AUX1) == (20_000, 1000)


# --- SetThrusterActuation -------------------------------------------------------------------------


def test_thruster(imc: ImcLight) -> None:
    unanswered(imc.peer, "SetThrusterActuation", id=0, value=1.0)
    assert pwm(imc, THRUSTER) == (20_000, 1500), "its controller is not armed yet"
    imc.sim.advance(s=2)
    unanswered(imc.peer, "SetThrusterActuation", id=0, value=-0.5)
    assert pwm(imc, THRUSTER) == (20_000, 1250)
    for value in (math.nan, 1.5, -1.01):
        unanswered(imc.peer, "SetThrusterActuation", id=0, value=value)
    imc.sim.advance(999_999)
    assert pwm(imc, THRUSTER) == (20_000, 1250)
    imc.sim.advance(1)
    assert pwm(imc, THRUSTER) == (20_000, 1500), "nobody has said more for a second"


# --- CameraZoom -----------------------------------------------------------------------------------


def test_zoom_of_the_beam(imc: ImcLight) -> None:
    reset, zoom_in, zoom_out, stop = range(4)
    unanswered(imc.peer, "CameraZoom", id=0, action=zoom_in)
    imc.sim.advance(s=3)
    unanswered(imc.peer, "CameraZoom", id=0, action=stop)
    assert imc.sim.outputs()["focus_ppm"] == 750_000  # 3 of 4 s
    unanswered(imc.peer, "CameraZoom", id=0, action=zoom_out)
    imc.sim.advance(s=1)
    unanswered(imc.peer, "CameraZoom", id=0, action=zoom_in, zoom=204)
    imc.sim.advance(s=5)
    assert imc.sim.outputs()["focus_ppm"] == 800_000  # 204 / 255
    unanswered(imc.peer, "CameraZoom", id=0, action=9)
    unanswered(imc.peer, "CameraZoom", id=1, action=zoom_out)
    unanswered(imc.peer, "CameraZoom", id=0, action=reset)
    imc.sim.advance(s=5)
    assert imc.sim.outputs()["focus_ppm"] == 0


# --- LcdControl -----------------------------------------------------------------------------------


def test_display(imc: ImcLight) -> None:
    off, on, clear, write0, write1 = range(5)
    unanswered(imc.peer, "LcdControl", op=write0, text="Depth 12.5 m")
    unanswered(imc.peer, "LcdControl", op=write1, text="longer than a line")
    unanswered(imc.peer, "LcdControl", op=on)
    lcd = imc.sim.outputs()["lcd"]
    assert lcd == {"on": True, "lines": ["Depth 12.5 m    ", "longer than a li"]}
    unanswered(imc.peer, "LcdControl", op=off)
    assert imc.sim.outputs()["lcd"] == lcd | {"on": False}
    unanswered(imc.peer, "LcdControl", op=clear)
    assert imc.sim.outputs()["lcd"]["lines"] == [" " * 16, " " * 16]


# --- RemoteActionsRequest, RemoteActions ----------------------------------------------------------


def remote(peer: ImcPeer, actions: str) -> None:
    unanswered(peer, "RemoteActions", actions=actions)


def test_remote_actions_are_reported(imc: ImcLight) -> None:
    report = imc.peer.ask("RemoteActionsRequest", "RemoteActionsRequest", op=1)
    assert report["op"] == 0
    pairs = dict(pair.split(b"=") for pair in report["actions"].split(b";"))
    assert pairs == {
        b"Light": b"Button", b"Strobe": b"Button", b"Brightness": b"Slider",
        b"Pan": b"Axis", b"Tilt": b"Axis", b"Ranges": b"Range127",
    }  # fmt: skip


def test_remote_drives_the_lamp_and_the_gimbal(imc: ImcLight) -> None:
    remote(imc.peer, "Light=1;Brightness=127")
    assert imc.sim.outputs()["enable"] == 1
    remote(imc.peer, "Brightness=64")
    out = imc.sim.outputs()
    assert (out["enable"], out["brightness_ppm"]) == (1, 503_937)  # 64 / 127
    remote(imc.peer, "Strobe=1;Light=1")
    out = imc.sim.outputs()
    assert (out["enable"], out["strobe_period_us"]) == (0, 500_000)
    remote(imc.peer, "Pan=127")
    imc.sim.advance(500_000)
    remote(imc.peer, "Pan=127")
    imc.sim.advance(s=4)
    stopped = imc.sim.outputs()["servos"]["pan"]["angle_mdeg"]
    assert stopped > 1000
    imc.sim.advance(s=4)
    assert imc.sim.outputs()["servos"]["pan"]["angle_mdeg"] == stopped
    assert imc.sim.outputs()["brightness_ppm"] == 503_937, "silence leaves the lamp"


def test_remote_stops_a_second_after_the_last_update(imc: ImcLight) -> None:
    rate = 30.0
    imc.peer.ask(
        "SetEntityParameters", "EntityParameters", name="Gimbal",
        params=[message("EntityParameter", name="GMB_PAN_RATE", value=str(rate))],
    )  # fmt: skip
    remote(imc.peer, "Pan=0.5;Ranges=Decimal")
    imc.sim.advance(s=8)
    # half of the fastest rate for the second that an update holds, to a frame of 20 ms
    angle = imc.sim.outputs()["servos"]["pan"]["angle_mdeg"] / 1000
    assert angle == pytest.approx(rate / 2, abs=rate * 0.04)


# --- ButtonEvent ----------------------------------------------------------------------------------


def test_button_is_told(imc: ImcLight) -> None:
    imc.sim.gpio("button", False)  # pressed is low
    pressed = of("ButtonEvent", imc.peer.pass_time(100_000))
    assert [(p["button"], p["value"], p.dst) for p in pressed] == [(0, 1, 0xFFFF)]
    imc.sim.gpio("button", True)
    released = of("ButtonEvent", imc.peer.pass_time(100_000))
    assert [(p["button"], p["value"]) for p in released] == [(0, 0)]
    assert imc.sim.outputs()["enable"] == 1, "a press still switches the light"
