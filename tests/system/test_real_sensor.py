# SPDX-License-Identifier: Apache-2.0
"""--thermistor: the lamp's temperature from the kernel's sensors, here from plain files."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fake_sysfs import FakeSysfs
from harness import (
    ACCEPTED,
    BINARY,
    FULL_PPM,
    OVER_TEMPERATURE,
    THERMISTOR_FAILURE,
    WIRES,
    Light,
    light_on,
)
from pharos import Simulator

Start = Callable[..., Simulator]
THROTTLING = 1


@pytest.fixture
def sysfs(tmp_path: Path) -> FakeSysfs:
    return FakeSysfs(tmp_path)


def options(sysfs: FakeSysfs, sensor: str) -> tuple[str, ...]:
    return "--sysfs", str(sysfs.root), "--thermistor", sensor


def begin(start: Start, sysfs: FakeSysfs, sensor: str) -> Light:
    return light_on(start({"uart0": WIRES["udp"]}, options=options(sysfs, sensor)))


def measured(light: Light) -> int:
    light.sim.advance(s=1)
    return int(light.sim.outputs()["measured_mdegc"])


def refusal(sysfs: FakeSysfs, sensor: str, *more: str) -> str:
    """The one line with which the light refuses to start."""
    done = subprocess.run(
        [BINARY, "--console", "none", "--can0", "none", *options(sysfs, sensor), *more],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("pharos: --thermistor: ")
    return done.stderr.strip().removeprefix("pharos: --thermistor: ")


# --- temperatures -------------------------------------------------------------------------------


def test_temperature_is_the_hwmon_sensors(start: Start, sysfs: FakeSysfs) -> None:
    sysfs.hwmon(0, "coretemp", temp1_input=61000)
    sensor = sysfs.hwmon(3, "lm75", temp1_input=42500)
    light = begin(start, sysfs, "hwmon:lm75/temp1")
    assert measured(light) == 42500
    sysfs.set(sensor, "temp1_input", 42375)
    assert measured(light) == 42375
    assert light.status().temp_c == 42.375
    assert light.sim.request("thermistor")["failures"] == 0
    assert light.sim.request("hardware")["sensor"] == "hwmon:lm75/temp1"


def test_temperature_is_the_thermal_zones(start: Start, sysfs: FakeSysfs) -> None:
    sysfs.zone(0, "gpu-thermal", temp=50000)
    sysfs.zone(1, "lamp-thermal", temp=31250)
    assert measured(begin(start, sysfs, "thermal:lamp-thermal")) == 31250


@pytest.mark.parametrize(
    ("scale", "offset"),
    [
        ({"in_voltage0_scale": "0.805664062"}, {}),
        ({"in_voltage_scale": "0.805664062"}, {}),
        ({"in_voltage0_scale": "0.805664062"}, {"in_voltage0_offset": 48}),
        ({"in_voltage_scale": "0.805664062"}, {"in_voltage_offset": -96}),
    ],
)
def test_ntcs_voltage_is_raw_with_offset_times_scale(
    start: Start, sysfs: FakeSysfs, scale: dict[str, str], offset: dict[str, int]
) -> None:
    # Half of 3300 mV is as much NTC as pull-up: 10 kOhm, 25 degC.
    raw = 2048 - sum(offset.values())
    sysfs.iio(0, "ads1015", in_voltage0_raw=raw, **scale, **offset)
    assert measured(begin(start, sysfs, "iio:ads1015/in_voltage0")) == pytest.approx(25000, abs=10)


@pytest.mark.parametrize(
    ("raw", "scale", "divider", "temp_mdegc"),
    [
        # Of tests/unit/drivers/thermistor_test.c, from the formula: codes 3418 and 60000 of 65520
        (3418, 3300 / 65520, "", 125281),
        (60000, 3300 / 65520, "", -26152),
        (60000, 5000 / 65520, ",reference=5000", -26152),
        # and 3900 of 4095 with another NTC and pull-up
        (3900, 3300 / 4095, ",pullup=4700,r25=100000,beta=3950", 26399),
    ],
)
def test_ntcs_curve_is_the_mcus(
    start: Start, sysfs: FakeSysfs, raw: int, scale: float, divider: str, temp_mdegc: int
) -> None:
    sysfs.iio(0, "adc", in_voltage3_raw=raw, in_voltage3_scale=f"{scale:.9f}")
    light = begin(start, sysfs, f"iio:adc/in_voltage3{divider}")
    assert measured(light) == pytest.approx(temp_mdegc, abs=20)


def test_iio_temperature(start: Start, sysfs: FakeSysfs) -> None:
    # (1400 + 200) * 31.25 mdegC
    sysfs.iio(0, "tmp", in_temp_raw=1400, in_temp_offset=200, in_temp_scale="31.25")
    assert measured(begin(start, sysfs, "iio:tmp/in_temp")) == 50000


# --- what it does to the lamp -------------------------------------------------------------------


def test_heat_throttles_and_shuts_down(start: Start, sysfs: FakeSysfs) -> None:
    sensor = sysfs.hwmon(0, "lm75", temp1_input=90000)
    light = begin(start, sysfs, "hwmon:lm75/temp1")
    assert light.on() == ACCEPTED
    light.sim.advance(s=1)
    # half way from 80 to 100 degC, half way from 100 % to 20 %
    assert light.level_ppm() == 600_000
    assert light.status().error_status == THROTTLING
    for temp_mdegc in range(91000, 101000, 1000):
        sysfs.set(sensor, "temp1_input", temp_mdegc)
        light.sim.advance(s=1)
    assert light.level_ppm() == 0
    assert light.status().error_status == OVER_TEMPERATURE


def test_digital_sensor_may_stand_still_an_ntc_may_not(start: Start, sysfs: FakeSysfs) -> None:
    sysfs.hwmon(0, "lm75", temp1_input=25000)
    adc = sysfs.iio(0, "adc", in_voltage0_raw=2048, in_voltage0_scale="0.805664062")
    digital = begin(start, sysfs, "hwmon:lm75/temp1")
    ntc = begin(start, sysfs, "iio:adc/in_voltage0")
    for light in (digital, ntc):
        assert light.on() == ACCEPTED
        light.sim.advance(s=60)
    assert digital.status().error_status == 0
    assert ntc.status().error_status == THERMISTOR_FAILURE
    sysfs.set(adc, "in_voltage0_raw", 2049)
    ntc.sim.advance(s=5)
    assert ntc.status().error_status == 0


@pytest.mark.parametrize("raw", [4095, 0, 5000, -5])
def test_open_and_shorted_ntc_has_failed(start: Start, sysfs: FakeSysfs, raw: int) -> None:
    sysfs.iio(0, "adc", in_voltage0_raw=raw, in_voltage0_scale="0.805664062")
    light = begin(start, sysfs, "iio:adc/in_voltage0")
    assert light.status().error_status & THERMISTOR_FAILURE


def test_unplugged_sensor_has_failed_until_it_is_back(start: Start, sysfs: FakeSysfs) -> None:
    sensor = sysfs.hwmon(0, "lm75", temp1_input=25000)
    light = begin(start, sysfs, "hwmon:lm75/temp1")
    assert light.on() == ACCEPTED
    assert light.level_ppm() == FULL_PPM
    sensor.rename(sysfs.root / "unplugged")
    light.sim.advance(s=1)
    assert light.status().error_status == THERMISTOR_FAILURE
    assert light.level_ppm() < FULL_PPM
    # another number: the kernel counts on
    (sysfs.root / "unplugged").rename(sensor.with_name("hwmon7"))
    light.sim.advance(s=15)
    assert light.status().error_status == 0
    assert light.level_ppm() == FULL_PPM


def test_sensor_that_is_away_at_a_reset_may_come_back(start: Start, sysfs: FakeSysfs) -> None:
    sensor = sysfs.hwmon(0, "lm75", temp1_input=25000)
    light = begin(start, sysfs, "hwmon:lm75/temp1")
    sensor.rename(sysfs.root / "unplugged")
    light.sim.reset()
    light.sim.advance(s=2)
    assert light.sim.outputs()["limit_ppm"] == 0
    (sysfs.root / "unplugged").rename(sensor)
    light.sim.advance(s=15)
    assert light.sim.outputs()["limit_ppm"] == FULL_PPM


@pytest.mark.parametrize("line", ["", "warm", "25000 mC", "nan", "9" * 400])
def test_nonsense_is_no_sample(start: Start, sysfs: FakeSysfs, line: str) -> None:
    sensor = sysfs.hwmon(0, "lm75", temp1_input=25000)
    light = begin(start, sysfs, "hwmon:lm75/temp1")
    sysfs.set(sensor, "temp1_input", line)
    light.sim.advance(s=1)
    assert light.status().error_status == THERMISTOR_FAILURE
    sysfs.set(sensor, "temp1_input", 25000)
    light.sim.advance(s=5)
    assert light.status().error_status == 0


def test_chip_that_says_its_input_has_a_fault_has_failed(start: Start, sysfs: FakeSysfs) -> None:
    sensor = sysfs.hwmon(0, "max6581", temp2_input=25000, temp2_fault=0)
    light = begin(start, sysfs, "hwmon:max6581/temp2")
    assert light.status().error_status == 0
    sysfs.set(sensor, "temp2_fault", 1)
    light.sim.advance(s=1)
    assert light.status().error_status == THERMISTOR_FAILURE


# --- at start -----------------------------------------------------------------------------------


def test_absent_and_ambiguous_sensors_are_one_line(sysfs: FakeSysfs) -> None:
    assert refusal(sysfs, "hwmon:lm75/temp1") == "no hwmon sensor is called lm75; there is none"
    sysfs.hwmon(0, "coretemp", temp1_input=61000)
    sysfs.hwmon(1, "lm75", device="1-0048", temp1_input=25000)
    sysfs.hwmon(2, "lm75", device="1-0049", temp1_input=26000)
    assert refusal(sysfs, "hwmon:lm76/temp1") == (
        "no hwmon sensor is called lm76; there are: coretemp, lm75, lm75"
    )
    assert refusal(sysfs, "hwmon:lm75/temp1") == (
        "2 hwmon sensors are called lm75; name one: lm75@1-0048, lm75@1-0049"
    )
    assert refusal(sysfs, "hwmon:coretemp/temp2") == "hwmon sensor coretemp has no temp2_input"
    assert refusal(sysfs, "thermal:lamp") == "no thermal zone is called lamp; there is none"
    sysfs.zone(0, "lamp", temp=25000)
    sysfs.zone(1, "lamp", temp=26000)
    assert refusal(sysfs, "thermal:lamp") == (
        "2 thermal zones are called lamp; name one: lamp@thermal_zone0, lamp@thermal_zone1"
    )


@pytest.mark.parametrize(("called", "mdegc"), [("lm75@1-0049", 26000), ("lm75@hwmon1", 25000)])
def test_one_of_several_by_its_device(
    start: Start, sysfs: FakeSysfs, called: str, mdegc: int
) -> None:
    sysfs.hwmon(1, "lm75", device="1-0048", temp1_input=25000)
    sysfs.hwmon(2, "lm75", device="1-0049", temp1_input=26000)
    assert measured(begin(start, sysfs, f"hwmon:{called}/temp1")) == mdegc


def test_one_of_several_thermal_zones_by_its_entry(start: Start, sysfs: FakeSysfs) -> None:
    sysfs.zone(0, "lamp", temp=25000)
    sysfs.zone(1, "lamp", temp=26000)
    assert measured(begin(start, sysfs, "thermal:lamp@thermal_zone1")) == 26000


@pytest.mark.parametrize(
    ("sensor", "line"),
    [
        ("lm75", '"lm75" is none of sim, hwmon:NAME/temp1, thermal:TYPE, iio:NAME/in_voltage0'),
        ("thermal:", '"thermal:" is none of sim, hwmon:NAME/temp1, thermal:TYPE, '
         "iio:NAME/in_voltage0"),
        ("hwmon:lm75", '"lm75" is not as hwmon:NAME/temp1'),
        ("hwmon:/temp1", '"/temp1" is not as hwmon:NAME/temp1'),
        *(
            (f"hwmon:ina219/{channel}", f"hwmon: {channel} is no temperature such as temp1")
            for channel in ("in1", "fan1", "curr1", "power1", "temp", "temp1_crit", "temperature")
        ),
        ("iio:adc/voltage0", "iio: voltage0 is neither in_voltage… nor in_temp…"),
        ("iio:adc/in_voltage0,beta=900",
         'beta: "900" is not a whole number from 1000 to 10000'),
        ("iio:adc/in_voltage0,gamma=1", '"gamma" is not one of reference, pullup, r25 and beta'),
    ],
)  # fmt: skip
def test_wrong_words_are_one_line(sysfs: FakeSysfs, sensor: str, line: str) -> None:
    assert refusal(sysfs, sensor) == line


def test_real_sensor_needs_real_time() -> None:
    done = subprocess.run(
        [BINARY, "--time", "virtual", "--console", "none", "--thermistor", "hwmon:lm75/temp1"],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == "pharos: --thermistor: a real sensor needs --time real\n"


def test_simulated_sensor_of_a_simulated_lamp_needs_nothing(start: Start) -> None:
    sim = start()
    reply: dict[str, Any] = sim.request("hardware")
    assert (reply["lamp"], reply["sensor"]) == ("simulated", "simulated")
    assert (reply["allows_light"], reply["unprotected"]) == (True, False)
    assert sim.outputs()["unprotected"] is False
