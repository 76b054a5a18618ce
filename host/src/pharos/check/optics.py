# SPDX-License-Identifier: Apache-2.0
"""What comes out of the lamp, where a sensor sees it (--photodiode)."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import fmean, pstdev

from ..light import MODE_INTERNAL
from ..photodiode import Photodiode, Sample
from .bench import DIM, Bench
from .lamp import taken
from .spec import COMMON, NotOffered, expect, group, requirement
from .spec import Level as Need

PAGE = COMMON + "MAV_CMD_DO_ILLUMINATOR_CONFIGURE"
CONFIGURE = "MAV_CMD_DO_ILLUMINATOR_CONFIGURE"
# How long a steady state is looked at, and how long the lamp has to get there [µs].
LOOK_US = 1_000_000
SETTLE_US = 300_000
SAMPLES_MIN = 20
# What the sensor must tell apart: on and off, in terms of its noise.
CONTRAST = 4.0
PERIODS = 6
TOLERANCE = 0.05

group("OP", "The lamp itself (with --photodiode)")


@dataclass(frozen=True)
class Seen:
    dark: float
    bright: float

    @property
    def threshold(self) -> float:
        return (self.dark + self.bright) / 2


def sensor_of(bench: Bench) -> Photodiode:
    if bench.photodiode is None:
        raise NotOffered("no sensor was given (--photodiode)")
    return bench.photodiode


def look(bench: Bench, us: int = LOOK_US) -> list[Sample]:
    """The samples of that time, once the lamp has settled."""
    sensor = sensor_of(bench)
    bench.listen(SETTLE_US)
    sensor.take()
    bench.listen(us)
    samples = sensor.take()
    if len(samples) < SAMPLES_MIN:
        raise NotOffered(f"the sensor gave {len(samples)} samples in {us / 1e6:g} s")
    bench.note(f"← {len(samples)} samples, mean {fmean(level for _, level in samples):g}")
    return samples


def levels(bench: Bench) -> Seen:
    """What the sensor says of off and on."""
    sensor_of(bench)
    bench.dim()
    dark = [level for _, level in look(bench)]
    bench.lit()
    bright = [level for _, level in look(bench)]
    seen = Seen(fmean(dark), fmean(bright))
    noise = max(pstdev(dark), 1e-9)
    expect(
        seen.bright - seen.dark > CONTRAST * noise,
        f"off: {seen.dark:g}, on at {DIM:g} %: {seen.bright:g}, noise {noise:g}",
    )
    return seen


def strobe(bench: Bench, duty: float) -> tuple[float, list[Sample], Seen]:
    """The period that was set, and what was seen over PERIODS of it."""
    seen = levels(bench)
    low, high = bench.periods()
    period = min(max(low, 0.5), high)
    taken(bench, MODE_INTERNAL, DIM, period, duty)
    samples = look(bench, round((PERIODS + 1) * period * 1e6))
    spacing = (samples[-1][0] - samples[0][0]) / (len(samples) - 1)
    if spacing > period / 20:
        raise NotOffered(f"a sample each {spacing:.3f} s is too slow for {period:g} s")
    return period, samples, seen


@requirement("OP-1", Need.MUST, "is lit when it is on, and dark when it is off",
             "MAV_CMD_ILLUMINATOR_ON_OFF", COMMON + "MAV_CMD_ILLUMINATOR_ON_OFF")  # fmt: skip
def is_lit(bench: Bench) -> None:
    """Off, then on at 5 %: the sensor sees more, by four times its noise at least."""
    levels(bench)


@requirement("OP-2", Need.MUST, "strobes with the period that was set", f"{CONFIGURE}, param 3",
             PAGE)  # fmt: skip
def period_seen(bench: Bench) -> None:
    """0.5 s (or the nearest that it has) at a duty cycle of 50 %: from one beginning of a flash to
    the next it is that, to within 5 %."""
    period, samples, seen = strobe(bench, 50)
    rises = [
        b[0] for a, b in zip(samples, samples[1:], strict=False) if a[1] <= seen.threshold < b[1]
    ]
    expect(len(rises) >= 3, f"{len(rises)} flashes in {PERIODS + 1} periods of {period:g} s")
    mean = (rises[-1] - rises[0]) / (len(rises) - 1)
    expect(abs(mean / period - 1) <= TOLERANCE, f"{period:g} s set, {mean:.4f} s seen")


@requirement("OP-3", Need.MUST, "is lit for the duty cycle that was set", f"{CONFIGURE}, param 4",
             PAGE)  # fmt: skip
def duty_seen(bench: Bench) -> None:
    """0.5 s at 25 %: over whole periods the sensor sees light for 25 % of the time, to within 5 %
    of the period."""
    period, samples, seen = strobe(bench, 25)
    end = samples[0][0] + PERIODS * period
    whole = [level for at, level in samples if at < end]
    lit = sum(level > seen.threshold for level in whole) / len(whole)
    expect(abs(lit - 0.25) <= TOLERANCE, f"25 % set, {100 * lit:.1f} % seen")


@requirement("OP-4", Need.MUST, "is steady where no strobe was set",
             f"{CONFIGURE}, params 3 and 4", PAGE)  # fmt: skip
def steady(bench: Bench) -> None:
    """Period 0, and a duty cycle of 100 %: the sensor sees light all the time."""
    seen = levels(bench)
    low, high = bench.periods()
    period = min(max(low, 0.5), high)
    for values in ((0.0, 50.0), (period, 100.0)):
        taken(bench, MODE_INTERNAL, DIM, *values)
        samples = look(bench, round(2 * period * 1e6))
        dark = sum(level <= seen.threshold for _, level in samples)
        expect(dark == 0, f"{values[0]:g} s at {values[1]:g} %: {dark} samples are dark")


@requirement("OP-5", Need.SHOULD, "is brighter the more brightness is set",
             f"{CONFIGURE}, param 2", PAGE)  # fmt: skip
def grows(bench: Bench) -> None:
    """1 %, 3 % and 5 %: the sensor sees more each time."""
    sensor_of(bench)
    bench.lit()
    means = []
    for brightness in (1.0, 3.0, 5.0):
        taken(bench, MODE_INTERNAL, brightness, 0, 0)
        means.append(fmean(level for _, level in look(bench)))
    expect(means[0] < means[1] < means[2], f"it sees {', '.join(f'{m:g}' for m in means)}")
