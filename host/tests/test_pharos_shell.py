# SPDX-License-Identifier: Apache-2.0
"""The shell's commands on a simulated light, in lock-step."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pharos import Light, SilentError, Simulator, Target, UsageError
from pharos.cli.shell import COMMANDS, OK, REFUSED, SILENT, USAGE, Printer, Shell, parse


class Desk:
    """A shell, what it printed, and the light that it commands."""

    def __init__(self, sim: Simulator, as_json: bool = False) -> None:
        self.sim = sim
        self.out, self.err = io.StringIO(), io.StringIO()
        self.light = Light(sim.connect("uart0"))
        self.light.find()
        # Until the first sample (10 Hz) the lamp's limit is zero.
        sim.advance(s=1)
        self.shell = Shell(self.light, Printer(self.out, self.err, as_json))

    def __call__(self, text: str) -> int:
        for stream in (self.out, self.err):
            stream.seek(0)
            stream.truncate()
        return self.shell.execute(text)

    def printed(self) -> str:
        return self.out.getvalue()

    def objects(self) -> list[dict[str, Any]]:
        return [
            json.loads(line, parse_constant=pytest.fail) for line in self.printed().splitlines()
        ]

    def outputs(self, *names: str) -> list[Any]:
        now = self.sim.outputs()
        return [now[name] for name in names]


@pytest.fixture
def sim(binary: Path) -> Iterator[Simulator]:
    with Simulator(binary, {"uart0": "udpin:127.0.0.1:0"}) as sim:
        yield sim


@pytest.fixture
def desk(sim: Simulator) -> Desk:
    return Desk(sim)


def test_on_and_off(desk: Desk) -> None:
    assert desk("brightness 100; on") == OK
    assert desk.printed() == "ok\nok\n"
    assert desk.outputs("level_ppm") == [1_000_000]
    assert desk("off") == OK
    assert desk.outputs("level_ppm") == [0]


@pytest.mark.parametrize(
    ("text", "period_us", "duty_ppm"),
    [
        ("strobe 0.5 20", 500_000, 200_000),
        ("strobe 250ms 5%", 250_000, 50_000),
        ("strobe 2Hz 10", 500_000, 100_000),
        ("strobe 1s 50", 1_000_000, 500_000),
        ("strobe 20000us 50", 20_000, 500_000),
    ],
)
def test_strobe_takes_seconds_or_units(
    desk: Desk, text: str, period_us: int, duty_ppm: int
) -> None:
    assert desk(text) == OK
    assert desk.outputs("strobe_period_us", "strobe_duty_ppm") == [period_us, duty_ppm]


def test_each_setting_leaves_the_others_as_they_are(desk: Desk) -> None:
    names = ("brightness_ppm", "strobe_period_us", "strobe_duty_ppm", "mode")
    assert desk("brightness 40; strobe 0.5 20; sync") == OK
    assert desk.outputs(*names) == [400_000, 500_000, 200_000, 2]
    assert desk("brightness 60%") == OK
    assert desk.outputs(*names) == [600_000, 500_000, 200_000, 2]
    assert desk("strobe 1") == OK
    assert desk.outputs(*names) == [600_000, 1_000_000, 200_000, 2]
    assert desk("sync off") == OK
    assert desk.outputs(*names) == [600_000, 1_000_000, 200_000, 1]
    assert desk("strobe off") == OK
    assert desk.outputs("strobe_period_us") == [0]


def test_first_strobe_without_a_duty_cycle_is_lit_half_the_time(desk: Desk) -> None:
    assert desk("strobe 1") == OK
    assert desk.outputs("strobe_duty_ppm") == [500_000]


@pytest.mark.parametrize(
    "text", ["brightness 100.5", "brightness -1", "strobe 0.0001", "strobe 60", "strobe 1 101"]
)
def test_refused_value_exits_1_with_the_reason_and_the_ranges(desk: Desk, text: str) -> None:
    assert desk("brightness 40; strobe 0.5 20") == OK
    assert desk(text) == REFUSED
    assert desk.printed() == ""
    assert desk.err.getvalue().startswith(f"pharos: {text.split()[0]}: denied: ")
    assert "periods from 0.01 to 10 s" in desk.err.getvalue()
    assert desk.err.getvalue().count("\n") == 1
    assert desk.outputs("brightness_ppm", "strobe_period_us") == [400_000, 500_000]


def test_on_while_too_hot_says_why(desk: Desk) -> None:
    desk.sim.set_ambient(120)
    assert desk("brightness 100; on") == OK
    desk.sim.advance(s=600)
    assert desk("status") == OK
    assert "OVER-TEMPERATURE SHUTDOWN" in desk.printed()
    assert "light: " in desk.printed()  # it said so when it happened
    assert desk("on") == REFUSED
    assert desk.err.getvalue() == (
        "pharos: on: failed: not possible now (over-temperature shutdown)\n"
    )


def test_first_failure_ends_the_line(desk: Desk) -> None:
    assert desk("brightness 40; brightness 140; on") == REFUSED
    assert desk.outputs("brightness_ppm", "enable") == [400_000, 0]


def test_line_that_is_not_understood_does_nothing_at_all(desk: Desk) -> None:
    assert desk("on; dance") == USAGE
    assert desk.err.getvalue() == "pharos: 'dance' is no command; `help` lists them\n"
    assert desk.outputs("enable") == [0]


@pytest.mark.parametrize(
    "text",
    [
        "on 1",
        "brightness",
        "brightness x",
        "brightness nan",
        "brightness inf",
        "brightness 1 2",
        "strobe",
        "strobe fast",
        "strobe 0Hz",
        "strobe off 20",
        "strobe 1 2 3",
        "sync maybe",
        "status now",
        "watch 0",
        "watch -1",
        "help dance",
    ],
)
def test_bad_arguments_are_a_usage_error_that_shows_the_usage(text: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse(text)
    assert f"usage: {COMMANDS[text.split()[0]].usage}" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_empty_lines_and_comments_are_nothing(desk: Desk) -> None:
    for text in ("", "  ", ";;", "# on", " ; # brightness 40"):
        assert desk(text) == OK
    assert desk.printed() == ""
    assert desk.outputs("enable") == [0]


def test_status_reads_well(desk: Desk) -> None:
    assert desk("brightness 40; strobe 0.5 20; on; status") == OK
    assert desk.printed().splitlines()[-1].startswith("on, 40 %, strobe 0.5 s at 20 %, 2")
    assert desk.printed().endswith(" °C\n")


def test_watch_shows_each_report_once(desk: Desk) -> None:
    before = desk.sim.now_us()
    assert desk("watch 5") == OK
    assert len(desk.printed().splitlines()) == 5
    assert 4_000_000 <= desk.sim.now_us() - before <= 6_000_000  # they come at 1 Hz


def test_info_says_who_it_is(desk: Desk) -> None:
    assert desk("info") == OK
    for part in ("Pharos", "software ", "hardware native", "component 1/243"):
        assert part in desk.printed()


def test_help_lists_every_command(desk: Desk) -> None:
    assert desk("help") == OK
    assert len(desk.printed().splitlines()) == len(COMMANDS)
    assert desk("help strobe") == OK
    assert desk.printed().startswith("strobe PERIOD [DUTY] | off")


def test_quit_ends_it(desk: Desk) -> None:
    assert desk("quit; on") == OK
    assert desk.shell.is_done
    assert desk.outputs("enable") == [0]


def test_light_that_falls_silent_exits_3(desk: Desk) -> None:
    desk.sim.fault("uart0", "lost", rate_ppm=1_000_000)
    assert desk("on") == SILENT
    assert "stopped answering" in desk.err.getvalue()


def test_lost_command_is_repeated(desk: Desk) -> None:
    """Half of the bytes' datagrams are hit; three tries get most commands through, and what is
    reported as done is done."""
    desk.sim.fault("uart0", "lost", rate_ppm=3_000, direction="rx")
    done = 0
    for number in range(40):
        if desk("on" if number % 2 == 0 else "off") == OK:
            done += 1
            assert desk.outputs("enable") == [int(number % 2 == 0)]
    assert done >= 38


# --- JSON -----------------------------------------------------------------------------------------
def test_json_is_one_object_per_line(sim: Simulator) -> None:
    desk = Desk(sim, as_json=True)
    assert desk("brightness 40; strobe 0.5 20; on; status; watch 2; info; help") == OK
    first, *_, status, one, two, info, _ = desk.objects()
    assert first == {"command": "brightness", "ok": True}
    assert status == {
        "command": "status",
        "ok": True,
        "enable": True,
        "mode": "internal",
        "brightness": 40.0,
        "strobe_period": 0.5,
        "strobe_duty_cycle": 20.0,
        "temp_c": status["temp_c"],
        "errors": [],
        "min_strobe_period": 0.01,
        "max_strobe_period": 10.0,
        "uptime_ms": status["uptime_ms"],
    }
    assert 20 < status["temp_c"] < 40
    assert two["uptime_ms"] - one["uptime_ms"] == 1000
    assert (info["system"], info["component"], info["hardware_version"]) == (1, 243, "native")


def test_json_of_a_refusal_has_the_result(sim: Simulator) -> None:
    desk = Desk(sim, as_json=True)
    assert desk("brightness 140") == REFUSED
    (refusal,) = desk.objects()
    assert (refusal["command"], refusal["ok"], refusal["result"]) == ("brightness", False, 2)
    assert refusal["error"].startswith("denied")
    assert desk.err.getvalue().startswith("pharos: brightness: denied")


def test_json_has_no_nan(sim: Simulator) -> None:
    desk = Desk(sim, as_json=True)
    sim.fault("thermistor", "open")
    sim.advance(s=5)
    assert desk("status") == OK
    (status,) = (found for found in desk.objects() if found.get("command") == "status")
    assert "thermistor failure" in status["errors"]
    assert status["temp_c"] is None


# --- finding the light ----------------------------------------------------------------------------
def test_other_components_are_not_taken_for_the_light(sim: Simulator) -> None:
    light = Light(sim.connect("uart0"))
    with pytest.raises(
        SilentError, match=r"no component 7/9 answered within 2 s; heard 1/154, 1/243"
    ):
        light.find(2_000_000, Target(7, 9))
    assert light.find() == Target(1, 243)
