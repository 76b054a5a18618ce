# SPDX-License-Identifier: Apache-2.0
"""Runs requirements on a light, and leaves the light as it was, but off."""

from __future__ import annotations

import fnmatch
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from ..connection import MavlinkConnection, Target
from ..errors import PharosError, UsageError
from ..light import COMMAND_CONFIGURE, COMMAND_ON_OFF, TYPE_ILLUMINATOR, TYPE_STATION
from ..photodiode import Photodiode
from .bench import Bench, Settings
from .intervals import SET_INTERVAL
from .spec import REQUIREMENTS, Failed, Level, NotOffered, Requirement

PASSED, FAILED, SKIPPED, NOT_RUN = OUTCOMES = ("passed", "failed", "not offered", "not run")
ILLUMINATOR = 243
FIND_US = 5_000_000
LEAVE_TRIES = 5


@dataclass(frozen=True)
class Result:
    requirement: Requirement
    outcome: str
    seen: str = ""
    log: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def breaks(self) -> bool:
        """Whether the light fails for it."""
        return self.outcome == FAILED and self.requirement.level == Level.MUST


@dataclass
class Report:
    """What came of it. `left`: what could not be put back as it was."""

    link: str
    target: Target | None = None
    device: str = ""  # whom it addresses, for people
    maker: str = ""
    started: float = field(default_factory=time.time)
    results: list[Result] = field(default_factory=list)
    left: str = ""

    @property
    def passed(self) -> bool:
        return not self.left and not any(result.breaks for result in self.results)

    def count(self, outcome: str, level: Level | None = None) -> int:
        return sum(
            r.outcome == outcome and level in (None, r.requirement.level) for r in self.results
        )

    def broken(self) -> list[str]:
        """The musts that the light breaks."""
        return [result.requirement.id for result in self.results if result.breaks]

    def summary(self) -> str:
        parts = []
        for level in (Level.MUST, Level.SHOULD):
            counts = ((self.count(outcome, level), outcome) for outcome in OUTCOMES)
            shown = [f"{count} {outcome}" for count, outcome in counts if count]
            parts.append(f"{level.value}: {', '.join(shown) or 'none'}")
        return "; ".join(parts)


def selected(
    only: Sequence[str] = (),
    skip: Sequence[str] = (),
    requirements: Sequence[Requirement] = REQUIREMENTS,
) -> list[Requirement]:
    """By ids, groups or patterns (`CF-*`), ignoring case. UsageError: one that fits nothing."""
    for pattern in [*only, *skip]:
        if not any(_fits(requirement, pattern) for requirement in requirements):
            raise UsageError(f"'{pattern}' is no requirement; --list lists them")
    return [
        r
        for r in requirements
        if (not only or any(_fits(r, p) for p in only)) and not any(_fits(r, p) for p in skip)
    ]


def _fits(requirement: Requirement, pattern: str) -> bool:
    pattern = pattern.upper()
    return pattern == requirement.group or fnmatch.fnmatchcase(requirement.id, pattern)


def find(connection: MavlinkConnection, wanted: Target | None, timeout_us: int = FIND_US) -> Target:
    """The light: who says that it is one; else who has its component id; else the only one who is
    there and no station. wanted: that one, if anything comes from it. SilentError: none."""
    seen: dict[Target, int] = {}
    end = connection.pacer.now_us() + timeout_us
    beat = connection.pacer.now_us()
    while connection.pacer.now_us() < end:
        if connection.pacer.now_us() >= beat and connection.link.can_send():
            connection.heartbeat()
            beat += 1_000_000
        connection.pacer.pump(min(20_000, end - connection.pacer.now_us()))
        for message in connection.drain():
            source = Target(message.get_srcSystem(), message.get_srcComponent())
            if message.get_type() == "HEARTBEAT" and message.type != TYPE_STATION:
                seen[source] = int(message.type)
            if source == wanted or (wanted is None and seen.get(source) == TYPE_ILLUMINATOR):
                return source
    fallback = [source for source in seen if source.component == ILLUMINATOR]
    if wanted is None and (fallback or len(seen) == 1):
        return (fallback or list(seen))[0]
    who = f"component {wanted.system}/{wanted.component}" if wanted else "illuminator"
    others = ", ".join(f"{s.system}/{s.component}" for s in seen)
    heard = f"; heard {others}" if others else ""
    raise connection.silence(f"no {who} was heard within {timeout_us / 1e6:g} s{heard}")


def check(
    connection: MavlinkConnection,
    requirements: Iterable[Requirement] = REQUIREMENTS,
    *,
    key: bytes = b"",
    photodiode: Photodiode | None = None,
    on_result: Callable[[Result], None] = lambda _: None,
) -> Report:
    """Runs them on the light that the connection addresses. Whatever happens, also an interrupt,
    the light is then switched off and has its settings back. LinkError: the link failed."""
    if connection.hears_signed() and not key:
        raise connection.silence("")
    connection.take_all()
    bench = Bench(connection, key, photodiode)
    target = connection.target
    who = f"component {target.system}/{target.component}"
    report = Report(str(connection.link), target, who)
    before = _settings(bench)
    try:
        for requirement in requirements:
            result = run_one(bench, requirement, report)
            report.results.append(result)
            on_result(result)
        report.maker = _maker(bench)
    finally:
        report.left = _leave(bench, before) or report.left
    return report


class AnyBench(Protocol):
    """What running a requirement needs, whatever the profile."""

    @property
    def log(self) -> list[str]: ...

    def begin(self) -> None: ...

    def now(self) -> int: ...

    def is_silent(self) -> bool: ...

    def listen(self, us: int) -> Any: ...


def run_one(bench: AnyBench, requirement: Requirement, report: Report) -> Result:
    if report.left:
        return Result(requirement, NOT_RUN, report.left)
    bench.begin()
    start = bench.now()
    outcome, seen = PASSED, ""
    try:
        requirement.run(bench)
    except NotOffered as reason:
        outcome, seen = SKIPPED, str(reason)
    except Failed as reason:
        outcome, seen = FAILED, str(reason)
        if bench.is_silent():
            bench.listen(3_000_000)
        if bench.is_silent():
            report.left = "the light has fallen silent"
    seconds = (bench.now() - start) / 1e6
    return Result(requirement, outcome, seen, tuple(bench.log), seconds)


def _settings(bench: Bench) -> Settings | None:
    try:
        return bench.settings()
    except Failed:
        return None


def _maker(bench: Bench) -> str:
    try:
        message = bench.request(396, "COMPONENT_INFORMATION_BASIC")
    except Failed:
        return ""
    names = (message.vendor_name, message.model_name, message.software_version)
    return " ".join(str(name).rstrip("\0") for name in names).strip()


def _leave(bench: Bench, before: Settings | None) -> str:
    """Off, with its settings and its default rate. What could not be put back; "": nothing."""
    try:
        # Off comes first: these settings may be bright.
        bench.command(COMMAND_ON_OFF, 0)
        bench.command(SET_INTERVAL, 440, 0)
        if before is not None:
            values = (before.brightness, before.strobe_period, before.strobe_duty_cycle)
            bench.command(COMMAND_CONFIGURE, before.mode, *values)
        for _ in range(LEAVE_TRIES):
            bench.command(COMMAND_ON_OFF, 0)
            now = _settings(bench)
            if now is not None and not now.enable:
                break
        else:
            return "the light could not be switched off: look after it"
    except PharosError as error:
        return f"the light may be on: {error}"
    if before is None:
        return ""
    wanted = Settings(0, before.mode, *values)
    same = now == wanted or before.mode == 0
    return "" if same else f"its settings were {wanted} and are {now}"
