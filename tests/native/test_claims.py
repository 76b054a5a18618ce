# SPDX-License-Identifier: Apache-2.0
"""What two lights may not have at once, and what a host runs out of."""

from __future__ import annotations

import os
import resource
import socket
import subprocess
import time
from pathlib import Path

import pytest

from echo_light import PATIENCE_S, Light, Start, wait_until

BUSY = "another light has it"


def _second(light: Light, *options: str) -> subprocess.CompletedProcess[str]:
    """One more light, which is expected to end by itself."""
    return subprocess.run(
        [light.command[0], "--console", "none", *options],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )


def test_a_control_socket_is_not_taken_from_a_light(start: Start) -> None:
    light = start()
    second = _second(light, "--control", str(light.path))
    assert second.returncode == 1
    assert second.stderr.endswith(f"pharos: --control: {light.path}: {BUSY}\n")
    light.do("reset")
    assert BUSY in _second(light, "--control", str(light.path)).stderr
    # By another way to the same folder.
    (light.folder / "way").symlink_to(light.folder)
    assert BUSY in _second(light, "--control", str(light.folder / "way/control")).stderr
    light.connect().close()


def test_what_a_killed_light_left_is_replaced(start: Start) -> None:
    light = start()
    light.process.kill()
    light.process.wait()
    assert light.path.is_socket()
    again = Light(Path(light.command[0]), light.folder)
    assert again.quit() == 0
    again.close()
    assert not light.path.exists()


def test_the_end_leaves_another_lights_socket(start: Start, tmp_path: Path) -> None:
    light = start()
    light.path.rename(tmp_path / "moved")
    with socket.socket(socket.AF_UNIX) as other:
        other.bind(str(light.path))
        assert light.quit() == 0
        assert light.path.is_socket()


@pytest.mark.parametrize("option", ["settings", "flash", "record", "trace"])
def test_a_file_is_one_lights(start: Start, tmp_path: Path, option: str) -> None:
    path = tmp_path / "file"
    light = start(f"--{option}", str(path))
    for _ in range(2):
        second = _second(light, f"--{option}", str(path), "--time", "virtual", "--until", "1ms")
        assert second.returncode == 1
        assert second.stderr.endswith(f"pharos: --{option}: {path}: {BUSY}\n")
        light.do("reset")
    light.quit()
    third = _second(light, f"--{option}", str(path), "--time", "virtual", "--until", "1ms")
    assert third.returncode == 0, third.stderr


@pytest.mark.parametrize("option", ["settings", "flash", "record", "trace", "control"])
def test_a_file_that_cannot_be_had_is_one_line(start: Start, tmp_path: Path, option: str) -> None:
    path = tmp_path / "nowhere" / "file"
    refused = _second(start(), f"--{option}", str(path))
    assert refused.returncode == 1
    assert refused.stderr.endswith(f"pharos: --{option}: {path}: No such file or directory\n")
    assert refused.stderr.count("pharos: --") == 1


def test_a_link_to_a_terminal_is_one_lights(start: Start, tmp_path: Path) -> None:
    link = tmp_path / "uart0"
    first = start("--uart0", f"pty:{link}", virtual=False)
    target = link.readlink()
    second = start("--uart0", f"pty:{link}", virtual=False)
    wait_until(lambda: "Address already in use" in second.stderr.read_text(), "why")
    assert link.readlink() == target
    second.quit()
    assert link.readlink() == target
    first.quit()
    assert not link.is_symlink()


# --- what runs out --------------------------------------------------------------------------------


def _processor_s(light: Light) -> float:
    fields = Path(f"/proc/{light.process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_no_descriptors_left_is_told_and_does_not_spin(start: Start) -> None:
    light = start(virtual=False)
    pid = light.process.pid
    used = 1 + max(int(path.name) for path in Path(f"/proc/{pid}/fd").iterdir())
    limits = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (used, limits[1]))
    with socket.socket(socket.AF_UNIX) as waiting:
        waiting.connect(str(light.path))
        wait_until(lambda: "Too many open files" in light.stderr.read_text(), "a line")
        before, end = _processor_s(light), time.monotonic() + 1.5
        wait_until(lambda: time.monotonic() > end, "the next try")
        assert _processor_s(light) - before < 0.5
        assert light.stderr.read_text().count("Too many open files") == 1
        resource.prlimit(pid, resource.RLIMIT_NOFILE, limits)
        waiting.settimeout(PATIENCE_S)
        waiting.sendall(b'{"op":"hello"}\n')
        assert b'"ok":true' in waiting.recv(1000)


def test_a_file_that_may_not_grow_ends_the_recording_only(start: Start, tmp_path: Path) -> None:
    trace = tmp_path / "trace"
    light = start("--trace", str(trace))
    resource.prlimit(light.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
    light.advance(3_600_000_000)
    assert f"{trace}: File too large; the trace ends here" in light.stderr.read_text()
    assert trace.stat().st_size == 4096
    light.advance(1_000_000)
