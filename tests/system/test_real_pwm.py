# SPDX-License-Identifier: Apache-2.0
"""--light pwm:… and its kin, and a real lamp without a real sensor. The PWM chips are plain files
here."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from fake_sysfs import FakeSysfs
from harness import (
    ACCEPTED,
    BINARY,
    CONSOLE,
    FAILED,
    FULL_PPM,
    STATE_CRITICAL,
    WIRES,
    Light,
    Shell,
    from_light,
    light_on,
    of,
    texts,
)
from pharos import Simulator

Start = Callable[..., Simulator]
UNSAFE = "--unsafe-simulated-sensor"
SENSOR = ("--thermistor", "hwmon:lm75/temp1")


@pytest.fixture
def sysfs(tmp_path: Path) -> FakeSysfs:
    made = FakeSysfs(tmp_path)
    made.hwmon(0, "lm75", temp1_input=25000)
    return made


@pytest.fixture
def channels(sysfs: FakeSysfs) -> list[Path]:
    return sysfs.pwmchip(0, device="0-0040", channels=8)


def begin(start: Start, sysfs: FakeSysfs, *options: str) -> Light:
    sim = start(
        {"uart0": WIRES["udp"], "console": CONSOLE},
        options=("--sysfs", str(sysfs.root), *options),
    )
    return light_on(sim)


def duty(channel: Path) -> int:
    return int(FakeSysfs.get(channel, "duty_cycle"))


# --- outputs ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "chip", ["0", "pwmchip0", "0-0040", "{sysfs}/class/pwm/pwmchip0", "{sysfs}/devices/0-0040"]
)
def test_brightness_is_the_share_of_the_period(
    start: Start, sysfs: FakeSysfs, channels: list[Path], chip: str
) -> None:
    sysfs.pwmchip(1, device="0-0041")
    where = chip.replace("{sysfs}", str(sysfs.root))
    light = begin(start, sysfs, "--light", f"pwm:{where}/3,period=1ms", *SENSOR)
    lamp = channels[3]
    assert (FakeSysfs.get(lamp, "period"), FakeSysfs.get(lamp, "enable")) == ("1000000", "1")
    assert duty(lamp) == 0
    assert light.on() == ACCEPTED
    assert duty(lamp) == 1_000_000
    shell = Shell(light.sim)
    shell("light set brightness 40")
    assert duty(lamp) == light.level_ppm() > 0
    assert light.off() == ACCEPTED
    assert duty(lamp) == 0


def test_period_is_500_us_unless_told_and_polarity_normal(
    start: Start, sysfs: FakeSysfs, channels: list[Path]
) -> None:
    sysfs.set(channels[0], "polarity", "inversed")
    light = begin(start, sysfs, "--light", "pwm:0/0", *SENSOR)
    assert FakeSysfs.get(channels[0], "period") == "500000"
    assert FakeSysfs.get(channels[0], "polarity") == "normal"
    assert light.on() == ACCEPTED
    assert duty(channels[0]) == 500_000
    reply = light.sim.request("pwm")["outputs"]
    assert reply == {
        "light": {
            "path": str(channels[0]), "present": True, "period_ns": 500_000, "pulse_ns": 500_000,
            "skipped": 0, "losses": 0,
        }
    }  # fmt: skip


def test_inverted_is_the_chips_polarity(
    start: Start, sysfs: FakeSysfs, channels: list[Path]
) -> None:
    begin(start, sysfs, "--light", "pwm:0/0,inverted", *SENSOR)
    assert FakeSysfs.get(channels[0], "polarity") == "inversed"
    assert duty(channels[0]) == 0


def test_inverted_output_stays_on_without_a_pulse_at_the_end(
    sysfs: FakeSysfs, channels: list[Path]
) -> None:
    """Off, it is low on many a chip: fully lit."""
    options = ("--light", "pwm:0/0,inverted", *SENSOR)
    assert run(sysfs, *options, "--time", "virtual", "--until", "1s").returncode == 0
    assert (duty(channels[0]), FakeSysfs.get(channels[0], "enable")) == (0, "1")
    sysfs.set(channels[0], "duty_cycle", 250_000)
    assert run(sysfs, *options, "--off").returncode == 0
    assert (duty(channels[0]), FakeSysfs.get(channels[0], "enable")) == (0, "1")


def test_each_strobe_edge_is_a_change_of_the_duty(
    start: Start, sysfs: FakeSysfs, channels: list[Path]
) -> None:
    light = begin(start, sysfs, "--light", "pwm:0/0", *SENSOR)
    shell = Shell(light.sim)
    shell("light set period 0.1")
    shell("light set duty 50")
    assert light.on() == ACCEPTED
    seen = []
    for _ in range(8):
        seen.append(duty(channels[0]))
        assert (seen[-1] > 0) == (light.level_ppm() > 0)
        light.sim.advance(50_000)
    assert set(seen) == {0, 500_000}
    assert light.sim.request("pwm")["outputs"]["light"]["skipped"] == 0


def test_servos_and_auxiliary_outputs_keep_the_length_of_their_pulses(
    start: Start, sysfs: FakeSysfs, channels: list[Path]
) -> None:
    places = {"servo-pan": "1", "servo-tilt": "2,period=10ms"}
    options = [word for use, at in places.items() for word in (f"--{use}", f"pwm:0/{at}")]
    light = begin(start, sysfs, *options)
    light.sim.advance(s=1)
    servos = light.sim.outputs()["servos"]
    assert duty(channels[1]) == servos["pan"]["pulse_ns"]
    assert duty(channels[2]) == servos["tilt"]["pulse_ns"]
    Shell(light.sim)("gimbal pan 45")
    light.sim.advance(s=3)
    moved = light.sim.outputs()["servos"]["pan"]["pulse_ns"]
    assert duty(channels[1]) == moved != servos["pan"]["pulse_ns"]
    # servos are no lamp
    assert light.sim.request("hardware")["lamp"] == "simulated"
    assert light.on() == ACCEPTED


def test_output_is_dark_at_a_reset(start: Start, sysfs: FakeSysfs, channels: list[Path]) -> None:
    light = begin(start, sysfs, "--light", "pwm:0/0", *SENSOR)
    assert light.on() == ACCEPTED
    light.sim.reset()
    assert (duty(channels[0]), FakeSysfs.get(channels[0], "enable")) == (0, "1")
    light.sim.advance(s=1)
    assert light.on() == ACCEPTED
    assert duty(channels[0]) == 500_000


def test_output_is_switched_off_at_the_end(sysfs: FakeSysfs, channels: list[Path]) -> None:
    options = ("--light", "pwm:0/0", "--aux0", "pwm:0/1", *SENSOR)
    assert run(sysfs, *options, "--time", "virtual", "--until", "1s").returncode == 0
    for channel, period in ((channels[0], "500000"), (channels[1], "20000000")):
        assert FakeSysfs.get(channel, "period") == period
        assert (duty(channel), FakeSysfs.get(channel, "enable")) == (0, "0")
    assert FakeSysfs.get(channels[2], "period") == "0", "not ours"


# --- --off ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bad", "line"),
    [
        (("--gpio", "gpiochip:/dev/no-chip,enable=0"),
         "--gpio: /dev/no-chip: No such file or directory"),
        (("--servo-pan", "pwm:9/0"), "--servo-pan: no PWM chip is called 9; there are: 0-0040"),
    ],
)  # fmt: skip
def test_off_goes_on_after_an_output_that_fails(
    sysfs: FakeSysfs, channels: list[Path], bad: tuple[str, str], line: str
) -> None:
    for channel in channels[:2]:
        sysfs.set(channel, "duty_cycle", 100_000)
        sysfs.set(channel, "enable", 1)
    done = run(sysfs, *bad, "--light", "pwm:0/0", "--aux0", "pwm:0/1", "--off")
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"pharos: {line}\n")
    for channel in channels[:2]:
        assert (duty(channel), FakeSysfs.get(channel, "enable")) == (0, "0")


def test_off_goes_on_after_a_lamp_that_fails(sysfs: FakeSysfs, channels: list[Path]) -> None:
    sysfs.set(channels[1], "duty_cycle", 100_000)
    done = run(sysfs, "--light", "pwm:9/0", "--aux0", "pwm:0/1", "--off")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert duty(channels[1]) == 0


def test_off_leaves_a_trace_as_it_is(
    sysfs: FakeSysfs, channels: list[Path], tmp_path: Path
) -> None:
    sysfs.set(channels[0], "duty_cycle", 100_000)
    trace = tmp_path / "trace"
    trace.write_text("of the light that was killed\n")
    done = run(sysfs, "--light", "pwm:0/0", "--trace", str(trace), "--off")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert duty(channels[0]) == 0
    assert trace.read_text() == "of the light that was killed\n"


# --- a chip that goes ---------------------------------------------------------------------------


def test_chip_that_is_gone_at_a_reset_leaves_the_lamp_dark_and_told(
    start: Start, sysfs: FakeSysfs, channels: list[Path]
) -> None:
    light = begin(start, sysfs, "--light", "pwm:0/0", *SENSOR)
    shutil.rmtree(channels[0].parent)
    light.sim.reset()
    light.sim.advance(s=35)
    light.mav.drain()
    assert light.on() == FAILED
    assert light.level_ppm() == 0
    assert "Start failed: light, error -19" in texts(list(light.mav.history))
    assert light.sim.request("pwm")["outputs"]["light"]["present"] is False


# --- a real lamp without a real sensor ----------------------------------------------------------


def test_real_lamp_with_a_simulated_sensor_stays_dark_and_says_why(
    start: Start, sysfs: FakeSysfs, channels: list[Path]
) -> None:
    light = begin(start, sysfs, "--light", "pwm:0/0")
    light.sim.advance(s=35)
    light.mav.drain()
    assert light.on() == FAILED
    told = texts(list(light.mav.history))
    assert "Start failed: light, error -19" in told
    assert "Start failed: sensor, error -19" in told
    heartbeat = of("HEARTBEAT", from_light(light.collect(2)))[-1]
    assert heartbeat.system_status == STATE_CRITICAL
    shell = Shell(light.sim)
    assert "not started (see: startup)" in shell("light on")
    # not even what a failed sensor allows
    shell("param set THR_FIRST 0.1")
    light.sim.reset()
    light.sim.advance(s=5)
    assert light.on() == FAILED
    outputs = light.sim.outputs()
    assert (outputs["peak_ppm"], outputs["edges"], outputs["limit_ppm"]) == (0, 0, 0)
    assert duty(channels[0]) == 0
    reply = light.sim.request("hardware")
    assert (reply["lamp"], reply["sensor"]) == ("--light", "simulated")
    assert (reply["allows_light"], reply["unprotected"]) == (False, False)


def test_unsafe_lamp_is_lit_and_every_status_says_so(
    start: Start, sysfs: FakeSysfs, channels: list[Path]
) -> None:
    light = begin(start, sysfs, "--light", "pwm:0/0", UNSAFE)
    assert light.on() == ACCEPTED
    assert light.level_ppm() == FULL_PPM
    assert duty(channels[0]) == 500_000
    warning = "Simulated sensor: lamp unprotected from heat"
    # the first is sent at start, when nobody listens yet
    light.sim.advance(s=61)
    light.mav.drain()
    assert texts(list(light.mav.history)).count(warning) == 2
    assert "SIMULATED: nothing protects the lamp from heat" in Shell(light.sim)("light status")
    assert light.sim.outputs()["unprotected"] is True


@pytest.mark.parametrize("options", [("--light", "pwm:0/0", *SENSOR, UNSAFE), (UNSAFE,)])
def test_protected_or_simulated_lamp_is_not_called_unsafe(
    start: Start, sysfs: FakeSysfs, channels: list[Path], options: tuple[str, ...]
) -> None:
    assert channels
    light = begin(start, sysfs, *options)
    assert light.on() == ACCEPTED
    assert "SIMULATED" not in Shell(light.sim)("light status")
    assert light.sim.outputs()["unprotected"] is False
    light.sim.advance(s=31)
    light.mav.drain()
    assert not [text for text in texts(list(light.mav.history)) if "unprotected" in text]


def test_refused_lamp_is_one_line_that_says_what_to_give(
    sysfs: FakeSysfs, channels: list[Path]
) -> None:
    assert channels
    done = run(sysfs, "--light", "pwm:0/0", "--time", "virtual", "--until", "1s")
    lines = [line for line in done.stderr.split("\n") if "dark" in line]
    assert lines == [
        "pharos: the lamp stays dark: it is real (--light) and its temperature sensor is not; give "
        "--thermistor hwmon:NAME/temp1, thermal:TYPE or iio:NAME/in_voltage0 (or "
        "--unsafe-simulated-sensor)"
    ]
    assert done.returncode == 0


# --- at start -----------------------------------------------------------------------------------


def run(sysfs: FakeSysfs, *options: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [BINARY, "--console", "none", "--can0", "none", "--sysfs", str(sysfs.root), *options],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip


def refusal(sysfs: FakeSysfs, *options: str) -> str:
    done = run(sysfs, *options, "--time", "virtual", "--until", "1s")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    return done.stderr.strip().removeprefix("pharos: ")


def test_absent_and_ambiguous_chips_are_one_line(sysfs: FakeSysfs) -> None:
    assert refusal(sysfs, "--light", "pwm:0/0") == (
        "--light: no PWM chip is called 0; there is none"
    )
    sysfs.pwmchip(0, device="fe20c000.pwm")
    sysfs.pwmchip(2, device="fe20c000.pwm")
    sysfs.pwmchip(3, device="1-0040")
    assert refusal(sysfs, "--light", "pwm:1-0041/0") == (
        "--light: no PWM chip is called 1-0041; there are: fe20c000.pwm, fe20c000.pwm, 1-0040"
    )
    assert refusal(sysfs, "--aux0", "pwm:fe20c000.pwm/0") == (
        "--aux0: 2 PWM chips are called fe20c000.pwm; name one: "
        "fe20c000.pwm@pwmchip0, fe20c000.pwm@pwmchip2"
    )
    assert refusal(sysfs, "--light", "pwm:1-0040/4") == "--light: 1-0040 has channels 0 to 3"


def test_two_uses_of_one_channel_are_one_line(sysfs: FakeSysfs, channels: list[Path]) -> None:
    assert refusal(sysfs, "--light", "pwm:0/1", *SENSOR, "--aux1", "pwm:0-0040/1") == (
        f"--aux1: {channels[1]}: --light has it"
    )


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("gpio", '"gpio" is neither sim nor pwm:CHIP/CHANNEL'),
        ("pwm:0", '"pwm:0" is not as pwm:CHIP/CHANNEL, such as pwm:0/1'),
        ("pwm:/1", '"pwm:/1" is not as pwm:CHIP/CHANNEL, such as pwm:0/1'),
        ("pwm:0/x", '"pwm:0/x" is not as pwm:CHIP/CHANNEL, such as pwm:0/1'),
        ("pwm:0/1,fast", '"fast" is neither period=TIME nor inverted'),
        ("pwm:0/1,period=5", 'period: "5" is not a duration such as 500ms, 2s, 10min or 24h'),
        ("pwm:0/1,period=2s", "period: 2s is not from 1us to 100ms"),
    ],
)
def test_wrong_words_are_one_line(sysfs: FakeSysfs, value: str, line: str) -> None:
    assert refusal(sysfs, "--light", value) == f"--light: {line}"


@pytest.mark.parametrize("use", ["servo-pan", "aux0", "thruster"])
def test_period_is_longer_than_a_pulse(sysfs: FakeSysfs, channels: list[Path], use: str) -> None:
    assert refusal(sysfs, f"--{use}", "pwm:0/1,period=2999us") == (
        f"--{use}: period: 2999us is not from 3ms, for pulses, to 100ms"
    )
    for good in (f"--{use}", "pwm:0/1,period=3ms"), ("--led-status", "pwm:0/1,period=2999us"):
        assert run(sysfs, *good, "--time", "virtual", "--until", "1s").returncode == 0
    assert FakeSysfs.get(channels[1], "period") == "2999000"


def test_real_lamp_on_a_line_takes_no_sensor_of_plain_files(sysfs: FakeSysfs) -> None:
    lamp = ("--gpio", "gpiochip:/dev/no-chip,enable=0", *SENSOR)
    done = run(sysfs, *lamp)
    assert (done.returncode, done.stderr) == (
        2, "pharos: --gpio: a real lamp does not go with --sysfs: its files are no sensor\n"
    )  # fmt: skip
    done = run(sysfs, "--gpio", "gpiochip:/dev/no-chip,sync=0", *SENSOR)
    assert done.stderr == "pharos: --gpio: /dev/no-chip: No such file or directory\n"


@pytest.mark.parametrize("root", ["/sys", "/sys/", "/sys/class/.."])
def test_real_output_needs_real_time(root: str) -> None:
    done = subprocess.run(
        [BINARY, "--time", "virtual", "--console", "none", "--sysfs", root, "--light", "pwm:0/0"],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == "pharos: --light: a real output needs --time real\n"
