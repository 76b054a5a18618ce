# SPDX-License-Identifier: Apache-2.0
"""How often the light writes its flash: what comes over the wire must not wear it out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from harness import ACCEPTED, WIRES, light_on
from imc_light import join
from parameters import set_param
from pharos import Simulator
from pharos.imc import message

STEP_US = 100_000


class Flash:
    """The file of the settings, looked at every 100 ms: how often it was another one."""

    def __init__(self, start: Callable[..., Simulator], path: Path, wires: dict[str, str]) -> None:
        imc = ("--protocol", "imc") if "uart1" in wires else ()
        self.sim = start(wires, options=(*imc, "--settings", str(path)))
        self.writes = 0
        self._path = path
        self._content = b""

    def pass_time(self, us: int) -> None:
        for _ in range(us // STEP_US):
            self.sim.advance(STEP_US)
            content = self._path.read_bytes() if self._path.exists() else b""
            self.writes += content != self._content
            self._content = content


@pytest.mark.parametrize(
    ("gap_us", "most"),
    # 1000 changes last 400 s: one write each 30 s, and a last one. And 2000 s: 20 at once, then
    # one each 36 s.
    [(400_000, 15), (2_000_000, 76)],
)
def test_thousand_changes_of_the_light(
    start: Callable[..., Simulator], tmp_path: Path, gap_us: int, most: int
) -> None:
    flash = Flash(start, tmp_path / "settings", {"uart0": WIRES["udp"]})
    light = light_on(flash.sim)
    set_param(light, "LGT_RESTORE", 1)
    flash.pass_time(2_000_000)
    before = flash.writes
    for i in range(1000):
        assert light.configure(brightness=10 + i % 80) == ACCEPTED
        flash.pass_time(gap_us)
    flash.pass_time(60_000_000)
    assert most - 3 <= flash.writes - before <= most
    flash.sim.request("reset", cause="brownout")
    light.greet()
    assert light.status().brightness == pytest.approx(10 + 999 % 80)


def test_what_is_stored_already_is_not_written_again(
    start: Callable[..., Simulator], tmp_path: Path
) -> None:
    flash = Flash(start, tmp_path / "settings", {"uart0": WIRES["udp"], "uart1": WIRES["tcp"]})
    light = light_on(flash.sim)
    peer = join(flash.sim, "uart1")
    set_param(light, "LGT_LOSS", 5)
    peer.send("PowerChannelControl", name="camera", op=0)
    peer.send("PowerChannelControl", name="camera", op=6)  # save
    flash.pass_time(2_000_000)
    before = flash.writes
    assert before > 0
    for value in range(100):  # packets that change nothing that lasts
        peer.send("SetLedBrightness", name="lamp", value=value)
        peer.send("PowerChannelControl", name="camera", op=6)
        peer.send(
            "SetEntityParameters",
            name="Lamp",
            params=[message("EntityParameter", name="LGT_LOSS", value="5")],
        )
        set_param(light, "LGT_LOSS", 5)
        flash.pass_time(STEP_US)
    flash.pass_time(2_000_000)
    assert flash.writes == before
