# SPDX-License-Identifier: Apache-2.0
"""How many instructions the image spends on a command and on an edge of the strobe.

Counted from the guest's clock, which goes on by 8 ns with each instruction, between the instants at
which it wakes and is idle again. A wake is exact to less than one cycle of 40 ns, or five
instructions, by rounding, and may seem one cycle longer, for QEMU's clock jumps by up to a tick of
qemu.py's timer at a stop; a test compares that with single steps. Bytes are handed over one by one,
each to an idle guest, as at a serial link's pace."""

from __future__ import annotations

from statistics import median_low

import pytest

from harness import ACCEPTED, REQUEST_MESSAGE, STATUS, Light, light_on
from qemu import INSTRUCTIONS_PER_CYCLE, QemuSimulator

pytestmark = pytest.mark.only_on("CONFIG_BOARD_MPS2_AN385")

# docs/boards.md: at 170 MHz, and two cycles per instruction, a command is done within 2 ms and
# an edge, which delays every other thread, within 50 us.
COMMAND_MAX = 2_000 * 170 // 2
EDGE_MAX = 50 * 170 // 2
# And a byte that decides nothing within the time of one at 921 600 baud: start, eight, stop.
BYTE_MAX = 170_000_000 // 92_160 // 2

# A COMMAND_LONG of MAVLink 2 without its last byte, which is 0 and so is cut off: 10 bytes of
# header, 32 of payload, 2 of checksum.
COMMAND_BYTES = 44

# Of a strobe, in cycles of 25 MHz: no multiple of the other threads' periods.
PERIOD_S = 0.097
EDGES_APART = 97_000 * 25 // 2
EDGES = 20
TICK = 2_500


def spans(sim: QemuSimulator) -> list[int]:
    """Instructions of each time that the guest was awake."""
    return [(idle - woke) * INSTRUCTIONS_PER_CYCLE for woke, idle in sim.busy]


@pytest.fixture
def light(sim: QemuSimulator) -> Light:
    found = light_on(sim)
    sim.tick = 1
    sim.advance(510_000)  # away from the instants of streams
    return found


def test_clock_counts_what_stepping_counts(sim: QemuSimulator, light: Light) -> None:
    sim.busy.clear()
    light.mav.link.send(b"\0")
    sim.advance(0)
    (counted,) = spans(sim)
    light.mav.link.send(b"\0")
    longer = counted - sim.step()
    assert -INSTRUCTIONS_PER_CYCLE < longer < 2 * INSTRUCTIONS_PER_CYCLE


@pytest.mark.parametrize("command", ["on", "configure", "request"])
def test_command(sim: QemuSimulator, light: Light, command: str) -> None:
    sim.busy.clear()
    if command == "request":
        light.mav.send_command_long(REQUEST_MESSAGE, STATUS)
        sim.advance(0)
    else:
        assert (light.on() if command == "on" else light.configure(50)) == ACCEPTED
    each = spans(sim)
    assert len(each) == COMMAND_BYTES, "one interrupt per byte, and none besides"
    *first, last = each
    byte = median_low(first)
    print(f"{command}: {sum(each)} = {sum(first)} for {len(first)} bytes + {last} for the last")
    print(f"a byte that decides nothing: {byte}; most that one took: {max(first)}")
    assert 0 < byte < BYTE_MAX
    assert 0 < sum(each) < COMMAND_MAX


def _edges(sim: QemuSimulator) -> list[int]:
    """Instructions of the wakes that lie half a period apart."""
    counts = spans(sim)
    woke = [at for at, _ in sim.busy]
    for start in woke:
        grid = [start + k * EDGES_APART for k in range(EDGES)]
        found = [[i for i, at in enumerate(woke) if abs(at - due) <= TICK] for due in grid]
        if all(found):
            return [counts[indices[0]] for indices in found]
    raise AssertionError("no edges")


def test_strobe_edge(sim: QemuSimulator, light: Light) -> None:
    assert light.configure(brightness=50, period_s=PERIOD_S, duty=50) == ACCEPTED
    assert light.on() == ACCEPTED
    sim.busy.clear()
    sim.advance(s=2)
    edges = _edges(sim)
    print(f"edge: {median_low(edges)}, {min(edges)} to {max(edges)} with what else was due")
    assert 0 < median_low(edges) < EDGE_MAX
