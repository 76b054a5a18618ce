# SPDX-License-Identifier: Apache-2.0
"""What may and what must happen at a power-up, from the faults alone: no code of the light, and no
knowledge of it but docs/startup.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from powerup_plan import DURATION_US, MS, SECOND_US, Fault, Plan

# A stall counts after 1 s, looked at every 0.25 s; the watchdog bites within 1 s after that.
NOTICED_US = 1250 * MS
BITE_US = NOTICED_US + 1000 * MS
SLACK_US = 100 * MS
ANSWER_US = 2 * SECOND_US
# Threads report every 0.4 s: one that stalls may have been silent for that long.
STALL_US = (1000 - 400) * MS - SLACK_US
# Samples come every 0.1 s, count as missing after 0.5 s, and a converter has 0.1 s for one.
SAMPLE_US = 100 * MS
MISSING_US = 500 * MS
SAFE_PPM = 100_000


@dataclass
class Answer:
    """What came of an ask: when (None: nothing came within ANSWER_US), and what it said."""

    at_us: int
    what: str
    came_us: int | None
    result: int | None = None


@dataclass
class Seen:
    """What was observed of one power-up."""

    boots_us: list[int] = field(default_factory=list)
    edges: list[tuple[int, int]] = field(default_factory=list)
    levels: list[tuple[int, int]] = field(default_factory=list)
    answers: list[Answer] = field(default_factory=list)
    states: list[tuple[int, int]] = field(default_factory=list)  # MAV_STATE of heartbeats
    faults: dict[Fault, Fault] = field(default_factory=dict)  # as planned, and as it was


class Oracle:
    def __init__(self, plan: Plan, seen: Seen) -> None:
        self.plan = plan
        self.seen = seen
        self.faults = list(seen.faults.values())
        self.wrong: list[str] = []

    def _say(self, at_us: int, text: str) -> None:
        self.wrong.append(f"{at_us / 1e6:.3f} s: {text}")

    # --- facts --------------------------------------------------------------------------------
    def _of(self, device: str, *kinds: str) -> list[Fault]:
        return [f for f in self.faults if f.device == device and (not kinds or f.kind in kinds)]

    def _on(self, at_us: int, device: str, *kinds: str) -> bool:
        return any(fault.is_on(at_us) for fault in self._of(device, *kinds))

    def _met(self, begin_us: int, end_us: int, device: str, *kinds: str) -> bool:
        return any(fault.meets(begin_us, end_us) for fault in self._of(device, *kinds))

    def _boot(self, at_us: int) -> int:
        return max(boot for boot in self.seen.boots_us if boot <= at_us)

    def _lamp_has_started(self, boot_us: int) -> bool:
        chips = ("pwm", "gpio", "watchdog")
        return not any(self._on(boot_us, chip, "error", "never") for chip in chips)

    def _sensor_in_range(self, at_us: int) -> bool:
        return not self._on(at_us, "sensor")

    def _sampled(self, boot_us: int, at_us: int) -> bool:
        """A sample in range may have been taken since the boot."""
        if self._on(boot_us, "adc", "error"):
            return False
        late = [f for f in self._of("adc", "late") if f.delay_us > SAMPLE_US]
        silent = self._of("adc", "never") + late
        if any(fault.is_on(boot_us) for fault in silent):
            return False
        instants = [boot_us, at_us, *(f.end_us for f in self.faults if boot_us < f.end_us <= at_us)]
        return any(
            self._sensor_in_range(instant) and not self._on(instant, "adc", "never", "error")
            for instant in instants
        )

    # --- never lit unsupervised -----------------------------------------------------------------
    def check_light(self) -> None:
        before = 0
        lasting = dict(self.seen.edges)
        for at_us, level in self.seen.edges:
            rises, before = level > before, level
            if not rises:
                continue
            # at the instant of a reset it may have been before or after it
            boots_us = {self._boot(at_us), self._boot(max(at_us - 1, 0))}
            if not any(self._lamp_has_started(boot_us) for boot_us in boots_us):
                self._say(at_us, "lit without watchdog or driver")
            if not any(self._sampled(boot_us, at_us) for boot_us in boots_us):
                self._say(at_us, "lit before the first sample in range")
            # a pulse that was written is taken back at once where the enable line then fails
            fails = self._on(at_us, "pwm", "error", "never") or self._on(at_us, "gpio", "error")
            if fails and lasting[at_us] > 0:
                self._say(at_us, "lit by a driver whose writes fail")
        for at_us, level in self.seen.levels:
            self._check_level(at_us, level)

    def _check_level(self, at_us: int, level: int) -> None:
        """What a sensor that fails leaves, once that is certain."""
        obeys = not any(
            self._met(at_us - 2 * SECOND_US, at_us, chip) for chip in ("pwm", "gpio", "adc")
        ) and not any(f.device.startswith("thread") for f in self.faults)
        # a converter that has not answered in time is not asked again
        obeys &= not self._met(self._boot(at_us), at_us, "adc", "never", "late")
        before_us = at_us - 3 * SAMPLE_US
        hot = self._on(before_us, "sensor", "short", "hot") and self._on(at_us, "sensor")
        opened = self._on(before_us, "sensor", "open") and self._on(at_us, "sensor", "open")
        if obeys and hot and level > 0:
            self._say(at_us, f"{level} ppm while hot")
        if obeys and opened and level > SAFE_PPM:
            self._say(at_us, f"{level} ppm with an open sensor")

    # --- bites ----------------------------------------------------------------------------------
    def _threads_device(self, fault: Fault) -> str | None:
        name = fault.device.removeprefix("thread ")
        if name.startswith("uart_link"):
            return "uart" + name[-1]
        return {"can_link": "can0", "imc_link": "imc"}.get(name)

    def _runs(self, fault: Fault, boot_us: int) -> bool:
        """The thread was started at all: its device has."""
        device = self._threads_device(fault)
        return device is None or not self._on(boot_us, device, "error")

    def _stalls(self, boot_us: int) -> list[tuple[int, int]]:
        """When a watched thread did not run, of those that a boot at boot_us has."""
        stalls = []
        for fault in self.faults:
            if not fault.device.startswith("thread") or not self._runs(fault, boot_us):
                continue
            if fault.kind == "stalled at start" and fault.is_on(boot_us):
                stalls.append((boot_us, fault.end_us))
            elif fault.kind == "stalled" and boot_us <= fault.begin_us:
                stalls.append((fault.begin_us, fault.end_us))
        for fault in self._of("storage", "never"):
            if fault.is_on(boot_us):
                stalls.append((boot_us, DURATION_US))
        for fault in self._of("storage", "late"):
            if fault.is_on(boot_us):
                stalls.append((boot_us, boot_us + fault.delay_us))
        return stalls

    def _unfed(self, boot_us: int) -> list[int]:
        """From when on the watchdog, which was armed, was not fed."""
        if self._on(boot_us, "watchdog", "error", "never"):
            return []
        later = self._of("watchdog", "error", "never")
        return [fault.begin_us for fault in later if fault.begin_us > boot_us]

    def _hangs(self, begin_us: int, end_us: int) -> bool:
        """A driver may have kept the CPU, or a thread, or only a reset could make the lamp dark."""
        chips = ("pwm", "gpio", "counter")
        stuck = all(self._met(begin_us, end_us, chip, "error") for chip in ("pwm", "gpio"))
        return stuck or any(self._met(begin_us, end_us, chip, "never") for chip in chips)

    def _excused(self, boot_us: int, reset_us: int) -> bool:
        stalled = any(
            begin + STALL_US <= reset_us <= end + BITE_US and min(end, reset_us) - begin >= STALL_US
            for begin, end in self._stalls(boot_us)
        )
        unfed = any(begin < reset_us for begin in self._unfed(boot_us))
        runs = self._on(boot_us, "watchdog runs")
        unfed |= runs and self._met(boot_us, reset_us, "watchdog", "late", "never")
        return stalled or unfed or self._hangs(boot_us, reset_us)

    def check_bites(self) -> None:
        boots = [*self.seen.boots_us[1:], DURATION_US]
        for boot_us, next_us in zip(self.seen.boots_us, boots, strict=True):
            if next_us < DURATION_US and not self._excused(boot_us, next_us):
                self._say(next_us, f"a reset without a reason, booted at {boot_us / 1e6:g} s")
            late_us = max((f.delay_us for f in self._of("watchdog", "late")), default=0)
            # a supervisor that hangs in the watchdog's driver resets nothing; the lamp is dark
            hangs = self._on(boot_us, "watchdog", "never")
            for begin, end in [] if hangs else self._stalls(boot_us):
                due_us = begin + BITE_US + late_us + 3 * SLACK_US
                if end > due_us and begin < next_us and due_us < next_us:
                    self._say(due_us, f"no bite of a stall since {begin / 1e6:g} s")
            for begin in self._unfed(boot_us):
                due_us = begin + 1000 * MS + 250 * MS + SLACK_US
                lasts = any(f.begin_us == begin and f.end_us > due_us for f in self.faults)
                if lasts and begin < next_us and due_us < next_us:
                    self._say(due_us, f"no bite of a watchdog unfed since {begin / 1e6:g} s")

    # --- answers --------------------------------------------------------------------------------
    def _reset_in(self, begin_us: int, end_us: int) -> bool:
        return any(begin_us <= boot <= end_us for boot in self.seen.boots_us[1:])

    def _may_be_silent(self, answer: Answer) -> bool:
        begin_us, end_us = answer.at_us, answer.at_us + ANSWER_US
        boot_us = self._boot(begin_us)
        if self._reset_in(begin_us, end_us) or self._hangs(boot_us, end_us):
            return True
        silent: list[Callable[[], bool]] = [lambda: self._met(begin_us, end_us, "thread command")]
        if answer.what != "shell":
            silent += [
                lambda: self._met(begin_us, end_us, "thread uart_link0"),
                lambda: self._met(boot_us, end_us, "uart0", "never", "error"),
                # settings that cannot be read may have held a key: locked (docs/security.md)
                lambda: self._met(boot_us, boot_us, "storage", "never", "late", "error"),
            ]
        else:
            # one that never ran is known to be missing: the shell says so
            silent = [lambda: self._met(begin_us, end_us, "thread command", "stalled")]
        return any(is_so() for is_so in silent)

    def check_answers(self) -> None:
        for answer in self.seen.answers:
            if answer.came_us is None and not self._may_be_silent(answer):
                self._say(answer.at_us, f"no answer to {answer.what} within 2 s")
            if answer.what == "on" and answer.came_us is not None:
                self._check_honest(answer, answer.came_us)

    def _dark_for_sure(self, boot_us: int, at_us: int) -> bool:
        """The lamp cannot be lit, and the light has had the time to know."""
        known_us = boot_us + MISSING_US + 3 * SAMPLE_US
        if at_us < known_us:
            return False
        return not self._lamp_has_started(boot_us) or not self._sampled(boot_us, at_us)

    def _check_honest(self, answer: Answer, came_us: int) -> None:
        boot_us = self._boot(came_us)
        # that nobody samples is known when it is a stall
        known_us = answer.at_us
        if self._met(boot_us, came_us, "thread thermal"):
            known_us -= NOTICED_US
        dark = [self._dark_for_sure(boot_us, at_us) for at_us in (known_us, answer.at_us)]
        if answer.result == 0 and all(dark):
            self._say(came_us, "accepted, and cannot be lit")

    def check_states(self) -> None:
        for at_us, state in self.seen.states:
            boot_us = self._boot(at_us)
            settled = at_us > boot_us + 2 * SECOND_US
            # one that waited in a silent UART is old news
            settled &= not self._met(boot_us, at_us, "uart0")
            dark = [self._dark_for_sure(boot_us, at_us - ago) for ago in (0, SECOND_US)]
            if settled and state == 4 and all(dark):
                self._say(at_us, "heartbeat active while the lamp cannot be lit")

    def check(self) -> list[str]:
        self.check_light()
        self.check_bites()
        self.check_answers()
        self.check_states()
        return self.wrong
