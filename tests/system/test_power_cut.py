# SPDX-License-Identifier: Apache-2.0
"""A power cut at any byte leaves the state after some of what was accepted, in its order; what was
accepted together is there together. And what an earlier version has stored is taken over so."""

from __future__ import annotations

import binascii
import re
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from harness import CONSOLE, WIRES, Light, Shell, light_on
from imc_light import join
from parameters import get_param, send_set, set_param
from pharos import Simulator
from pharos.imc import ImcPeer, message

LIMITS = ("THR_RECOVER", "THR_THROTTLE", "THR_SHUTDOWN")
COLD, HOT = (30, 40, 50), (55, 60, 65)

# Bytes of a word of flash that has a checksum; 1: none. 8 is an STM32G4's, 32 an H7's.
WORDS = (1, 8, 32)


def limits(light: Light) -> tuple[float, ...]:
    return tuple(get_param(light, name) for name in LIMITS)


def cuts(light: Light, word: int, change: Callable[[], None]) -> Iterator[tuple[float, ...]]:
    """What is left of `change` after a cut at byte 0, 1, …, until nothing is cut any more."""
    whole = 0
    for byte in range(2000):
        for name, value in zip(LIMITS, COLD, strict=True):
            set_param(light, name, value)
        light.sim.advance(s=1)
        light.sim.fault("storage", "torn", byte=byte, word=word)
        change()
        light.sim.advance(s=1)
        light.sim.request("reset", cause="brownout")
        light.greet()
        left = limits(light)
        yield left
        whole = whole + 1 if left == HOT else 0
        if whole == 40:  # more than any record is filled up by
            return
    raise AssertionError("it was always cut")


@pytest.mark.parametrize("word", WORDS)
def test_burst_of_parameters(start: Callable[..., Simulator], word: int) -> None:
    light = light_on(start({"uart0": WIRES["udp"]}))

    def burst() -> None:
        for name, value in reversed(list(zip(LIMITS, HOT, strict=True))):
            send_set(light.mav, name, value)

    in_order: list[tuple[float, ...]] = [
        COLD,
        (30, 40, 65),
        (30, 60, 65),
        HOT,
    ]
    left = list(cuts(light, word, burst))
    assert set(left) <= set(in_order)
    assert left[0] == COLD
    assert [in_order.index(state) for state in left] == sorted(map(in_order.index, left))


@pytest.mark.parametrize("word", WORDS)
def test_one_message_with_several_parameters(start: Callable[..., Simulator], word: int) -> None:
    wires = {"uart0": WIRES["udp"], "uart1": WIRES["tcp"]}
    light = light_on(start(wires, options=("--protocol", "imc")))
    peer: ImcPeer = join(light.sim, "uart1")

    def send() -> None:
        wanted = [
            message("EntityParameter", name=name, value=str(value))
            for name, value in reversed(list(zip(LIMITS, HOT, strict=True)))
        ]
        peer.send("SetEntityParameters", name="Thermal", params=wanted)

    left = list(cuts(light, word, send))
    assert set(left) == {COLD, HOT}
    assert left == sorted(left)


def test_light_and_parameter_keep_their_order(start: Callable[..., Simulator]) -> None:
    """The light would settle for a second; the parameter set after it takes it along."""
    light = light_on(start({"uart0": WIRES["udp"]}))
    set_param(light, "LGT_RESTORE", 1)
    light.configure(60, 0.5, 25)
    set_param(light, "SYNC_PULSE", 4000)
    light.sim.advance(100_000)
    light.sim.request("reset", cause="brownout")
    light.greet()
    assert get_param(light, "SYNC_PULSE") == 4000
    assert light.status().brightness == 60.0


# --- what version 0.1 has stored ------------------------------------------------------------------


def old_store(values: dict[str, bytes]) -> bytes:
    """A settings file of version 0.1: a record for each value, without filling up."""
    content = b"PHAROS settings 1\n"
    for name, value in values.items():
        head = struct.pack("<HBBH", 0x53A7, len(name), 0, len(value))
        head += struct.pack("<H", binascii.crc_hqx(head, 0xFFFF))
        body = name.encode() + value
        content += head + struct.pack("<I", binascii.crc32(head + body)) + body
    return content


def old_params(**values: int) -> dict[str, bytes]:
    return {f"pharos/param/{name}": struct.pack("<i", value) for name, value in values.items()}


# 40 %, 0.5 s, 10 %, internal, on; all power channels but the camera's; a key at 2^40.
OLD = {
    **old_params(LGT_RESTORE=1, STRB_MIN_US=20_000),
    **old_params(**{name: 1000 * value for name, value in zip(LIMITS, COLD, strict=True)}),
    "pharos/light": struct.pack("<IIIBBxx", 400_000, 500_000, 100_000, 1, 1),
    "pharos/power": b"\x0b",
    "pharos/signing": struct.pack("<Q", 1 << 40) + bytes(range(32)),
}


def shown(shell: Shell) -> str:
    """What the shell tells of it."""
    params = [shell(f"param get {name}").splitlines()[1] for name in (*LIMITS, "STRB_MIN")]
    told = [shell(line) for line in ("light status", "power status", "signing status")]
    wanted = ("brightness", "strobe", "enable", "camera", "aux", "key")
    return "\n".join(params + [x for t in told for x in t.splitlines() if x.startswith(wanted)])


def test_values_of_an_earlier_version_are_taken_over(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    path = tmp_path / "settings"
    path.write_bytes(old_store(OLD))
    sim = start(
        {"uart0": WIRES["udp"], "console": CONSOLE},
        options=("--settings", str(path)),
    )
    light = light_on(sim)
    shell = Shell(sim)
    first = shown(shell)
    for value in (*COLD, 0.02):
        assert re.search(rf"^\w+ +{value} ", first, re.MULTILINE)
    assert re.search(r"^brightness +40 %$", first, re.MULTILINE)
    assert re.search(r"^enable +on$", first, re.MULTILINE)
    assert re.search(r"^camera +off, after a start off$", first, re.MULTILINE)
    assert re.search(r"^key +set$", first, re.MULTILINE)
    for value in range(5000, 5040):  # the old values go when their place is needed
        shell(f"param set SYNC_PULSE {value}")
    assert b"pharos/0" in path.read_bytes()
    assert b"pharos/param" not in path.read_bytes()
    sim.reset()
    light.greet()
    shell("")
    assert shown(shell) == first


def test_half_a_change_that_an_earlier_version_has_left_is_not_mended_towards_heat(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    """30/40/50 was to be 55/60/65, one value after the other; power failed behind the first."""
    path = tmp_path / "settings"
    path.write_bytes(old_store(old_params(THR_RECOVER=55_000, THR_THROTTLE=40_000,
                                          THR_SHUTDOWN=50_000)))  # fmt: skip
    light = light_on(start({"uart0": WIRES["udp"]}, options=("--settings", str(path))))
    assert limits(light) == (39.999, 40, 50)
