# SPDX-License-Identifier: Apache-2.0
"""--thermistor on a real kernel's hwmon and IIO, and the lamp that it protects, or nothing does."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from guest_gpio import GpioSim
from guest_i2c import Lm75
from guest_light import PATIENCE_S, Light, Start, until

DUMMIES = Path("/sys/kernel/config/iio/devices/dummy")
SENSOR = "hwmon:lm75/temp1"


@pytest.fixture
def chip(gpio_sim: Callable[..., GpioSim]) -> GpioSim:
    return gpio_sim("LAMP")


@pytest.fixture
def lamp(chip: GpioSim) -> tuple[str, str]:
    """The options of a real lamp."""
    return "--gpio", f"gpiochip:{chip.device},enable=LAMP"


def measured(light: Light) -> int:
    return int(light.do("outputs")["measured_mdegc"])


def lit(light: Light, chip: GpioSim) -> None:
    light.shell("light on")
    until("lit", lambda: chip.value("LAMP") == 1)


# --- the temperature ----------------------------------------------------------------------------


def test_heat_of_an_lm75_throttles_a_real_lamp(
    start_can: Start, chip: GpioSim, lamp: tuple[str, str], lm75: Lm75
) -> None:
    # As hot from the start: a busy host that loses samples of a lamp that heats shuts it down.
    lm75.celsius(90)
    light = start_can(*lamp, "--thermistor", SENSOR)
    lit(light, chip)
    # half way from 80 to 100 degC, half way from 100 % to 20 %
    until("throttled", lambda: light.do("outputs")["level_ppm"] == 600_000)
    assert measured(light) == 90000
    lm75.celsius(100)
    until("shut down", lambda: chip.value("LAMP") == 0)
    assert light.ask("thermal", "state .*").split() == ["state", "shutdown"]


def test_unplugged_sensor_has_failed_until_it_is_back(
    start_can: Start, chip: GpioSim, lamp: tuple[str, str], lm75: Lm75
) -> None:
    light = start_can(*lamp, "--thermistor", SENSOR)
    lit(light, chip)
    lm75.unplug()
    until("failed", lambda: "no samples" in light.ask("thermal", "sensor .*"))
    until("it is told", lambda: "is lost: " in light.console())
    failed_ppm = light.do("outputs")["limit_ppm"]
    assert failed_ppm < 1_000_000
    lm75.plug()
    until("well", lambda: light.ask("thermal", "sensor .*").split() == ["sensor", "ok"])
    until("brighter", lambda: light.do("outputs")["limit_ppm"] > failed_ppm)


def test_one_of_two_chips_of_a_name(start_can: Start, lm75: Lm75) -> None:
    other = Lm75(0x49, celsius=31.5)
    try:
        light = start_can("--thermistor", f"hwmon:lm75@{other.device}/temp1")
        until("its temperature", lambda: measured(light) == 31500)
        again = start_can("--thermistor", f"hwmon:lm75@{lm75.device}/temp1")
        until("the other's", lambda: measured(again) == 25000)
    finally:
        other.remove()


@pytest.fixture
def adc(tmp_path: Path) -> Iterator[str]:
    """The name of an ADC of the kernel's iio_dummy: 73 with an offset of 7. Its scale would make
    0.1 mV of that; another one lies over it."""
    with ExitStack() as stack:
        folder = DUMMIES / "lamp-adc"
        folder.mkdir()
        stack.callback(folder.rmdir)
        (device,) = Path("/sys/bus/iio/devices").glob("iio:device*")
        assert (device / "in_voltage0_raw").read_text() == "73\n"
        assert (device / "in_voltage0_offset").read_text() == "7\n"
        scale = tmp_path / "scale"
        scale.write_text("20.625\n")
        subprocess.run(["mount", "--bind", scale, device / "in_voltage0_scale"], check=True)
        stack.callback(lambda: subprocess.run(["umount", device / "in_voltage0_scale"], check=True))
        yield "lamp-adc"


def test_ntc_on_an_adc_of_iio(start_can: Start, adc: str) -> None:
    # 80 * 20.625 mV: half of 3300 mV, as much NTC as pull-up
    light = start_can("--thermistor", f"iio:{adc}/in_voltage0")
    until("25 degC", lambda: abs(measured(light) - 25000) <= 10)


def test_slow_bus_is_no_samples_and_stops_nothing(start_can: Start, tmp_path: Path) -> None:
    """A sensor that does not answer: a pipe that nobody writes to."""
    folder = tmp_path / "class/hwmon/hwmon0"
    folder.mkdir(parents=True)
    (folder / "name").write_text("slow\n")
    value = folder / "temp1_input"
    value.write_text("25000\n")
    light = start_can("--sysfs", str(tmp_path), "--thermistor", "hwmon:slow/temp1")
    light.shell("light set period 0.1", "light set duty 50", "light on")
    until("it strobes", lambda: light.do("outputs")["edges"] > 4)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    pipe.rename(value)
    until("failed", lambda: "no samples" in light.ask("thermal", "sensor .*"))
    edges = light.do("outputs")["edges"]
    until("it strobes on", lambda: light.do("outputs")["edges"] > edges + 10)
    assert light.do("outputs")["resets"] == 0
    file = tmp_path / "file"
    file.write_text("25000\n")
    with value.open("w") as writer:
        writer.write("25000\n")
        file.rename(value)
    until("well", lambda: light.ask("thermal", "sensor .*").split() == ["sensor", "ok"])


# --- a real lamp without a real sensor ----------------------------------------------------------


def test_real_lamp_with_a_simulated_sensor_stays_dark(
    binary: Path, tmp_path: Path, chip: GpioSim, lamp: tuple[str, str]
) -> None:
    light = Light(binary, tmp_path, *lamp, sampled=False)
    try:
        assert light.do("hardware")["lamp"] == "--gpio"
        assert light.do("hardware")["allows_light"] is False
        assert light.errors().count("the lamp stays dark: it is real (--gpio)") == 1
        assert "give --thermistor hwmon:NAME/temp1" in light.errors()
        light.shell("param set THR_FIRST 0.1")  # not even what a failed sensor allows
        light.shell("light on")
        until("a refusal", lambda: "not now: " in light.console())
        assert light.ask("startup", "light .*").split() == ["light", "error", "-19"]
        assert light.ask("startup", "sensor .*").split() == ["sensor", "error", "-19"]
        assert light.do("outputs")["edges"] == 0
        assert chip.value("LAMP") == 0
    finally:
        light.close()


def test_unsafe_lamp_is_lit_and_every_status_says_so(
    start: Start, chip: GpioSim, lamp: tuple[str, str]
) -> None:
    light = start(*lamp, "--unsafe-simulated-sensor")
    lit(light, chip)
    assert "nothing protects the lamp from heat" in light.errors()
    assert light.ask("light status", "sensor .*").endswith(
        "SIMULATED: nothing protects the lamp from heat"
    )
    assert light.do("outputs")["unprotected"] is True
    assert light.do("hardware")["unprotected"] is True


def test_lamp_with_a_real_sensor_is_not_called_unsafe(
    start_can: Start, chip: GpioSim, lamp: tuple[str, str], lm75: Lm75
) -> None:
    light = start_can(*lamp, "--thermistor", SENSOR, "--unsafe-simulated-sensor")
    lit(light, chip)
    assert "protects" not in light.errors()
    assert light.do("outputs")["unprotected"] is False
    light.shell("light status")
    light.status()
    assert "SIMULATED" not in light.console()


def test_absent_sensor_is_one_line(binary: Path, lamp: tuple[str, str]) -> None:
    done = subprocess.run(
        [binary, "--console", "none", "--can0", "none", *lamp, "--thermistor", SENSOR],
        capture_output=True, text=True, timeout=PATIENCE_S,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == "pharos: --thermistor: no hwmon sensor is called lm75; there is none\n"
