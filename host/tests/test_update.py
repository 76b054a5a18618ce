# SPDX-License-Identifier: Apache-2.0
"""New firmware: three nodes at once over DroneCAN, and MAVLink FTP over a bad line. Images are made
here as MCUboot has them; the lights are native ones with both slots, in virtual time."""

from __future__ import annotations

import hashlib
import io
import json
import struct
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pharos import CommandError, Light, PharosError, SilentError, Simulator, UsageError
from pharos.can_node import DronecanNode
from pharos.cli import main
from pharos.cli import update as cli_update
from pharos.cli.shell import Printer
from pharos.cli.update import Shown, node_urls
from pharos.ftp import FileClient, FileError
from pharos.update import (
    FIRMWARE,
    NodeUpdater,
    UpdatePhase,
    UpdateProgress,
    read_image,
    update_light,
    update_nodes,
    version_of,
)
from real_light import RealLight

SLOT = 229_376  # native.dts
CAN = "udp:127.255.255.255:{port}"
NODE = 68


def image_of(size: int, *, spoilt: bool = False) -> bytes:
    """Header, code, and an area with the SHA-256 of both (MCUboot design, "Image format")."""
    code = bytes(at * 7 % 251 for at in range(size))
    header = struct.pack("<IIHHIIBBHI", 0x96F3B83D, 0, 512, 0, size, 0, 1, 2, 3, 4).ljust(
        512, b"\0"
    )
    area = struct.pack("<HHHH", 0x6907, 40, 0x10, 32) + hashlib.sha256(header + code).digest()
    if spoilt:
        code = bytes([code[0] ^ 1]) + code[1:]
    return header + code + area


def slot_of(path: Path, number: int) -> bytes:
    inverted = path.read_bytes()[number * SLOT :][:SLOT]
    return bytes(byte ^ 0xFF for byte in inverted)


# --- MAVLink FTP ----------------------------------------------------------------------------------
class Bench:
    def __init__(self, binary: Path, stack: ExitStack, folder: Path) -> None:
        self.flash = folder / "flash"
        self.sim = stack.enter_context(
            Simulator(
                binary,
                {"uart0": "udpin:127.0.0.1:0", "can0": CAN},
                options=("--flash", str(self.flash)),
            )
        )
        self.light = Light(self.sim.connect("uart0"))
        self.light.find()
        self.sim.advance(s=12)
        self.seen: list[UpdateProgress] = []

    def note(self, progress: UpdateProgress) -> None:
        self.seen.append(UpdateProgress(progress.device, progress.phase, progress.percent))

    def runs(self, image: bytes) -> bool:
        return slot_of(self.flash, 0)[: len(image)] == image

    def has_nothing(self) -> bool:
        return slot_of(self.flash, 1) == b"\xff" * SLOT


@pytest.fixture
def bench(binary: Path, tmp_path: Path) -> Iterator[Bench]:
    with ExitStack() as stack:
        yield Bench(binary, stack, tmp_path)


def test_an_image_is_written_verified_started_and_watched(bench: Bench) -> None:
    image = image_of(20_000)
    done = update_light(bench.light, image, bench.note)
    assert bench.runs(image)
    assert (done.phase, done.text) == (UpdatePhase.DONE, "version 0.1.0 before, 0.1.0 now")
    phases = list(dict.fromkeys(entry.phase for entry in bench.seen))
    assert phases == list(UpdatePhase)[:6]
    percents = [entry.percent for entry in bench.seen]
    assert percents == sorted(percents)
    bench.sim.reset()
    assert bench.runs(image), "it had confirmed itself"


def test_with_one_frame_in_twenty_lost_each_way(bench: Bench) -> None:
    # 5 % of frames of 273 bytes: 1 − 0.95 ** (1 / 273) of bytes.
    bench.sim.fault("uart0", "lost", rate_ppm=188)
    image = image_of(20_000)
    update_light(bench.light, image)
    assert bench.runs(image)


class Away:
    """Lets time pass, with nothing coming or going while it is away."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench

    def for_s(self, seconds: int) -> None:
        self.bench.sim.fault("uart0", "lost", rate_ppm=1_000_000)
        self.bench.sim.advance(s=seconds)
        self.bench.light.poll()
        self.bench.sim.fault("uart0", "none")


def test_a_link_that_was_lost_goes_on_where_it_was(bench: Bench) -> None:
    image, away = image_of(20_000), Away(bench)
    parts: list[int] = []

    def on_part(at: int, _of: int) -> None:
        if not parts or parts[-1] < 10_000 <= at:
            away.for_s(20)
        parts.append(at)

    FileClient(bench.light, 30_000_000).write(FIRMWARE, image, on_part)
    assert parts == sorted(set(parts)), "nothing came twice"


def test_the_next_run_goes_on_where_the_last_was_stopped(bench: Bench) -> None:
    image = image_of(20_000)
    parts: list[int] = []

    def stop(at: int, _of: int) -> None:
        if at > 10_000:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        FileClient(bench.light).write(FIRMWARE, image, stop)
    bench.sim.advance(s=20)
    FileClient(bench.light).write(FIRMWARE, image, lambda at, _of: parts.append(at))
    assert parts[0] > 10_000


def test_another_image_is_no_continuation(bench: Bench) -> None:
    parts: list[int] = []

    def stop(at: int, _of: int) -> None:
        if at > 10_000:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        FileClient(bench.light).write(FIRMWARE, image_of(20_000), stop)
    other = image_of(19_000)
    FileClient(bench.light).write(FIRMWARE, other, lambda at, _of: parts.append(at))
    assert parts[0] < 300
    bench.sim.reset()
    assert bench.runs(other)


def test_what_is_stopped_leaves_nothing(bench: Bench) -> None:
    def stop(at: int, _of: int) -> None:
        if at > 10_000:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        FileClient(bench.light).write(FIRMWARE, image_of(20_000), stop)
    bench.sim.advance(s=59)
    assert not bench.has_nothing()
    bench.sim.advance(s=2)
    assert bench.has_nothing()
    bench.sim.reset()
    bench.sim.advance(s=1)
    assert bench.sim.outputs()["resets"] == 1


def test_a_light_that_restarts_on_the_way_is_written_to_again(bench: Bench) -> None:
    image = image_of(20_000)
    resets: list[int] = []

    def on_part(at: int, _of: int) -> None:
        if at > 10_000 and not resets:
            resets.append(at)
            bench.sim.reset()

    FileClient(bench.light, 10_000_000).write(FIRMWARE, image, on_part)
    bench.sim.reset()
    assert bench.runs(image)


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        (image_of(3_000, spoilt=True), "does not have its SHA-256"),
        (image_of(3_000)[:-1], "ends too early"),
        (image_of(3_000) + b"\0", "data after the end"),
        (image_of(SLOT), "too large"),
    ],
)
def test_an_image_that_will_not_do_is_refused_with_the_reason(
    bench: Bench, image: bytes, reason: str
) -> None:
    with pytest.raises(PharosError, match=f"refuses the image: .*{reason}"):
        update_light(bench.light, image)
    bench.sim.advance(s=1)
    assert bench.has_nothing()
    assert bench.sim.outputs()["resets"] == 0


def test_a_lamp_that_is_on_is_not_restarted(bench: Bench) -> None:
    bench.light.on()
    with pytest.raises(CommandError, match="lamp is on"):
        update_light(bench.light, image_of(700))
    update_light(bench.light, image_of(700), force=True)
    assert bench.runs(image_of(700))
    assert bench.sim.outputs()["level_ppm"] == 0


def test_firmware_that_resets_itself_is_told_of(bench: Bench) -> None:
    def on_progress(progress: UpdateProgress) -> None:
        if progress.phase is UpdatePhase.TRIAL:
            bench.sim.advance(s=3)
            bench.sim.reset()

    with pytest.raises(PharosError, match="reset itself"):
        update_light(bench.light, image_of(700), on_progress)


def test_a_light_that_is_lost_is_told_of_in_time(bench: Bench) -> None:
    def on_progress(progress: UpdateProgress) -> None:
        if progress.percent > 50:
            bench.sim.fault("uart0", "lost", rate_ppm=1_000_000)

    start = bench.sim.now_us()
    with pytest.raises(SilentError, match="does not answer"):
        update_light(bench.light, image_of(20_000), on_progress, patience_us=5_000_000)
    assert bench.sim.now_us() - start < 10_000_000


def test_two_ways_do_not_meet(bench: Bench) -> None:
    node = bench.sim.node(100)
    updater = NodeUpdater(node, image_of(20_000), [NODE])
    while updater.progress[0].percent < 20:
        updater.step()
        bench.sim.pump(50_000)
    with pytest.raises(FileError, match="too many"):
        FileClient(bench.light, 1_000_000).write(FIRMWARE, image_of(700))
    assert update_nodes(updater, bench.sim)[0].phase is UpdatePhase.DONE


# --- DroneCAN -------------------------------------------------------------------------------------
class Joined:
    """A node of ours on the buses of several lights at once; the lights do not hear each other."""

    def __init__(self, sims: list[Simulator]) -> None:
        self.sims = sims
        self.ports = [sim.bus() for sim in sims]
        self.cut: set[int] = set()
        self.nodes: list[DronecanNode] = []
        self.node = DronecanNode(self, self.now_us, 100)  # type: ignore[arg-type]
        for index, port in enumerate(self.ports):
            port.listeners.append(partial(self._hear, index))

    def _hear(self, index: int, frame: Any) -> None:
        if index not in self.cut:
            self.node.receive(frame.arbitration_id, bytes(frame.data), frame.is_fd)

    def send(self, identifier: int, data: bytes, fd: bool) -> None:
        for index, port in enumerate(self.ports):
            if index not in self.cut:
                port.send(identifier, data, fd)

    def now_us(self) -> int:
        return self.sims[0].now_us()

    def pump(self, us: int) -> None:
        end = self.now_us() + us
        while (left := end - self.now_us()) > 0:
            self.node.step(self.now_us())
            for sim in self.sims:
                sim.advance(min(left, 20_000))


@pytest.fixture
def three(binary: Path, tmp_path: Path) -> Iterator[Joined]:
    with ExitStack() as stack:
        sims = []
        for number in range(3):
            options = ("--flash", str(tmp_path / f"flash{number}"))
            sim = stack.enter_context(
                Simulator(binary, {"uart0": "udpin:127.0.0.1:0", "can0": CAN}, options=options)
            )
            Light(sim.connect("uart0")).find()
            set_parameter(sim, "CAN_NODE_ID", 70 + number)
            sim.reset()
            sims.append(sim)
        for sim in sims:
            sim.advance(s=12)
        yield Joined(sims)


def set_parameter(sim: Simulator, name: str, value: float) -> None:
    from pharos import Parameters

    light = Light(sim.connect("uart0"))
    light.find()
    Parameters(light).set(name, value)
    sim.advance(s=1)


def test_three_nodes_at_once_with_one_lost_and_one_restarted(three: Joined, tmp_path: Path) -> None:
    image = image_of(6_000)
    happened: list[str] = []

    def on_progress(progress: UpdateProgress) -> None:
        if progress.device == "node 71" and progress.percent > 30 and "cut" not in happened:
            happened.append("cut")
            three.cut.add(1)
        if progress.device == "node 72" and progress.percent > 60 and "reset" not in happened:
            happened.append("reset")
            three.sims[2].reset()

    updater = NodeUpdater(three.node, image, [70, 71, 72, 73], on_progress, patience_us=15_000_000)
    one, lost, restarted, absent = update_nodes(updater, three)
    assert happened == ["cut", "reset"]
    assert (one.phase, restarted.phase) == (UpdatePhase.DONE, UpdatePhase.DONE)
    assert (lost.phase, lost.is_silent) == (UpdatePhase.FAILED, True)
    assert "was lost: nothing heard for 15 s" in lost.text
    assert (absent.phase, absent.text) == (UpdatePhase.FAILED, "is silent: nothing heard for 3 s")
    for number, runs in enumerate([True, False, True]):
        slot = slot_of(tmp_path / f"flash{number}", 0)
        assert (slot[: len(image)] == image) == runs


def test_a_node_that_comes_back_is_updated_all_the_same(three: Joined, tmp_path: Path) -> None:
    image, begun = image_of(3_000), three.now_us()
    updater = NodeUpdater(three.node, image, [71], patience_us=60_000_000)
    while not updater.is_done:
        updater.step()
        three.pump(50_000)
        away = 1_000_000 < three.now_us() - begun < 31_000_000
        three.cut = {1} if away else set()
    assert updater.progress[0].phase is UpdatePhase.DONE
    assert slot_of(tmp_path / "flash1", 0)[: len(image)] == image


def test_a_node_that_refuses_says_why(three: Joined) -> None:
    updater = NodeUpdater(three.node, image_of(700, spoilt=True), [70])
    (refused,) = update_nodes(updater, three)
    assert refused.phase is UpdatePhase.FAILED
    assert "does not have its SHA-256" in refused.text
    updater = NodeUpdater(three.node, b"MZ" + bytes(700), [70])
    (refused,) = update_nodes(updater, three)
    assert "not an image of MCUboot's" in refused.text
    set_parameter(three.sims[0], "LGT_SRC_EXCL", 2)
    updater = NodeUpdater(three.node, image_of(700), [70])
    (refused,) = update_nodes(updater, three)
    assert refused.text.startswith("refused: DroneCAN may not")


# --- files ----------------------------------------------------------------------------------------
def test_images_are_told_from_other_files(tmp_path: Path) -> None:
    assert version_of(image_of(10)) == "1.2.3+4"
    assert version_of(b"\x7fELF") == ""
    assert version_of(b"MZ" * 100) == ""
    (tmp_path / "empty").touch()
    for name in ("none", "empty", "\0"):
        with pytest.raises(UsageError):
            read_image(str(tmp_path / name))


# --- the command ----------------------------------------------------------------------------------
def test_the_command_says_each_phase_and_each_tenth(
    bench: Bench,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    @contextmanager
    def connect(url: str, **_options: Any) -> Iterator[Light]:
        assert url == "udp:there:1"
        yield bench.light

    monkeypatch.setattr(cli_update, "connect", connect)
    path = tmp_path / "new.bin"
    path.write_bytes(image_of(20_000))
    assert main(["update", str(path), "udp:there:1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{path}: 20552 bytes, version 1.2.3+4"
    assert lines[1] == "1/243: asks"
    assert "1/243: writes 10 %" in lines
    assert lines[-4:] == [
        "1/243: checks",
        "1/243: restarts",
        "1/243: is on trial",
        "1/243: done, version 0.1.0 before, 0.1.0 now",
    ]
    assert main(["update", str(path), "udp:there:1", "--json"]) == 0
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert events[0]["size"] == 20_552
    assert [event["phase"] for event in events[1:]].count("writing") in (10, 11)
    assert events[-1]["phase"] == "done"


def test_each_of_several_nodes_has_its_url() -> None:
    assert node_urls("dronecan:vcan/0?node=68,69&fd=1") == [
        "dronecan:vcan/0?node=68&fd=1",
        "dronecan:vcan/0?node=69&fd=1",
    ]
    assert node_urls("dronecan:vcan/0") == ["dronecan:vcan/0"]


def test_a_terminal_has_one_line_that_is_written_over(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    err, out = Terminal(), io.StringIO()
    monkeypatch.setattr("sys.stderr", err)
    shown = Shown(Printer(out, err))
    shown(UpdateProgress("node 68", UpdatePhase.WRITING, 41))
    shown(UpdateProgress("node 68", UpdatePhase.WRITING, 42))
    assert out.getvalue() == ""
    assert err.getvalue().split("\r")[1:] == ["node 68: writes 41 %", "node 68: writes 42 %"]
    shown(UpdateProgress("node 68", UpdatePhase.DONE, 100))
    assert out.getvalue() == "node 68: done\n"
    assert err.getvalue().endswith("\r" + " " * len("node 68: done") + "\r")


@pytest.mark.realtime
def test_the_commands_errors_are_one_line(
    real_light: Callable[..., RealLight], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = real_light("--uart0", "udpin:127.0.0.1:0", "--can0", "udp").url()
    image, spoilt, other = (tmp_path / name for name in ("image", "spoilt", "other"))
    image.write_bytes(image_of(700))
    spoilt.write_bytes(image_of(700, spoilt=True))
    other.write_bytes(b"other")
    can = "dronecan:pharos-udp/127.255.255.255:1?node=9"
    for code, hint, *words in (
        (1, "does not have its SHA-256", spoilt, url),
        (2, "not an image of MCUboot's", other, url),
        (2, "No such file", tmp_path / "none", url),
        (3, "no illuminator answered", image, "udp:127.0.0.1:9", "--timeout", "0.1"),
        (3, "node 9 is silent", image, can, "--timeout", "0.1"),
        (2, "names a node twice", image, can + ",9"),
        (2, "node='x'", image, can + ",x"),
        (2, "--via dronecan needs", image, url, "--via", "dronecan"),
        (2, "no signatures", image, can, "--key-file", other),
    ):
        capsys.readouterr()
        assert main(["update", *map(str, words)]) == code, words
        err = capsys.readouterr().err
        assert err.startswith("pharos: ")
        assert hint in err
        assert err.count("\n") == 1
