# SPDX-License-Identifier: Apache-2.0
"""Draw docs/heat.svg: an hour in the life of the lamp, from a recording of the simulated board.

The lamp is told to be at 100 % throughout. The place gets hot, then the fan fails, then both get
well again. `make picture` runs this.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("svg")

import matplotlib.pyplot as plt

from pharos import Signal, Simulator, find_dialect, load_dialect, read_vcd

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "native"
MINUTE_US = 60_000_000
END_MIN = 60
STEP_S = 4
ON_OFF = 405

# What happens when [min], and how it is labelled.
EVENTS = ((10, "55 °C around it"), (25, "fan fails"), (35, "fan back"), (47, "25 °C again"))


def record(vcd: Path) -> None:
    dialect = load_dialect(find_dialect(BUILD))
    options = ["--record", str(vcd), "--ambient", "25"]
    wires = {"uart0": "udpin:127.0.0.1:0"}
    with Simulator(BUILD / "pharos", wires, options=options, dialect=dialect) as light:
        client = light.connect("uart0")
        client.heartbeat()
        light.advance(s=1)
        client.command_long(ON_OFF, 1)
        at_min = 0
        changes = (
            lambda: light.set_ambient(55),
            lambda: light.set_fan(False),
            lambda: light.set_fan(True),
            lambda: light.set_ambient(25),
        )
        for (minute, _), change in zip(EVENTS, changes, strict=True):
            light.advance((minute - at_min) * MINUTE_US)
            change()
            at_min = minute
        light.advance((END_MIN - at_min) * MINUTE_US)


def sampled(signal: Signal, scale: float) -> list[float]:
    """The signal's value at every STEP_S of the hour."""
    values = []
    for second in range(0, END_MIN * 60, STEP_S):
        value = signal.at(second * 1e6)
        values.append(float(value) * scale if isinstance(value, int | float) else 0.0)
    return values


def draw(signals: dict[str, Signal], out: Path) -> None:
    minutes = [second / 60 for second in range(0, END_MIN * 60, STEP_S)]
    plt.rcParams.update({"font.size": 10, "svg.hashsalt": "pharos"})
    figure, (heat, light) = plt.subplots(
        2, 1, sharex=True, figsize=(9, 5), gridspec_kw={"height_ratios": (3, 2)}
    )
    heat.plot(minutes, sampled(signals["temp_mdegc"], 1e-3), color="#c0392b", linewidth=1.6)
    for level, label in ((80, "throttling from"), (100, "shutdown at"), (70, "on again below")):
        heat.axhline(level, color="#7f8c8d", linewidth=0.8, linestyle=":")
        heat.text(0.4, level + 1, f"{label} {level} °C", color="#566573", fontsize=8)
    heat.set_ylabel("temperature [°C]")
    heat.set_ylim(20, 118)
    light.fill_between(
        minutes, sampled(signals["level_ppm"], 1e-4), color="#f1c40f", alpha=0.7, label="lamp"
    )
    light.plot(
        minutes, sampled(signals["limit_ppm"], 1e-4), color="#2c3e50", linewidth=1.2, label="limit"
    )
    light.set_ylabel("full power [%]")
    light.set_xlabel("time [min]")
    light.set_ylim(0, 108)
    light.legend(loc="lower left", framealpha=0.9)
    for minute, label in EVENTS:
        for axes in (heat, light):
            axes.axvline(minute, color="#aab7b8", linewidth=0.8)
        heat.text(minute + 0.4, 112, label, color="#2c3e50", va="center")
    for axes in (heat, light):
        axes.set_xlim(0, END_MIN)
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(out, metadata={"Date": None})


def main() -> int:
    out = Path(__file__).with_suffix(".svg")
    vcd = BUILD / "heat.vcd"
    record(vcd)
    draw(read_vcd(vcd), out)
    print(f"{out.relative_to(ROOT)}: an hour at 100 %, from {vcd.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
