# SPDX-License-Identifier: Apache-2.0
"""--light pwm:… and its kin on a real kernel's PWM: a PCA9685, whose registers are read behind the
kernel's back."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from guest_gpio import GpioSim
from guest_i2c import Lm75, Pca9685
from guest_light import PATIENCE_S, Light, Start, pass_time, until

SENSOR = ("--thermistor", "hwmon:lm75/temp1")
# The chip does 24 to 1526 Hz.
LAMP = 3
# How often the light is killed at any instant; a long run has 1000.
KILLS = int(os.environ.get("PHAROS_KILLS", "30"))
# So soon a killed light's lamp is dark; the middle one's, since an observer may come late.
DARK_MS = 100.0


@pytest.fixture
def chip() -> Iterator[Pca9685]:
    made = Pca9685()
    yield made
    made.remove()


@pytest.fixture
def options(chip: Pca9685, lm75: Lm75) -> tuple[str, ...]:
    assert lm75
    return "--light", f"pwm:{chip.device}/{LAMP},period=1ms", *SENSOR


def light_up(light: Light, chip: Pca9685) -> None:
    light.shell("light on")
    # perhaps not at 100 %: on a busy host samples come late
    until("lit", lambda: chip.duty(LAMP) > 0.0)


# --- running ------------------------------------------------------------------------------------


def test_brightness_is_in_the_chips_registers(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light = start_can(*options)
    assert chip.duty(LAMP) == 0.0
    # 25 MHz / 4096 / (5 + 1): 1017 Hz
    assert chip.prescale() == 5
    light_up(light, chip)
    for percent in (75, 50, 25):
        light.shell(f"light set brightness {percent}")
        until("dimmed", lambda: light.do("outputs")["level_ppm"] < 1e6 * percent / 100)  # noqa: B023
        level = light.do("outputs")["level_ppm"] / 1e6
        until("written", lambda: abs(chip.duty(LAMP) - level) < 2 / 4096)  # noqa: B023
        assert chip.duty(LAMP) > 0.0
    light.shell("light off")
    until("dark", lambda: chip.duty(LAMP) == 0.0)
    others = [chip.duty(channel) for channel in range(16) if channel != LAMP]
    assert others == [0.0] * 15


def test_heat_throttles_the_chips_duty(
    start_can: Start, chip: Pca9685, lm75: Lm75, options: tuple[str, ...]
) -> None:
    lm75.celsius(90)
    light = start_can(*options)
    light.shell("light on")
    # half way from 80 to 100 degC, half way from 100 % to 20 %
    until("throttled", lambda: abs(chip.duty(LAMP) - 0.6) < 2 / 4096)
    assert light.do("outputs")["limit_ppm"] == 600_000


def test_strobe_edges_are_in_the_registers(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light = start_can(*options)
    light.shell("light set period 0.5", "light set duty 50", "light on")
    for _ in range(3):
        until("lit", lambda: chip.duty(LAMP) > 0.0)
        until("dark", lambda: chip.duty(LAMP) == 0.0)


def test_servo_and_auxiliary_output(start_can: Start, chip: Pca9685) -> None:
    places = {"servo-pan": 0, "aux1": 7}
    words = [word for use, at in places.items() for word in (f"--{use}", f"pwm:0/{at}")]
    light = start_can(*words)
    # 1.5 ms of 20 ms
    until("centred", lambda: abs(chip.duty(0) - 0.075) < 2 / 4096)
    light.shell("gimbal pan 45")
    until("turned", lambda: abs(chip.duty(0) - 0.075) > 0.005)
    assert set(light.do("pwm")["outputs"]) == set(places)


def test_lamp_on_an_enable_line_and_a_pwm(
    start_can: Start, chip: Pca9685, gpio_sim: Callable[..., GpioSim], options: tuple[str, ...]
) -> None:
    lines = gpio_sim("LAMP")
    light = start_can(*options, "--gpio", f"gpiochip:{lines.device},enable=LAMP")
    light_up(light, chip)
    until("enabled", lambda: lines.value("LAMP") == 1)
    until("one guard", lambda: len(light.guards()) == 1)
    assert light.signal(signal.SIGKILL) == -signal.SIGKILL
    until("both off", lambda: (lines.value("LAMP"), chip.duty(LAMP)) == (0, 0.0))


def test_enable_line_goes_low_though_the_pwms_bus_hangs(
    start_can: Start,
    chip: Pca9685,
    gpio_sim: Callable[..., GpioSim],
    options: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hangs = tmp_path / "hangs"
    monkeypatch.setenv("LD_PRELOAD", os.environ["PHAROS_BUILD"] + "/tests/native/libslow_bus.so")
    monkeypatch.setenv("SLOW_BUS", str(hangs))
    monkeypatch.setenv("ASAN_OPTIONS", "verify_asan_link_order=0")
    lines = gpio_sim("LAMP")
    light = start_can(*options, "--gpio", f"gpiochip:{lines.device},enable=LAMP")
    light_up(light, chip)
    until("enabled", lambda: lines.value("LAMP") == 1)
    until("a guard", light.guard)
    hangs.touch()
    light.signal(signal.SIGKILL)
    until("disabled", lambda: lines.value("LAMP") == 0)
    assert chip.duty(LAMP) > 0.0, "it hangs"
    hangs.unlink()
    until("both off", lambda: chip.duty(LAMP) == 0.0)


# --- the end ------------------------------------------------------------------------------------


def test_channel_is_the_lights_and_given_back(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light = start_can(*options)
    light_up(light, chip)
    assert chip.exported() == [LAMP]
    light.do("reset")
    assert chip.duty(LAMP) == 0.0
    until("a sample", lambda: light.do("outputs")["limit_ppm"] > 0)
    light_up(light, chip)
    assert light.signal(signal.SIGTERM) == 0
    assert chip.duty(LAMP) == 0.0
    assert chip.exported() == []


def test_channel_that_was_exported_before_stays_so(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    chip.export(LAMP)
    for number in (signal.SIGTERM, signal.SIGKILL):
        light = start_can(*options)
        light_up(light, chip)
        light.signal(number)
        until("dark", lambda: chip.duty(LAMP) == 0.0)
        until("switched off", lambda: chip.read(LAMP, "enable") == "0")
        assert chip.exported() == [LAMP]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV, signal.SIGHUP, signal.SIGTERM])
def test_lamp_is_dark_however_the_light_ends(
    start_can: Start, chip: Pca9685, options: tuple[str, ...], number: signal.Signals
) -> None:
    light = start_can(*options)
    light_up(light, chip)
    light.signal(number)
    until("dark", lambda: chip.duty(LAMP) == 0.0)
    until("given back", lambda: chip.exported() == [])


def test_next_light_waits_for_the_guard_of_a_killed_one(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    first = start_can(*options)
    light_up(first, chip)
    guard = until("a guard", first.guard)
    os.kill(guard, signal.SIGSTOP)
    first.signal(signal.SIGKILL)
    assert chip.duty(LAMP) > 0.0, "the guard's, still"
    os.kill(guard, signal.SIGCONT)
    second = start_can(*options)
    light_up(second, chip)
    assert chip.exported() == [LAMP]


def test_killed_guard_is_replaced_at_once(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light = start_can(*options)
    light_up(light, chip)
    for _ in range(3):
        first = until("a guard", light.guard)
        os.kill(first, signal.SIGKILL)
        until("another guard", lambda: light.guard() not in (0, first))  # noqa: B023
        assert chip.duty(LAMP) > 0.0
    light.signal(signal.SIGKILL)
    until("dark", lambda: chip.duty(LAMP) == 0.0)


# --- a chip that goes away ----------------------------------------------------------------------


def test_chip_that_goes_is_a_lamp_fault_until_it_is_back(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light = start_can(*options)
    light_up(light, chip)
    chip.unplug()
    until("the loss is seen", lambda: not light.do("pwm")["outputs"]["light"]["present"])
    until("it is told", lambda: "is lost" in light.console())
    until("dark", lambda: light.do("outputs")["level_ppm"] == 0)
    assert light.ask("light status", "writes .*").endswith("last -19")
    assert light.ask("light status", "output now .*").split() == [
        *("output", "now", "0", "%", "of", "full", "power")
    ]
    light.shell("light on")
    until("a refusal", lambda: "not now: " in light.console())
    chip.plug()
    until("it is found", lambda: light.do("pwm")["outputs"]["light"]["present"])
    until("lit", lambda: chip.duty(LAMP) > 0.0)
    assert light.do("pwm")["outputs"]["light"]["losses"] == 1
    assert light.do("outputs")["resets"] == 0
    assert (light.console().count("is lost"), light.console().count("is back")) == (1, 1)
    light.signal(signal.SIGKILL)
    until("dark", lambda: chip.duty(LAMP) == 0.0)


def test_chip_that_has_the_number_of_one_that_is_gone_is_left_alone(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light = start_can(*options)
    light_up(light, chip)
    number = chip.folder
    chip.unplug()
    until("the loss is seen", lambda: not light.do("pwm")["outputs"]["light"]["present"])
    other = Pca9685(0x41)
    try:
        assert other.folder == number
        other.export(LAMP)
        pass_time(2.0)  # the light looks for its own every second
        assert other.exported() == [LAMP]
    finally:
        other.remove()
    chip.plug()
    until("it is found", lambda: light.do("pwm")["outputs"]["light"]["present"])


def test_chip_that_is_away_at_a_reset_is_taken_when_it_comes(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light = start_can(*options)
    chip.unplug()
    light.do("reset")
    assert light.ask("startup", "light .*").split()[1] == "error"
    chip.plug()
    # the lamp's driver starts with a reset of its own
    until("a reset", lambda: light.do("outputs")["resets"] == 2)
    assert light.ask("startup", "light .*").split() == ["light", "ok"]
    until("a sample", lambda: light.do("outputs")["limit_ppm"] > 0)
    light_up(light, chip)


# --- at start -----------------------------------------------------------------------------------


def refusal(*words: str) -> str:
    binary = os.environ["PHAROS_BUILD"] + "/pharos"
    done = subprocess.run(
        [binary, "--console", "none", "--can0", "none", *words],
        capture_output=True, text=True, timeout=PATIENCE_S,
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    return done.stderr.strip().removeprefix("pharos: ")


def test_what_the_chip_cannot_is_one_line(chip: Pca9685, lm75: Lm75) -> None:
    assert lm75
    folder = chip.folder / "pwm3"
    assert refusal("--light", "pwm:0/3", *SENSOR) == (
        f"--light: {folder}: period=500us: Invalid argument; some chips have one period for all "
        "channels"
    )
    assert refusal("--light", "pwm:0/3,period=1ms,inverted", *SENSOR) == (
        f"--light: {folder}: polarity inversed: Invalid argument"
    )
    assert refusal("--light", "pwm:0/17,period=1ms", *SENSOR) == "--light: 0 has channels 0 to 16"
    assert chip.exported() == []


def test_channel_of_another_light_is_one_line(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light_up(start_can(*options), chip)
    assert refusal(*options) == f"--light: {chip.folder / 'pwm3'}: another light has it"
    assert chip.duty(LAMP) > 0.0


# --- SIGKILL at any instant ---------------------------------------------------------------------


def test_lamp_is_dark_soon_after_a_kill_at_any_instant(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    """The light is killed while it strobes, commands come, and its guard has just been killed."""
    chance = random.Random(17)
    late_ms = []
    for number in range(KILLS):
        kind = ("light", "guard first", "while it strobes")[number % 3]
        light = start_can(*options)
        light_up(light, chip)
        guard = until("a guard", light.guard)
        if kind == "while it strobes":
            light.shell("light set period 0.05", "light set duty 50")
        if kind == "guard first":
            os.kill(guard, signal.SIGKILL)
            until("another guard", lambda: light.guard() not in (0, guard))  # noqa: B023
        end = time.monotonic() + chance.random() * 0.05
        until("the instant", lambda: time.monotonic() >= end)  # noqa: B023
        light.process.send_signal(signal.SIGKILL)
        killed = time.monotonic()
        until("dark", lambda: chip.duty(LAMP) == 0.0)
        late_ms.append((time.monotonic() - killed) * 1e3)
        until("given back", lambda: chip.exported() == [])
        assert chip.duty(LAMP) == 0.0
        light.close()
    assert len(late_ms) == KILLS > 0
    late_ms.sort()
    middle, high = late_ms[len(late_ms) // 2], late_ms[len(late_ms) * 99 // 100]
    print(f"{KILLS} kills: dark after {middle:.1f} ms, 99 %: {high:.1f}, most: {late_ms[-1]:.1f}")
    assert middle <= DARK_MS


def test_off_makes_the_lamp_dark_after_light_and_guard_were_killed(
    start_can: Start, chip: Pca9685, options: tuple[str, ...]
) -> None:
    light = start_can(*options)
    light_up(light, chip)
    guard = until("a guard", light.guard)
    os.kill(guard, signal.SIGSTOP)
    light.process.send_signal(signal.SIGKILL)
    os.kill(guard, signal.SIGKILL)
    light.process.wait(PATIENCE_S)
    until("both are gone", lambda: not Path(f"/proc/{guard}").exists())
    assert chip.duty(LAMP) > 0.0, "nobody was left"
    binary = os.environ["PHAROS_BUILD"] + "/pharos"
    done = subprocess.run([binary, *options, "--off"], capture_output=True, timeout=PATIENCE_S)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
    assert chip.duty(LAMP) == 0.0
