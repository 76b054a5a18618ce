# SPDX-License-Identifier: Apache-2.0
"""--gpio gpiochip:… on a real kernel's GPIO character device, with gpio-sim around it."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import gpiod
import pytest

from guest_gpio import GpioSim, KeepingChip
from guest_light import PATIENCE_S, Light, Start, pass_time, until

LINES = ("LAMP", "CAMERA", "SYNC", "BUTTON", "FAULT", "SPARE")

Settings = dict[Iterable[int | str] | int | str, gpiod.LineSettings | None]


@pytest.fixture
def chip(gpio_sim: Callable[..., GpioSim]) -> GpioSim:
    return gpio_sim(*LINES)


# The lamp is real to the light, and its temperature is beside the point here.
UNSAFE = "--unsafe-simulated-sensor"


def options(chip: GpioSim, uses: str) -> tuple[str, ...]:
    return "--gpio", f"gpiochip:{chip.device},{uses}", UNSAFE


def refusal(binary: Path, *words: str) -> str:
    """The one line with which the light refuses to start."""
    done = subprocess.run(
        [binary, "--console", "none", "--can0", "none", *words],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    return done.stderr.strip()


# --- outputs ------------------------------------------------------------------------------------


def test_lamp_line_follows_the_light(start: Start, chip: GpioSim) -> None:
    light = start(*options(chip, "enable=LAMP,strobe=1"))
    assert (chip.value("LAMP"), chip.value("CAMERA")) == (0, 0)
    light.shell("light on")
    until("both high", lambda: (chip.value("LAMP"), chip.value("CAMERA")) == (1, 1))
    light.shell("light off")
    until("both low", lambda: (chip.value("LAMP"), chip.value("CAMERA")) == (0, 0))


def test_control_socket_drives_no_real_lamp(binary: Path, chip: GpioSim, tmp_path: Path) -> None:
    """Its driver has not started, for want of a sensor: the line is nobody's."""
    lamp = ("--gpio", f"gpiochip:{chip.device},enable=LAMP")
    light = Light(binary, tmp_path, *lamp, sampled=False)
    try:
        for _ in range(2):
            light.do("gpio", line="lamp_enable", value=1)
            assert light.line("lamp_enable") == 1
            assert (chip.value("LAMP"), light.do("gpiochip")["lines"]["enable"]) == (0, 0)
            light.do("reset")
    finally:
        light.close()


def test_lines_belong_to_the_light_while_it_runs(start: Start, chip: GpioSim) -> None:
    light = start(*options(chip, "enable=LAMP,sync=SYNC"))
    with gpiod.Chip(chip.device) as opened:
        assert opened.get_line_info("LAMP").consumer == "pharos"
        assert opened.get_line_info("LAMP").direction == gpiod.line.Direction.OUTPUT
        assert opened.get_line_info("SYNC").direction == gpiod.line.Direction.INPUT
        assert not opened.get_line_info("SPARE").used
        assert light.signal(signal.SIGTERM) == 0
        assert not opened.get_line_info("LAMP").used


def test_every_strobe_edge_reaches_the_line(start: Start, chip: GpioSim) -> None:
    light = start(*options(chip, "enable=LAMP"))
    before = light.do("outputs")["edges"]
    light.shell("light set period 1", "light set duty 50", "light on")
    levels: dict[int, int] = {}

    def six_edges() -> bool:
        # the line's level after so many edges; an observer on a busy machine may come too late
        count = light.do("outputs")["edges"]
        level = chip.value("LAMP")
        if light.do("outputs")["edges"] == count:
            assert levels.setdefault(count - before, level) == level
        return len(levels.keys() - {0}) >= 6

    until("six edges", six_edges)
    light.shell("light off")
    until("dark", lambda: chip.value("LAMP") == 0)
    assert levels == {count: count % 2 for count in levels}
    assert (light.do("outputs")["edges"] - before) % 2 == 0


# --- inputs -------------------------------------------------------------------------------------


def interrupts() -> int:
    """Of the light's inputs, that the kernel has handled."""
    rows = [row.split() for row in Path("/proc/interrupts").read_text().splitlines()]
    return sum(int(row[1]) for row in rows if row[-1] == "pharos")


def in_sync_mode(light: Light, *settings: str) -> None:
    light.shell(*settings, "light set mode sync", "light on")
    until("sync mode", lambda: light.do("outputs")["mode"] == 2)


def test_lamp_follows_external_sync(start: Start, chip: GpioSim) -> None:
    light = start(*options(chip, "enable=LAMP,sync=SYNC"))
    in_sync_mode(light)
    for _ in range(10):
        for level in (1, 0):
            chip.pull("SYNC", level)
            until(f"lamp at {level}", lambda: chip.value("LAMP") == level)  # noqa: B023
    assert light.do("gpiochip")["edges"] == 20
    assert light.do("outputs")["edges"] == 20


def test_sync_level_at_start_counts(start: Start, chip: GpioSim) -> None:
    chip.pull("SYNC", 1)
    light = start(*options(chip, "enable=LAMP,sync=SYNC"))
    in_sync_mode(light)
    until("lit", lambda: chip.value("LAMP") == 1)


def test_burst_beyond_the_kernels_queue_ends_at_the_right_level(
    start: Start, chip: GpioSim
) -> None:
    light = start(*options(chip, "enable=LAMP,sync=SYNC"))
    in_sync_mode(light)
    # Not for long: to the watchdog it is a processor that stands still.
    light.process.send_signal(signal.SIGSTOP)
    for number in range(17):
        before = interrupts()
        chip.pull("SYNC", (number + 1) % 2)
        # each by itself: gpio-sim's come with the guest's tick, and two that come together are one
        until("the interrupt", lambda: interrupts() > before)  # noqa: B023
    light.process.send_signal(signal.SIGCONT)
    until("lit", lambda: chip.value("LAMP") == 1)
    # the kernel keeps 16 edges of each line; libgpiod 1 loses the last, libgpiod 2 the first ones
    counts = light.do("gpiochip")
    assert counts["edges"] <= 16
    assert counts["missed"] >= 1
    chip.pull("SYNC", 0)
    until("dark", lambda: chip.value("LAMP") == 0)


def test_edges_count_at_the_kernels_time(start: Start, chip: GpioSim) -> None:
    """A pulse of 10 ms, of which the light hears when it has long been over, is no light."""
    light = start(*options(chip, "enable=LAMP,sync=SYNC"))
    settings = ("SYNC_MODE 1", "SYNC_PULSE 10000", "SYNC_FILT 0")
    in_sync_mode(light, *(f"param set {setting}" for setting in settings))

    def heard_late() -> int:
        """Edges of the lamp for a pulse that is heard of 50 ms late."""
        read, lit = light.do("gpiochip")["edges"], light.do("outputs")["edges"]
        light.process.send_signal(signal.SIGSTOP)
        chip.pull("SYNC", 1)
        pass_time(0.05)
        light.process.send_signal(signal.SIGCONT)
        until("the edge is read", lambda: light.do("gpiochip")["edges"] == read + 1)
        edges = int(light.do("outputs")["edges"] - lit)
        chip.pull("SYNC", 0)
        until("the end is read", lambda: light.do("gpiochip")["edges"] == read + 2)
        return edges

    def in_time() -> bool:
        """Whether the stop was short enough for the light's clock to go on: it leaves out more."""
        stops = light.do("host")["stops"]
        edges = heard_late()
        if light.do("host")["stops"] > stops:
            return False
        assert edges == 0
        return True

    until("a pulse heard of late", in_time)
    before = light.do("outputs")["edges"]
    chip.pull("SYNC", 1)
    until("a pulse told in time", lambda: light.do("outputs")["edges"] == before + 2)


def test_button_switches_the_light(start: Start, chip: GpioSim) -> None:
    light = start(*options(chip, "enable=LAMP,button=BUTTON"))
    assert light.line("button") == 1, "pulled up by the light"
    for level in (1, 0):
        chip.pull("BUTTON", 0)
        until(f"lamp at {level}", lambda: chip.value("LAMP") == level)  # noqa: B023
        chip.pull("BUTTON", 1)
        until("released", lambda: light.line("button") == 1)
        # the light's clock: a level counts once it has lasted 20 ms
        end_us = light.do("outputs")["now_us"] + 40_000
        until("the release counts", lambda: light.do("outputs")["now_us"] > end_us)  # noqa: B023
        assert chip.value("LAMP") == level


def test_driver_fault_is_logged_and_counted(start: Start, chip: GpioSim) -> None:
    light = start(*options(chip, "fault=FAULT"))
    assert light.line("driver_fault") == 1, "pulled up by the light"
    until("no fault yet", lambda: "ok, 0 faults" in light.status())
    chip.pull("FAULT", 0)
    until("a fault", lambda: "FAULT, 1 faults" in light.status())
    assert "the lamp's driver reports a fault" in light.console()
    chip.pull("FAULT", 1)
    until("no fault any more", lambda: "ok, 1 faults" in light.status())


# --- the end of the process -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "status"),
    [
        (signal.SIGKILL, -signal.SIGKILL),
        (signal.SIGSEGV, -signal.SIGSEGV),
        (signal.SIGTERM, 0),
        (signal.SIGHUP, -signal.SIGHUP),
    ],
)
@pytest.mark.parametrize("outside", ["pulled down", "pulled up before"])
def test_lamp_is_off_however_the_light_ends(
    start: Start, chip: GpioSim, number: signal.Signals, status: int, outside: str
) -> None:
    if outside == "pulled up before":
        chip.pull("LAMP", 1)  # the light asks for a pull-down of its own
    light = start(*options(chip, "enable=LAMP"))
    light.shell("light on")
    until("lit", lambda: chip.value("LAMP") == 1)
    assert light.signal(number) == status
    until("dark", lambda: chip.value("LAMP") == 0)


@pytest.fixture
def keeping_chip(chip: GpioSim) -> Iterator[KeepingChip]:
    made = KeepingChip(chip, "LAMP")
    yield made
    made.remove()


def test_chip_that_keeps_its_level_is_what_it_says(
    chip: GpioSim, keeping_chip: KeepingChip
) -> None:
    """Otherwise the next test would prove nothing."""
    high = gpiod.LineSettings(
        direction=gpiod.line.Direction.OUTPUT, output_value=gpiod.line.Value.ACTIVE
    )
    settings: Settings = {0: high}
    gpiod.request_lines(keeping_chip.device, settings).release()
    assert chip.value("LAMP") == 1


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV, signal.SIGHUP])
def test_lamp_is_off_on_a_chip_that_keeps_its_level(
    start: Start, chip: GpioSim, keeping_chip: KeepingChip, number: signal.Signals
) -> None:
    light = start("--gpio", f"gpiochip:{keeping_chip.device},enable=0", UNSAFE)
    light.shell("light on")
    until("lit", lambda: chip.value("LAMP") == 1)
    assert light.signal(number) == -number
    until("dark", lambda: chip.value("LAMP") == 0)


def test_light_takes_the_lines_of_a_killed_one(start: Start, chip: GpioSim) -> None:
    first = start(*options(chip, "enable=LAMP"))
    guard = until("a guard", first.guard)
    os.kill(guard, signal.SIGSTOP)
    first.signal(signal.SIGKILL)
    with gpiod.Chip(chip.device) as opened:
        assert opened.get_line_info("LAMP").used, "by the guard, still"
    ending = threading.Timer(0.2, os.kill, [guard, signal.SIGCONT])
    ending.start()
    second = start(*options(chip, "enable=LAMP"))
    ending.join()
    second.shell("light on")
    until("lit", lambda: chip.value("LAMP") == 1)


def test_killed_guard_is_replaced(start: Start, chip: GpioSim, keeping_chip: KeepingChip) -> None:
    light = start("--gpio", f"gpiochip:{keeping_chip.device},enable=0", UNSAFE)
    light.shell("light on")
    until("lit", lambda: chip.value("LAMP") == 1)
    for _ in range(2):
        first = until("a guard", light.guard)
        os.kill(first, signal.SIGKILL)
        until("another guard", lambda: light.guard() not in (0, first))  # noqa: B023
        assert chip.value("LAMP") == 1
    light.signal(signal.SIGKILL)
    until("dark", lambda: chip.value("LAMP") == 0)


def test_guard_ends_with_the_light_and_holds_no_pipe(start: Start, chip: GpioSim) -> None:
    light = start(*options(chip, "enable=LAMP"))
    guard = until("a guard", light.guard)
    open_files = [os.readlink(fd) for fd in Path(f"/proc/{guard}/fd").iterdir()]
    open_files.remove("anon_inode:[signalfd]")
    assert sorted(name.split("[")[0].split(":")[0] for name in open_files) == [
        "anon_inode",
        "pipe",
        "pipe",
    ]
    assert light.signal(signal.SIGTERM) == 0
    assert not Path(f"/proc/{guard}").exists()


def test_reset_makes_the_lamp_dark_and_takes_the_lines_again(start: Start, chip: GpioSim) -> None:
    light = start(*options(chip, "enable=LAMP,button=BUTTON"))
    light.shell("light on")
    until("lit", lambda: chip.value("LAMP") == 1)
    assert light.do("reset")["reset_cause"] == "pin"
    assert chip.value("LAMP") == 0
    chip.pull("BUTTON", 0)
    until("the button is read", lambda: light.line("button") == 0)
    until("one guard", lambda: len(light.guards()) == 1)
    light.shell("light on")
    until("lit again", lambda: chip.value("LAMP") == 1)


# --- a chip that goes away ------------------------------------------------------------------------


@pytest.mark.parametrize("uses", ["enable=LAMP", "enable=LAMP,sync=SYNC"])
def test_lost_chip_is_a_driver_fault_until_it_is_back(
    start: Start, chip: GpioSim, uses: str
) -> None:
    light = start(*options(chip, uses))
    light.shell("light on")
    until("lit", lambda: chip.value("LAMP") == 1)
    chip.unplug()
    until("the loss is seen", lambda: not light.do("gpiochip")["present"])
    until("a driver fault", lambda: "FAULT, 1 faults" in light.status())
    until("it is told", lambda: "is lost" in light.console())
    # it goes on, also with commands
    light.shell("light off", "light on")
    until("on", lambda: light.do("outputs")["enable"] == 1)
    chip.plug()
    until("it is found again", lambda: light.do("gpiochip")["present"])
    until("lit", lambda: chip.value("LAMP") == 1)
    until("no driver fault", lambda: "ok, 1 faults" in light.status())
    until("it is told", lambda: "is back" in light.console())
    assert light.do("gpiochip")["losses"] == 1
    assert (light.console().count("is lost"), light.console().count("is back")) == (1, 1)
    assert light.signal(signal.SIGTERM) == 0


# --- at start -------------------------------------------------------------------------------------


def test_wrong_names_are_one_line(binary: Path, chip: GpioSim) -> None:
    assert refusal(binary, *options(chip, "enable=LAMB")) == (
        f'pharos: --gpio: {chip.device} has no line "LAMB"; its lines are 0 to 5 and their names'
    )
    assert 'has no line "6"' in refusal(binary, *options(chip, "enable=6"))
    assert "same line" in refusal(binary, *options(chip, "enable=LAMP,sync=0"))
    assert refusal(binary, "--gpio", "gpiochip:/dev/gpiochip99,enable=0") == (
        "pharos: --gpio: /dev/gpiochip99: No such file or directory"
    )


def test_busy_line_is_one_line_with_its_user(binary: Path, chip: GpioSim) -> None:
    settings: Settings = {"LAMP": gpiod.LineSettings(direction=gpiod.line.Direction.OUTPUT)}
    with gpiod.request_lines(chip.device, consumer="somebody", config=settings):
        assert refusal(binary, *options(chip, "sync=SYNC,enable=LAMP")) == (
            f"pharos: --gpio: enable: line LAMP of {chip.device} is in use by somebody"
        )


def test_each_back_end_says_which_it_is(start: Start, chip: GpioSim, binary: Path) -> None:
    debians = subprocess.run(
        ["pkg-config", "--modversion", "libgpiod"], capture_output=True, text=True, check=True
    ).stdout
    major = 2 if binary.parent.name == "light2" else int(debians.partition(".")[0])
    assert start(*options(chip, "enable=LAMP")).do("gpiochip")["backend"] == f"libgpiod v{major}"
