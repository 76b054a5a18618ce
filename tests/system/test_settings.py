# SPDX-License-Identifier: Apache-2.0
"""Settings outlast resets, restarts and power cuts: the old or the new, never a mix."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from harness import ACCEPTED, CONSOLE, DENIED, WIRES, Light, Shell, light_on, texts
from parameters import get_param, set_param
from pharos import Simulator

OLD, NEW = 0.01, 0.05  # of STRB_MIN: its default, and what is set


@pytest.fixture
def boot(start: Callable[..., Simulator], tmp_path: Path) -> Callable[[], tuple[Light, Shell]]:
    """Starts a light whose settings lie in one file."""

    def begin() -> tuple[Light, Shell]:
        sim = start(
            {"uart0": WIRES["udp"], "console": CONSOLE},
            options=["--settings", str(tmp_path / "settings")],
        )
        return light_on(sim), Shell(sim)

    return begin


def _value(shell: Shell, name: str) -> float:
    found = re.search(rf"^{name}\s+(-?[\d.]+) ", shell(f"param get {name}"), re.MULTILINE)
    assert found is not None
    return float(found[1])


def test_parameter_is_in_force_at_once(boot: Callable[[], tuple[Light, Shell]]) -> None:
    light, shell = boot()
    assert light.configure(period_s=0.02, duty=50) == ACCEPTED
    shell(f"param set STRB_MIN {NEW}")
    assert light.status().min_strobe_period == pytest.approx(0.05)
    assert light.configure(period_s=0.02, duty=50) == DENIED


def test_parameter_survives_a_reset_and_a_restart(
    boot: Callable[[], tuple[Light, Shell]],
) -> None:
    light, shell = boot()
    shell(f"param set STRB_MIN {NEW}")
    light.sim.advance(s=5)
    light.sim.reset()
    light.greet()
    assert _value(shell, "STRB_MIN") == NEW
    assert light.sim.quit() == 0
    _, shell = boot()
    assert _value(shell, "STRB_MIN") == NEW


def test_parameter_out_of_range_is_refused(boot: Callable[[], tuple[Light, Shell]]) -> None:
    _, shell = boot()
    assert "out of range" in shell("param set STRB_MIN 0.0009")
    assert "param list" in shell("param set NO_SUCH 1")
    assert _value(shell, "STRB_MIN") == OLD


@pytest.mark.parametrize("byte", [*range(0, 40, 3), 100])
def test_power_cut_at_any_byte_of_a_write_leaves_the_old_or_the_new(
    boot: Callable[[], tuple[Light, Shell]], byte: int
) -> None:
    light, shell = boot()
    light.sim.fault("storage", "torn", byte=byte)
    shell(f"param set STRB_MIN {NEW}")
    light.sim.advance(s=5)
    light.sim.request("reset", cause="brownout")
    light.greet()
    assert _value(shell, "STRB_MIN") in (OLD, NEW)
    # The store works again, and a later write is kept.
    shell("param set STRB_MIN 0.07")
    light.sim.advance(s=5)
    light.sim.reset()
    light.greet()
    assert _value(shell, "STRB_MIN") == 0.07


def test_power_cut_at_any_byte_of_any_write_of_parameters_set_over_mavlink(
    start: Callable[..., Simulator],
) -> None:
    """Each round sets three parameters, and cuts one byte later than the last, until nothing is
    cut any more; what a torn write leaves behind is tidied up in the next round's first write. What
    is read is what held after one of the sets, in their order: none is half there, and none without
    those before it."""
    names = ("LGT_LOSS", "SYNC_PULSE", "THR_STUCK")
    light = light_on(start({"uart0": WIRES["udp"]}))  # settings in memory, which resets leave

    def stored() -> tuple[float, ...]:
        return tuple(get_param(light, name) for name in names)

    kept: list[int] = []
    for cut in range(500):
        history = [stored()]
        light.sim.fault("storage", "torn", byte=cut)
        for at, name in enumerate(names):
            value = 500 * (at + 1) + cut
            assert set_param(light, name, value) == value
            light.sim.advance(100_000)
            now = list(history[-1])
            now[at] = value
            history.append(tuple(now))
        light.sim.request("reset", cause="brownout")
        light.greet()
        assert stored() in history, f"cut after {cut} bytes"
        kept.append(history.index(stored()))
        if kept[-3:] == [3, 3, 3]:
            break
    # The cut moved through all three writes, and past them.
    assert kept[0] == 0
    assert set(kept) == {0, 1, 2, 3}
    assert kept[-1] == 3


def test_people_are_told_when_settings_cannot_be_stored(
    boot: Callable[[], tuple[Light, Shell]],
) -> None:
    light, _ = boot()
    light.sim.fault("storage", "torn", byte=0)
    light.mav.drain()
    light.mav.inbox.clear()
    assert set_param(light, "STRB_MIN", NEW) == NEW
    assert [t for t in texts(light.mav.pass_time(1_000_000)) if "stored" in t] == [
        "Settings can't be stored: error -5"  # EIO
    ]
    set_param(light, "STRB_MIN", 2 * NEW)  # again within ten seconds: no news
    assert not [t for t in texts(light.mav.pass_time(1_000_000)) if "stored" in t]
    assert light.status().min_strobe_period == pytest.approx(0.1)


def test_lamp_stays_dark_after_a_reset_unless_it_shall_be_restored(
    boot: Callable[[], tuple[Light, Shell]],
) -> None:
    light, shell = boot()
    light.configure(60, 0.5, 25)
    light.on()
    light.sim.advance(s=5)
    light.sim.reset()
    light.greet()
    assert light.status().enable == 0
    shell("param set LGT_RESTORE 1")
    light.configure(60, 0.5, 25)
    light.on()
    light.sim.advance(s=5)
    light.sim.reset()
    light.greet()
    status = light.status()
    assert (status.enable, status.brightness, status.strobe_period) == (1, 60.0, 0.5)
    shell("param set STRB_MAX 0.3")  # what is in force stays, and has to fit after a reset
    light.sim.advance(s=5)
    light.sim.reset()
    light.greet()
    status = light.status()
    assert status.enable == 1
    assert status.strobe_period == pytest.approx(0.3)
