# SPDX-License-Identifier: Apache-2.0
"""Settings that cannot be read may have held a key: the light is locked but for its console."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from dronecan import uavcan

from harness import ACCEPTED, BUS, CONSOLE, NODE, WIRES, Light, Shell, light_on, texts
from pharos import SilentError, Simulator

KEY = bytes(range(32))
UNIX = 1_720_000_000
STAMP = (UNIX - 1_420_070_400) * 100_000
HEAD = 32  # the mark, in whole words
TOLD = "Key lost: obeys only its console (signing key)"

Boot = Callable[[], tuple[Light, Shell]]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "settings"


@pytest.fixture
def boot(start: Callable[..., Simulator], path: Path) -> Boot:
    def begin() -> tuple[Light, Shell]:
        wires = {"uart0": WIRES["udp"], "console": CONSOLE, "can0": BUS}
        sim = start(wires, options=["--settings", str(path)])
        return light_on(sim), Shell(sim)

    return begin


def _obeys(light: Light) -> bool:
    try:
        return light.on() == ACCEPTED
    except SilentError:
        return False


@pytest.fixture(params=[1, 2], ids=["one record", "two"])
def damaged(request: pytest.FixtureRequest, boot: Boot, path: Path) -> Path:
    """The settings of a light with a key, none of which can be read."""
    light, shell = boot()
    shell(f"signing key {UNIX}")
    shell(KEY.hex())
    light.sim.advance(s=5)
    if request.param > 1:
        shell("param set STRB_MIN 0.05")
        light.sim.advance(s=5)
    assert light.sim.quit() == 0
    content = bytearray(path.read_bytes())
    for at in range(HEAD + 8, len(content), 16):
        content[at] ^= 0x10
    path.write_bytes(content)
    return path


def test_a_light_whose_key_is_lost_obeys_nobody_but_the_console(damaged: Path, boot: Boot) -> None:
    light, shell = boot()
    light.greet()
    assert not _obeys(light)
    assert TOLD in texts(light.mav.pass_time(31_000_000))
    light.mav.sign(KEY, STAMP)
    light.mav.take_all()
    assert not _obeys(light), "its old key is not known to it"
    light.mav.sign(bytes(32), STAMP)
    assert not _obeys(light), "the key of zeros is none"
    node = light.sim.node(10)
    node.broadcast(uavcan.equipment.hardpoint.Command(hardpoint_id=0, command=1))
    light.sim.advance(s=1)
    assert light.sim.outputs()["enable"] == 0
    assert "lost: locked until signing key, or signing off" in shell("signing status")
    shell("light on")
    assert light.sim.outputs()["enable"] == 1
    request = uavcan.protocol.param.GetSet.Request()
    request.name.encode("MAV_KEY_CAN")
    request.value.integer_value = 2
    assert node.ask(request, NODE, light.sim).value.integer_value == 0


def test_the_lock_outlasts_what_is_stored_then(damaged: Path, boot: Boot) -> None:
    light, shell = boot()
    shell("param set STRB_MIN 0.04")
    light.sim.advance(s=5)
    assert light.sim.quit() == 0
    light, shell = boot()
    assert not _obeys(light)
    assert "lost" in shell("signing status")
    assert "0.04" in shell("param get STRB_MIN")


def test_signing_off_opens_it(damaged: Path, boot: Boot) -> None:
    light, shell = boot()
    shell("signing off")
    light.sim.advance(s=5)
    assert _obeys(light)
    assert light.sim.quit() == 0
    light, _ = boot()
    assert _obeys(light)


@pytest.mark.parametrize("time", ["", f" {UNIX}"])
def test_a_new_key_is_a_key(damaged: Path, boot: Boot, time: str) -> None:
    light, shell = boot()
    shell(f"signing key{time}")
    assert "signing is on" in shell(KEY.hex())
    assert not _obeys(light)
    light.mav.sign(KEY, STAMP)
    assert _obeys(light)


def test_a_first_write_that_was_cut_short_locks_nothing(boot: Boot, path: Path) -> None:
    light, shell = boot()
    shell("param set STRB_MIN 0.05")
    light.sim.advance(s=5)
    assert light.sim.quit() == 0
    whole = path.read_bytes()
    for length in (HEAD, HEAD + 1, HEAD + 11, HEAD + 12, HEAD + 13, HEAD + 32, HEAD + 33):
        path.write_bytes(whole[:length])
        light, _ = boot()
        assert _obeys(light), length
        assert light.sim.quit() == 0


def test_a_store_that_does_not_answer_locks(boot: Boot) -> None:
    light, shell = boot()
    light.sim.fault("chip", "error", name="storage")
    light.sim.reset()
    light.greet()
    assert not _obeys(light)
    light.sim.fault("chip", "none", name="storage")
    light.sim.reset()
    light.greet()
    assert _obeys(light), "there was no key"
    assert "none" in shell("signing status")
