# SPDX-License-Identifier: Apache-2.0
"""The device's own shell, on a pty."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from harness import CONSOLE, FULL_PPM, QEMU_IMAGE, WIRES, Light, Shell, light_on
from pharos import Simulator


@pytest.fixture
def both(start: Callable[..., Simulator]) -> tuple[Light, Shell]:
    sim = start({"uart0": WIRES["udp"], "console": CONSOLE})
    light = light_on(sim)
    return light, Shell(sim)


def test_light_on_and_off(both: tuple[Light, Shell]) -> None:
    light, shell = both
    light.configure(100)
    shell("light on")
    assert light.level_ppm() == FULL_PPM
    assert light.status().enable == 1
    shell("light off")
    assert light.level_ppm() == 0
    assert light.status().enable == 0


def test_light_set_is_seen_over_mavlink(both: tuple[Light, Shell]) -> None:
    light, shell = both
    shell("light set brightness 40")
    assert light.status().brightness == 40.0


def test_light_status_tells_the_state(both: tuple[Light, Shell]) -> None:
    light, shell = both
    light.configure(60)
    light.on()
    out = shell("light status")
    assert "on" in out
    assert "60" in out


def test_light_set_out_of_range_is_refused(both: tuple[Light, Shell]) -> None:
    light, shell = both
    light.configure(60)
    ranges = "out of range; nothing changed (0 to 100 %, period 0 or 0.01 to 10 s)"
    for refused in ("brightness 101", "duty 100.1", "period 10.1", "period 0.009"):
        assert ranges in shell(f"light set {refused}")
    assert light.status().brightness == 60.0


def test_thermal_tells_temperature_and_limit(both: tuple[Light, Shell]) -> None:
    out = both[1]("thermal")
    assert re.search(r"-?\d+\.\d+", out)
    assert "limit" in out


def test_link_stats_counts_frames(both: tuple[Light, Shell]) -> None:
    light, shell = both

    def received() -> list[int]:
        return [int(n) for n in re.findall(r"\d+", shell("link stats"))]

    before = received()
    for _ in range(10):
        light.on()
    assert received() != before


def test_kernel_threads_names_them(both: tuple[Light, Shell]) -> None:
    # one command, before Zephyr 4.0 and since
    out = both[1]("kernel threads") + both[1]("kernel thread list")
    for name in ("command", "thermal", "supervisor", "shell"):
        assert name in out


def test_version_is_told(both: tuple[Light, Shell]) -> None:
    assert re.search(r"\d+\.\d+", both[1]("version"))


def test_unknown_command_is_said_to_be_unknown(both: tuple[Light, Shell]) -> None:
    assert "not found" in both[1]("lihgt on")


def test_tab_completes(both: tuple[Light, Shell]) -> None:
    light, shell = both
    light.configure(100)
    assert "light" in shell.keys("lig\t")
    shell(" on")
    assert light.level_ppm() == FULL_PPM


def test_arrow_up_brings_the_last_line_back(both: tuple[Light, Shell]) -> None:
    light, shell = both
    shell("light on")
    light.off()
    shell("\x1b[A")
    assert light.status().enable == 1


def test_backspace_and_control_c_edit_the_line(both: tuple[Light, Shell]) -> None:
    light, shell = both
    shell("light ofg\x7f\x7fn")
    assert light.status().enable == 1
    shell.keys("light off\x03")
    shell("")
    assert light.status().enable == 1


def test_names_are_taken_in_either_case(both: tuple[Light, Shell]) -> None:
    shell = both[1]
    assert "LGT_LOSS" in shell("param get lgt_loss")
    assert re.search(r"LGT_LOSS +43\.21 +s ", shell("param set lgt_Loss 43.21"))
    assert "no parameter" in shell("param set lgt_los 43")
    assert "\nok" in shell("light program SOS")
    assert "sos" in shell("light status")
    assert "uart0" in shell("link stats UART0")


def test_tab_completes_names_of_parameters_programs_and_links(both: tuple[Light, Shell]) -> None:
    shell = both[1]
    shell.keys("param set LGT_LOS\t")
    assert re.search(r"LGT_LOSS +12\.34 +s ", shell("12.34"))
    shell.keys("light program double\t")
    assert "\nok" in shell("")
    assert "double-flash" in shell("light status")
    shell.keys("link stats ua\t")  # as far as they are alike
    assert "rx" in shell("" if QEMU_IMAGE else "0")  # it has one UART


def test_the_counters_of_one_link(both: tuple[Light, Shell]) -> None:
    shell = both[1]
    assert "tunnel" not in shell("link stats uart0")
    assert "no link 'uart9'" in shell("link stats uart9")
