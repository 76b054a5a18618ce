# SPDX-License-Identifier: Apache-2.0
"""What others say, made safe to show: a device's text may hold anything, a terminal obeys much."""

from __future__ import annotations

import json
import math
from typing import Any


def printable(text: str) -> str:
    """`text` in one line, with the escape (\\x1b, \\n, \\u202e) of each character that is not
    printable: controls of either set, line separators, what turns the direction of writing."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _escape(c) for c in text)


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")


def json_line(value: Any) -> str:
    """`value` as JSON (RFC 8259) in one line that is safe to show, and the same when read again; a
    number that JSON does not have is null."""
    text = json.dumps(_without_nan(value), ensure_ascii=False)
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else json.dumps(c)[1:-1] for c in text)


def _without_nan(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, dict):
        return {name: _without_nan(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    return value
