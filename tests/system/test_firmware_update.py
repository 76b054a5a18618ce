# SPDX-License-Identifier: Apache-2.0
"""Firmware update over DroneCAN: PyPI's dronecan serves images made by MCUboot's own imgtool."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from dronecan import uavcan
from dronecan.app.file_server import FileServer

from dronecan_peer import Peer
from harness import BUS, CONSOLE, NODE, Shell, set_over_can
from pharos import Simulator

SLOT = 229_376  # native.dts
TRAILER = 4096  # CONFIG_PHAROS_FIRMWARE_TRAILER_SIZE
PAGE = 2048
MAGIC = bytes.fromhex("77c295f360d2ef7f3552500f2cb67980")  # MCUboot, BOOT_IMG_MAGIC
CONFIRM_S = 10

Update = uavcan.protocol.file.BeginFirmwareUpdate


def image_of(path: Path, size: int, version: str = "1.2.3+4", *more: str) -> bytes:
    """An image as MCUboot's tool makes it, its code `size` bytes."""
    code = path.with_suffix(".code")
    code.write_bytes(bytes(range(256)) * (size // 256) + bytes(size % 256))
    words = ["-m", "imgtool.main", "sign", "--version", version, "--header-size", "0x200"]
    words += ["--pad-header", "--slot-size", str(SLOT), "--align", "8", *more, str(code), str(path)]
    subprocess.run([sys.executable, *words], check=True, capture_output=True)
    return path.read_bytes()


class Bench:
    """A light whose image slots lie in a file, and a node that serves a folder."""

    def __init__(self, sim: Simulator, folder: Path, fd: bool) -> None:
        self.sim = sim
        self.folder = folder
        if fd:
            set_over_can(sim, "CAN_FD", 1)
            sim.reset()
        sim.advance(s=CONFIRM_S + 2)
        self.peer = Peer(sim, fd=fd)
        self.files = FileServer(self.peer.node, [str(folder)])

    def begin(self, name: str) -> Any:
        request = Update.Request(source_node_id=self.peer.node.node_id)
        request.image_file_remote_path.path = name
        return self.peer.ask(request)

    def slot(self, number: int) -> bytes:
        inverted = (self.folder / "flash").read_bytes()[number * SLOT :][:SLOT]
        return bytes(byte ^ 0xFF for byte in inverted)

    def firmware(self) -> str:
        return Shell(self.sim)("firmware")

    def wait(self, text: str, seconds: int = 60) -> str:
        """Until `firmware` says so."""
        for _ in range(seconds):
            told = self.firmware()
            if text in told:
                return told
            self.peer.run(1_000_000)
        raise AssertionError(f"never said {text!r}: {told}")

    def wait_reset(self, resets: int, seconds: int = 120) -> None:
        for _ in range(seconds):
            if self.sim.outputs()["resets"] > resets:
                self.sim.advance(s=1)
                return
            self.peer.run(1_000_000)
        raise AssertionError(self.firmware())


@pytest.fixture
def light(start: Callable[..., Simulator], tmp_path: Path, request: pytest.FixtureRequest) -> Bench:
    sim = start({"can0": BUS, "console": CONSOLE}, options=["--flash", str(tmp_path / "flash")])
    return Bench(sim, tmp_path, getattr(request, "param", False))


both = pytest.mark.parametrize("light", [False, True], ids=["classic", "fd"], indirect=True)


@both
@pytest.mark.parametrize("size", [700, 20_000])
def test_an_image_is_installed_tried_and_confirmed(light: Bench, size: int) -> None:
    image = image_of(light.folder / "new.bin", size)
    assert "confirmed" in light.firmware()
    assert light.begin("new.bin").error == Update.Response().ERROR_OK
    light.wait_reset(0 if light.sim.outputs()["resets"] == 0 else 1)
    assert light.slot(0)[: len(image)] == image, "the bootloader has swapped it in"
    assert "on test" in light.firmware()
    light.sim.advance(s=CONFIRM_S)
    assert "confirmed" in light.firmware()
    light.sim.reset()
    assert light.slot(0)[: len(image)] == image, "and it stays"


def test_an_image_that_never_confirms_itself_is_taken_back(light: Bench) -> None:
    image = image_of(light.folder / "new.bin", 700)
    light.begin("new.bin")
    light.wait_reset(0)
    assert light.slot(0)[: len(image)] == image
    light.sim.reset()  # within the 10 s
    light.sim.advance(s=1)
    assert light.slot(0)[: len(image)] != image
    assert light.slot(1)[: len(image)] == image


@pytest.mark.parametrize(
    ("device", "kind", "fields"),
    [
        ("chip", "never", {"name": "adc"}),
        ("thermistor", "open", {}),
        ("chip", "error", {"name": "uart1"}),
        ("chip", "error", {"name": "watchdog"}),
    ],
)
def test_an_image_with_which_something_does_not_start_is_not_confirmed(
    light: Bench, device: str, kind: str, fields: dict[str, str]
) -> None:
    image = image_of(light.folder / "new.bin", 700)
    light.begin("new.bin")
    light.sim.fault(device, kind, **fields)
    light.wait_reset(0)
    assert light.slot(0)[: len(image)] == image
    light.sim.advance(s=3 * CONFIRM_S)
    assert "on test" in light.firmware()
    light.sim.fault(device, "none", **fields)
    light.sim.reset()
    light.sim.advance(s=CONFIRM_S + 2)
    assert light.slot(0)[: len(image)] != image, "taken back"


def test_blocks_that_fill_whole_reads_end_with_an_empty_one(light: Bench) -> None:
    image = image_of(light.folder / "new.bin", 1024 - 0x200 - 40)
    whole = -len(image) % 256
    image = image_of(light.folder / "new.bin", 1024 - 0x200 - 40 + whole)
    assert len(image) % 256 == 0
    light.begin("new.bin")
    light.wait_reset(0)
    assert light.slot(0)[: len(image)] == image


def test_mode_is_software_update_meanwhile_and_the_lamp_obeys(light: Bench) -> None:
    heard = light.peer.heard(uavcan.protocol.NodeStatus)
    image_of(light.folder / "new.bin", 100_000)
    light.begin("new.bin")
    light.peer.run(300_000)
    assert heard[-1].mode == heard[-1].MODE_SOFTWARE_UPDATE
    command = uavcan.equipment.hardpoint.Command(hardpoint_id=0, command=1)
    light.peer.tell(command)
    assert light.sim.outputs()["enable"] == 1
    light.wait_reset(0)
    assert light.sim.outputs()["level_ppm"] == 0, "off after the reset"


# --- what is refused ----------------------------------------------------------------------------
def spoil(image: bytes, at: int) -> bytes:
    return image[:at] + bytes([image[at] ^ 1]) + image[at + 1 :]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda image: b"MZ" + image[2:], "not an image of MCUboot's"),
        (lambda image: b"", "ends too early"),
        (lambda image: image[:31], "ends too early"),
        (lambda image: image[:-1], "ends too early"),
        (lambda image: image + b"\0", "data after the end of the image"),
        (lambda image: spoil(image, 0x200 + 5), "does not have its SHA-256"),
        (lambda image: spoil(image, len(image) - 1), "does not have its SHA-256"),
        (lambda image: spoil(image, 0x200 + 3000), "malformed after the code"),
        (lambda image: image[:12] + (SLOT).to_bytes(4, "little") + image[16:], "too large"),
    ],
)
def test_a_wrong_image_is_refused_and_never_marked(
    light: Bench, change: Callable[[bytes], bytes], said: str
) -> None:
    path = light.folder / "new.bin"
    path.write_bytes(change(image_of(path, 3000)))
    assert light.begin("new.bin").error == Update.Response().ERROR_OK
    light.wait(said)
    assert MAGIC not in light.slot(1)
    assert light.sim.outputs()["resets"] == 0
    image_of(path, 700)
    assert light.begin("new.bin").error == Update.Response().ERROR_OK, "the next one is welcome"
    light.wait_reset(0)


def test_a_wrong_image_costs_one_block_not_the_whole_file(light: Bench) -> None:
    (light.folder / "new.bin").write_bytes(bytes(100_000))
    light.begin("new.bin")
    light.wait("not an image of MCUboot's")
    light.peer.run(3_000_000)
    assert sum(light.files.path_hit_counters.values()) == 1


def test_an_image_for_a_larger_slot_is_refused_with_its_header(light: Bench) -> None:
    image_of(light.folder / "new.bin", SLOT - TRAILER - 0x200 - 39)
    light.begin("new.bin")
    light.wait("too large for the slot")


def test_a_missing_file_is_the_servers_error(light: Bench) -> None:
    assert light.begin("absent.bin").error == Update.Response().ERROR_OK
    light.wait("the file server reports an error")


def test_a_second_asker_hears_that_one_is_in_progress(light: Bench) -> None:
    image_of(light.folder / "new.bin", 100_000)
    light.begin("new.bin")
    assert light.begin("new.bin").error == Update.Response().ERROR_IN_PROGRESS
    assert light.begin("other.bin").error == Update.Response().ERROR_IN_PROGRESS
    light.wait_reset(0)


def test_without_a_path_it_is_refused(light: Bench) -> None:
    answer = light.begin("")
    assert answer.error == Update.Response().ERROR_UNKNOWN
    assert "no path" in str(answer.optional_error_message)
    assert "idle" in light.firmware()


# --- what goes wrong on the way ---------------------------------------------------------------
def test_a_silent_server_is_asked_ten_times_then_given_up(light: Bench) -> None:
    request = Update.Request(source_node_id=99)  # nobody
    request.image_file_remote_path.path = "new.bin"
    frames: list[int] = []
    light.sim.bus().listeners.append(lambda frame: frames.append(frame.arbitration_id))
    light.peer.ask(request)
    light.wait("the file server is silent")
    read = 48 << 16 | 1 << 15 | 99 << 8 | 1 << 7 | NODE  # a request to 99
    starts = [identifier for identifier in frames if identifier & 0xFFFFFF == read]
    assert len(starts) == 10 * 2  # 5 bytes of offset, 7 of name, 2 of CRC: two frames


def test_a_flash_that_never_answers_ends_the_update_and_is_told(light: Bench) -> None:
    image_of(light.folder / "new.bin", 3000)
    light.sim.fault("chip", "never", name="flash")
    light.begin("new.bin")
    light.wait("the flash does not answer", seconds=70)
    assert light.begin("new.bin").error != Update.Response().ERROR_OK, "it may still come"
    shell = Shell(light.sim)
    assert "ok" in shell("light on")
    light.sim.advance(s=1)
    assert light.sim.outputs()["level_ppm"] == 1_000_000
    assert light.sim.outputs()["resets"] == 0


@pytest.mark.parametrize("at", ["erase", "first block", "last block", "mark"])
def test_power_that_fails_leaves_the_old_image(light: Bench, at: str) -> None:
    image = image_of(light.folder / "new.bin", 3000)
    size = -(-len(image) // 8) * 8
    cut = {"erase": 3000, "first block": SLOT + 100, "last block": SLOT + size - 8}
    light.sim.fault("flash", "torn", byte=cut.get(at, SLOT + size + 8))
    light.begin("new.bin")
    light.wait("failed")
    light.sim.reset()
    light.sim.advance(s=1)
    assert light.slot(0) == b"\xff" * SLOT
    assert "confirmed" in light.firmware()
    light.begin("new.bin")
    light.wait_reset(1)
    assert light.slot(0)[: len(image)] == image
