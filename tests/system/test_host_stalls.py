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


def test_a_pwm_whose_bus_hangs_stops_nothing_and_is_a_fault_of_the_lamp(
    real: Start, tmp_path: Path
) -> None:
    sysfs = FakeSysfs(tmp_path / "sys")
    (lamp,) = sysfs.pwmchip(0, channels=1)
    sysfs.hwmon(0, "lm75", temp1_input=25000)
    hangs = tmp_path / "hangs"
    env = {
        **os.environ,
        "LD_PRELOAD": str(BINARY.parent / "tests/native/libslow_bus.so"),
        "SLOW_BUS": str(hangs),
        "ASAN_OPTIONS": "verify_asan_link_order=0",
    }
    words = ("--light", "pwm:0/0", "--thermistor", "hwmon:lm75/temp1")
    light = real("--sysfs", str(sysfs.root), *words, env=env)

    def pwm() -> dict[str, Any]:
        return dict(light.control.request("pwm")["outputs"]["light"])

    _press(light, lit=True)
    light.until("a duty", lambda: FakeSysfs.get(lamp, "duty_cycle") == "500000")
    hangs.touch()
    _press(light, lit=False)
    assert FakeSysfs.get(lamp, "duty_cycle") == "500000"
    light.until("a fault", lambda: not pwm()["present"])
    assert light.said("light: 0/0 is lost: Connection timed out")
    light.run_for(2_500_000)  # longer than every limit of supervision
    assert light.outputs()["resets"] == 0
    assert light.outputs()["measured_mdegc"] == 25000
    hangs.unlink()
    light.until("the dark that was wanted", lambda: FakeSysfs.get(lamp, "duty_cycle") == "0")
    light.until("all well", lambda: pwm()["present"])
    light.run_for(300_000)  # the limit, which comes ten times a second, finds that out
    _press(light, lit=True)
    light.until("a duty", lambda: FakeSysfs.get(lamp, "duty_cycle") == "500000")
    assert pwm()["losses"] == 1
