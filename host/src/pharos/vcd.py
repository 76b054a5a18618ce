# SPDX-License-Identifier: Apache-2.0
"""Reads value change dumps (IEEE 1364-2005, clause 18), as `--record` writes them."""

from __future__ import annotations

import os
import re
from bisect import bisect_right
from dataclasses import dataclass, field
from pathlib import Path

from .errors import PharosError

Value = int | float | str | None

_TIMESCALE_US = {"s": 1e6, "ms": 1e3, "us": 1.0, "ns": 1e-3, "ps": 1e-6, "fs": 1e-9}


@dataclass
class Signal:
    """Changes in order of time; equal times keep the file's order."""

    name: str
    kind: str
    width: int
    times_us: list[float] = field(default_factory=list)
    values: list[Value] = field(default_factory=list)

    def at(self, time_us: float) -> Value:
        """The value in force at `time_us`, after all its changes at that time; None before any."""
        index = bisect_right(self.times_us, time_us)
        return self.values[index - 1] if index else None


def read_vcd(path: str | os.PathLike[str]) -> dict[str, Signal]:
    """Signals by name (innermost scope's name only). PharosError if the file is malformed."""
    text = Path(path).read_text(encoding="ascii")
    head, separator, body = text.partition("$enddefinitions")
    if not separator:
        raise PharosError(f"{path}: no $enddefinitions")
    scale = re.search(r"\$timescale\s+(\d+)\s*(\w+)\s+\$end", head)
    if scale is None or scale[2] not in _TIMESCALE_US:
        raise PharosError(f"{path}: no valid $timescale")
    unit_us = int(scale[1]) * _TIMESCALE_US[scale[2]]
    signals: dict[str, Signal] = {}
    by_code: dict[str, Signal] = {}
    for kind, width, code, name in re.findall(
        r"\$var\s+(\w+)\s+(\d+)\s+(\S+)\s+(\S+)(?:\s+\[[^]]*\])?\s+\$end", head
    ):
        signal = by_code.setdefault(code, Signal(name, kind, int(width)))
        signals[name] = signal
    _read_changes(path, body, unit_us, by_code)
    return signals


def _read_changes(
    path: str | os.PathLike[str], body: str, unit_us: float, by_code: dict[str, Signal]
) -> None:
    now = 0.0
    for number, line in enumerate(body.splitlines()[1:], start=1):
        word = line.strip()
        if not word or word.startswith("$"):
            continue
        if word[0] == "#":
            later = int(word[1:]) * unit_us
            if later < now:
                raise PharosError(f"{path}: change line {number}: time runs backwards")
            now = later
            continue
        value, code = _split_change(word)
        signal = by_code.get(code)
        if signal is None:
            raise PharosError(f"{path}: change line {number}: '{code}' was not declared")
        signal.times_us.append(now)
        signal.values.append(_decode(value))


def _split_change(word: str) -> tuple[str, str]:
    if word[0] in "bBrRsS":
        value, _, code = word.partition(" ")
        return value, code.strip()
    return word[0], word[1:]


def _decode(value: str) -> Value:
    first = value[0].lower()
    if first == "r":
        return float(value[1:])
    if first == "s":
        return value[1:]
    bits = value[1:] if first == "b" else value
    return int(bits, 2) if set(bits) <= {"0", "1"} else None
