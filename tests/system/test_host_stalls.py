# SPDX-License-Identifier: Apache-2.0
"""A host that is slow or stands still is not the light's trouble: real time, whatever the load."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import select
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from fake_sysfs import FakeSysfs
from harness import BINARY
from pharos.control import ControlClient

pytestmark = pytest.mark.realtime

PATIENCE_S = 60.0
# The lamp's full power, as `outputs` has it.
FULL_PPM = 1_000_000


class RealLight:
    """The light in real time. Its lamp is switched with its button."""

    def __init__(self, folder: Path, *options: str, **how: Any) -> None:
        self.path = folder / "control"
        self.stderr = folder / "stderr"
        self.process = subprocess.Popen(
            [str(BINARY), "--control", str(self.path), "--console", "none", *options],
            **{"stdin": subprocess.DEVNULL, "stderr": self.stderr.open("ab"), **how},
        )
        self.control = self._connect()

    def _connect(self) -> ControlClient:
        deadline = time.monotonic() + PATIENCE_S
        while True:
            assert self.process.poll() is None, self.stderr.read_text()
            try:
                return ControlClient(str(self.path))
            except OSError:
                assert time.monotonic() < deadline, "the light opened no control socket"

    def outputs(self, **fields: Any) -> dict[str, Any]:
        return self.control.request("outputs", **fields)

    def now_us(self) -> int:
        return int(self.control.request("hello")["now_us"])

    def host(self) -> tuple[int, dict[str, Any], int]:
        """The operation `host`, and the host's clock before and after it in us."""
        asked = time.monotonic_ns() // 1000
        reply = self.control.request("host")
        return asked, reply, time.monotonic_ns() // 1000 + 1

    def until(self, what: str, condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            late = time.monotonic() >= deadline
            assert not late, f"never came: {what}\n{self.outputs()}\n{self.stderr.read_text()}"
            select.select([], [], [], 0.005)

    def run_for(self, us: int) -> None:
        """Board time goes on by this much."""
        end_us = self.now_us() + us
        self.until("board time", lambda: self.now_us() >= end_us)

    def switch_on(self) -> None:
        """At full power; from here on `peak_ppm` is that of the light asked for. The button is held
        until then: a process that gets no processor for as long as a pulse lasts sees none."""
        self.control.request("gpio", line="button", value=0)
        self.until("light", lambda: self.outputs()["level_ppm"] == FULL_PPM)
        self.control.request("gpio", line="button", value=1)
        self.outputs(reset=True)

    def stop(self, seconds: float) -> None:
        self.process.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        self.process.send_signal(signal.SIGCONT)

    def check_untouched(self) -> None:
        """It goes on as if nothing had been: the same boot, a sensor that works, and light."""
        now = self.outputs()
        assert (now["resets"], now["thermal_state"]) == (0, 0)
        assert now["level_ppm"] == now["peak_ppm"] == now["limit_ppm"] == FULL_PPM

    def said(self, text: str) -> list[str]:
        return [line for line in self.stderr.read_text().splitlines() if text in line]

    def close(self) -> None:
        self.control.close()
        self.process.kill()
        self.process.wait()


Start = Callable[..., RealLight]


@pytest.fixture
def real(tmp_path: Path) -> Iterator[Start]:
    with ExitStack() as stack:

        def start(*options: str, **how: Any) -> RealLight:
            light = RealLight(tmp_path, *options, **how)
            stack.callback(light.close)
            return light

        yield start


# --- a host that stands still ---------------------------------------------------------------------


@pytest.mark.parametrize("seconds", [1.5, 5.0])
def test_a_stop_is_told_in_one_line_and_bites_nothing(real: Start, seconds: float) -> None:
    light = real()
    light.switch_on()
    before = light.control.request("host")
    light.stop(seconds)
    light.until("a line", lambda: bool(light.said("host stood still")))
    light.run_for(1_500_000)  # longer than every limit of supervision
    light.check_untouched()
    stopped_us = light.control.request("host")["stopped_us"] - before["stopped_us"]
    assert stopped_us >= seconds * 1e6 - 250_000
    told = [float(line.split()[-2]) for line in light.said("host stood still for")]
    assert any(length >= seconds - 0.25 for length in told)


def test_board_time_leaves_a_stop_out_and_makes_up_for_it(real: Start) -> None:
    light = real()
    asked, before, answered = light.host()
    light.stop(1.5)
    asked_again, after, answered_again = light.host()
    assert after["behind_us"] >= before["behind_us"] + 1_250_000
    # What is behind is all that it lacks of the host's time.
    passed_us = sum(after[key] - before[key] for key in ("now_us", "behind_us"))
    assert asked_again - answered <= passed_us <= answered_again - asked + 1


def test_heat_during_a_stop_is_seen_at_once_after_it(real: Start) -> None:
    light = real()
    light.switch_on()
    light.control.request("set", temp_mdegc=120_000)
    light.stop(1.5)
    light.until("dark", lambda: light.outputs()["level_ppm"] == 0)
    assert light.outputs()["resets"] == 0


def test_a_thread_that_really_stalls_still_bites(real: Start) -> None:
    light = real()
    light.switch_on()
    light.control.request("fault", device="thread", kind="stalled", name="thermal")
    light.until("a reset", lambda: light.outputs()["resets"] == 1)
    now = light.outputs()
    assert (now["reset_cause"], now["level_ppm"]) == ("watchdog", 0)


# --- standard error and output that nobody reads --------------------------------------------------


def _fill(writer: int) -> None:
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
    os.write(writer, b"x" * 4096)


def test_a_full_stderr_stops_nothing(real: Start) -> None:
    reader, writer = os.pipe()
    _fill(writer)
    light = real(stderr=writer)
    os.close(writer)
    light.switch_on()
    light.control.request("fault", device="thermistor", kind="open")
    light.until("a safe level", lambda: 0 < light.outputs()["level_ppm"] < FULL_PPM)
    light.outputs(reset=True)
    light.run_for(1_500_000)
    now = light.outputs()
    assert (now["resets"], now["peak_ppm"]) == (0, now["limit_ppm"])
    assert light.control.request("quit")["ok"]
    assert light.process.wait(PATIENCE_S) == 0
    os.close(reader)


def test_an_unread_terminal_stops_nothing(real: Start) -> None:
    """A shell that prints more than the terminal takes, as after Ctrl-S."""
    master, slave = pty.openpty()
    light = real("--console", "stdio", stdin=slave, stdout=slave, stderr=slave)
    os.close(slave)
    light.switch_on()
    os.set_blocking(master, False)
    for _ in range(2000):  # each answer is longer than a thousandth of what a terminal keeps
        with contextlib.suppress(BlockingIOError):
            os.write(master, b"help\n")
        light.now_us()
    light.run_for(1_500_000)
    light.check_untouched()
    os.close(master)


# --- a slow disk ----------------------------------------------------------------------------------

DISK_S = 3.0


@pytest.fixture
def slow(real: Start, tmp_path: Path) -> Start:
    """A light whose settings lie on a disk that takes DISK_S for each write."""

    def start(*options: str) -> RealLight:
        preload = BINARY.parent / "tests/native/libslow_disk.so"
        env = {
            **os.environ,
            "LD_PRELOAD": str(preload),
            "SLOW_DISK_MS": str(int(DISK_S * 1000)),
            "SLOW_DISK_LOG": str(tmp_path / "disk_log"),
            "ASAN_OPTIONS": "verify_asan_link_order=0",
        }
        console = ("--console", "stdio")
        return real(
            "--settings", str(tmp_path / "settings"), *console, *options,
            env=env, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
        )  # fmt: skip

    return start


def _store(light: RealLight) -> None:
    """Sets a parameter; its write is under way."""
    assert light.process.stdin is not None
    light.process.stdin.write(b"param set LGT_SRC_HOLD 7\n")
    light.process.stdin.flush()
    light.until("a write", lambda: _is_writing(light))


def _disk_log(light: RealLight) -> list[str]:
    log = light.path.parent / "disk_log"
    return log.read_text().split() if log.exists() else []


def _is_writing(light: RealLight) -> bool:
    return _disk_log(light)[-1:] == ["begin"]


def test_a_slow_disk_stops_nothing(slow: Start, tmp_path: Path) -> None:
    light = slow("--record", str(tmp_path / "record.vcd"), "--trace", str(tmp_path / "trace"))
    light.switch_on()
    _store(light)
    light.run_for(300_000)
    assert _is_writing(light)  # it went on meanwhile
    light.run_for(int(DISK_S * 1e6))
    light.until("the end of the write", lambda: not _is_writing(light))
    light.check_untouched()
    assert light.control.request("quit")["ok"]
    assert light.process.wait(PATIENCE_S) == 0


def test_an_end_waits_for_a_write_that_was_begun(slow: Start) -> None:
    light = slow()
    light.switch_on()
    _store(light)
    assert light.control.request("quit")["ok"]
    assert light.process.wait(PATIENCE_S) == 0
    assert not _is_writing(light)


def test_a_reset_waits_for_a_write_that_was_begun(slow: Start) -> None:
    light = slow()
    light.switch_on()
    _store(light)
    light.control.request("reset")
    assert not _is_writing(light)
    assert light.outputs()["resets"] == 1


# --- a bus that hangs -----------------------------------------------------------------------------


def _press(light: RealLight, lit: bool) -> None:
    """The button is held until the lamp follows."""
    light.control.request("gpio", line="button", value=0)
    light.until("the button", lambda: (light.outputs()["level_ppm"] > 0) == lit)
    light.control.request("gpio", line="button", value=1)
    light.run_for(100_000)  # longer than a level must last to count


class Bus:
    """A PWM chip and a temperature sensor, of plain files, on a bus that can hang."""

    def __init__(self, folder: Path, start: Start) -> None:
        self._folder = folder
        self._start = start
        self.sysfs = FakeSysfs(folder / "sys")
        self.lamp, self.other = self.sysfs.pwmchip(0, channels=2)
        self.sysfs.hwmon(0, "lm75", temp1_input=25000)
        self.hangs, self.fails, self.no_fork, self._log = (
            folder / name for name in ("hangs", "fails", "no_fork", "bus_log")
        )

    def light(self, *options: str, **how: Any) -> RealLight:
        env = {
            **os.environ,
            "LD_PRELOAD": str(BINARY.parent / "tests/native/libslow_bus.so"),
            "SLOW_BUS": str(self.hangs),
            "SLOW_BUS_FAILS": str(self.fails),
            "SLOW_BUS_LOG": str(self._log),
            "NO_FORK": str(self.no_fork),
            "ASAN_OPTIONS": "verify_asan_link_order=0",
        }
        words = ("--light", "pwm:0/0", "--thermistor", "hwmon:lm75/temp1")
        return self._start("--sysfs", str(self.sysfs.root), *words, *options, env=env, **how)

    def duty(self) -> str:
        return FakeSysfs.get(self.lamp, "duty_cycle")

    def writes(self, attribute: str = "duty_cycle") -> list[tuple[int, int]]:
        """When, in us, and what; -1: it failed."""
        words = [line.split() for line in self._log.read_text().splitlines()]
        return [(int(at_us), int(value)) for at_us, name, value in words if name == attribute]


@pytest.fixture
def bus(real: Start, tmp_path: Path) -> Bus:
    return Bus(tmp_path, real)


def _pwm(light: RealLight, name: str = "light") -> dict[str, Any]:
    return dict(light.control.request("pwm")["outputs"][name])


def _guards(light: RealLight) -> list[int]:
    """The process ids of those that run."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            pid, name, state, parent, *_ = stat.read_text().split()
            if (name, int(parent)) == ("(pharos-guard)", light.process.pid) and state != "Z":
                found.append(int(pid))
    return found


# The output that is away is looked for after this time; what is to be at once is sooner.
LOOKED_FOR_S = 0.9


def test_a_pwm_whose_bus_hangs_stops_nothing_and_is_a_fault_of_the_lamp(bus: Bus) -> None:
    light = bus.light()
    _press(light, lit=True)
    light.until("a duty", lambda: bus.duty() == "500000")
    bus.hangs.touch()
    _press(light, lit=False)
    assert bus.duty() == "500000"
    light.until("a fault", lambda: not _pwm(light)["present"])
    assert light.said("light: 0/0 is lost: Connection timed out")
    light.run_for(2_500_000)  # longer than every limit of supervision
    assert light.outputs()["resets"] == 0
    assert light.outputs()["measured_mdegc"] == 25000
    bus.hangs.unlink()
    light.until("the dark that was wanted", lambda: bus.duty() == "0")
    light.until("all well", lambda: _pwm(light)["present"])
    light.run_for(300_000)  # the limit, which comes ten times a second, finds that out
    _press(light, lit=True)
    light.until("a duty", lambda: bus.duty() == "500000")
    assert _pwm(light)["losses"] == 1


@pytest.mark.parametrize(
    ("before", "switched"), [("normal", [1, 1, 0]), ("inversed", [0, 1, 1, 0])]
)
def test_an_output_that_runs_is_only_switched_off_for_its_polarity(
    bus: Bus, before: str, switched: list[int]
) -> None:
    """Nobody promises the level of one that is off."""
    for name, value in ("period", 500_000), ("duty_cycle", 0), ("enable", 1), ("polarity", before):
        bus.sysfs.set(bus.lamp, name, value)
    light = bus.light()
    light.control.request("reset")
    light.until("a reset", lambda: light.outputs()["resets"] == 1)
    assert light.control.request("quit")["ok"]
    assert light.process.wait(PATIENCE_S) == 0
    assert [value for _, value in bus.writes("enable")] == switched


def test_light_that_is_written_after_the_lamp_was_given_up_goes_out_at_once(bus: Bus) -> None:
    light = bus.light()
    bus.hangs.touch()
    _press(light, lit=True)
    light.until("a fault", lambda: not _pwm(light)["present"])
    bus.hangs.unlink()
    light.until("all well", lambda: _pwm(light)["present"])
    writes = bus.writes()
    lit = next(i for i, (_, duty_ns) in enumerate(writes) if duty_ns > 0)
    assert writes[lit + 1][1] == 0
    assert writes[lit + 1][0] - writes[lit][0] < LOOKED_FOR_S * 1e6


def test_dark_that_fails_to_be_written_is_written_again_at_once(bus: Bus) -> None:
    light = bus.light()
    _press(light, lit=True)
    light.until("a duty", lambda: bus.duty() == "500000")
    bus.fails.touch()
    _press(light, lit=False)
    light.until("dark", lambda: bus.duty() == "0")
    assert light.said("light: 0/0 is lost: Remote I/O error")
    writes = bus.writes()
    failed = next(i for i, (_, duty_ns) in enumerate(writes) if duty_ns < 0)
    assert writes[failed + 1][1] == 0
    assert writes[failed + 1][0] - writes[failed][0] < LOOKED_FOR_S * 1e6


def test_an_output_gives_what_it_was_told_to_while_it_was_away(bus: Bus) -> None:
    console = {"stdin": subprocess.PIPE, "stdout": subprocess.DEVNULL}
    light = bus.light("--console", "stdio", "--servo-pan", "pwm:0/1", **console)

    def turn(degrees: int) -> str:
        """The pulse that the servo is told then."""
        assert light.process.stdin is not None
        light.process.stdin.write(f"gimbal pan {degrees}\n".encode())
        light.process.stdin.flush()
        light.run_for(3_000_000)  # from end to end
        return str(light.outputs()["servos"]["pan"]["pulse_ns"])

    first = turn(45)
    light.until("turned", lambda: FakeSysfs.get(bus.other, "duty_cycle") == first)
    bus.hangs.touch()
    light.until("a fault", lambda: (turn(30), not _pwm(light, "servo-pan")["present"])[1])
    second = turn(-45)
    assert int(second) < 1_500_000 < int(first)  # of the middle
    before = len(bus.writes())
    bus.hangs.unlink()
    light.until("all well", lambda: _pwm(light, "servo-pan")["present"])
    light.until("turned", lambda: FakeSysfs.get(bus.other, "duty_cycle") == second)
    pulses = [duty_ns for _, duty_ns in bus.writes()[before:] if duty_ns > 0]
    assert len(pulses) == 2, "the one that hung, and what was wanted last"
    assert pulses[1] == int(second)


def test_a_servo_that_is_away_at_a_reset_is_taken_when_it_comes(bus: Bus, tmp_path: Path) -> None:
    bus.sysfs.pwmchip(1)
    light = bus.light("--servo-pan", "pwm:1/0")
    chip = bus.sysfs.root / "class/pwm/pwmchip1"
    chip.rename(tmp_path / "unplugged")
    light.control.request("reset")
    light.until("a reset", lambda: light.outputs()["resets"] == 1)
    assert not _pwm(light, "servo-pan")["present"]
    (tmp_path / "unplugged").rename(chip)
    light.until("another", lambda: light.outputs()["resets"] == 2)
    assert _pwm(light, "servo-pan")["present"]
    light.until("its pulse", lambda: FakeSysfs.get(chip / "pwm0", "duty_cycle") == "1500000")


# --- the guard ------------------------------------------------------------------------------------


def test_the_guard_acts_though_a_thread_of_the_dead_process_lasts(bus: Bus) -> None:
    """As one that is in a transfer of the kernel's: its descriptors stay open."""
    light = bus.light()
    _press(light, lit=True)
    light.until("a duty", lambda: bus.duty() == "500000")
    light.until("a guard", lambda: len(_guards(light)) == 1)
    held = []
    for fd in Path(f"/proc/{light.process.pid}/fd").iterdir():
        if os.readlink(fd).startswith("pipe:"):
            held.append(os.open(fd, os.O_WRONLY | os.O_NONBLOCK))
    assert held
    light.process.kill()
    light.process.wait()
    light.until("dark", lambda: bus.duty() == "0")
    for writer in held:
        os.close(writer)


def test_the_guard_does_not_act_at_a_signal_of_others(bus: Bus) -> None:
    light = bus.light()
    _press(light, lit=True)
    light.until("a duty", lambda: bus.duty() == "500000")
    light.until("a guard", lambda: len(_guards(light)) == 1)
    (guard,) = _guards(light)
    for number in (signal.SIGUSR1, signal.SIGTERM, signal.SIGINT):
        os.kill(guard, number)
    light.run_for(500_000)
    assert (_guards(light), bus.duty()) == ([guard], "500000")


def test_the_guard_before_goes_on_where_there_are_no_more_processes(bus: Bus) -> None:
    light = bus.light()
    light.until("a guard", lambda: len(_guards(light)) == 1)
    (guard,) = _guards(light)
    bus.no_fork.touch()
    bus.fails.touch()
    _press(light, lit=True)  # fails, and is opened anew: for that there is a new guard
    light.until("a line", lambda: bool(light.said("no new process to guard the outputs")))
    assert light.said("no new process to guard the outputs: Resource temporarily unavailable")
    assert _guards(light) == [guard]
    bus.no_fork.unlink()
    light.until("a new one", lambda: len(_guards(light)) == 1 and _guards(light) != [guard])
