# SPDX-License-Identifier: Apache-2.0
"""What a requirement is. Each is a function that talks to a light over a Bench, with its number,
its level and its clause; the function's docstring says why, and what is sent and looked at."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .bench import Bench

GUIDE = "https://mavlink.io/en/"
COMMON = "messages/common.html#"


class Level(Enum):
    """As in RFC 2119. Only a must that fails makes a light fail."""

    MUST = "must"
    SHOULD = "should"
    MAY = "may"


class Failed(Exception):
    """The light does not do it. The text says what was seen."""


class NotOffered(Exception):
    """The requirement has no object here. The text says why."""


def expect(condition: bool, seen: str) -> None:
    """Failed, with what was seen instead, unless the condition holds."""
    if not condition:
        raise Failed(seen)


@dataclass(frozen=True)
class Requirement:
    id: str
    level: Level
    title: str
    clause: str
    page: str
    run: Callable[[Bench], None]

    @property
    def group(self) -> str:
        return self.id.partition("-")[0]

    @property
    def url(self) -> str:
        return GUIDE + self.page

    @property
    def explanation(self) -> str:
        return inspect.cleandoc(self.run.__doc__ or "")


Check = Callable[["Bench"], None]

# In the order in which they run.
REQUIREMENTS: list[Requirement] = []
GROUPS: dict[str, str] = {}


def group(prefix: str, title: str) -> None:
    GROUPS[prefix] = title


def requirement(
    id: str, level: Level, title: str, clause: str, page: str
) -> Callable[[Check], Check]:
    """Makes a function the check of a requirement. title: what a light does; page: below GUIDE."""

    def register(run: Check) -> Check:
        assert id.partition("-")[0] in GROUPS
        assert all(known.id != id for known in REQUIREMENTS)
        REQUIREMENTS.append(Requirement(id, level, title, clause, page, run))
        return run

    return register
