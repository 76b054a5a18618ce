# SPDX-License-Identifier: Apache-2.0
"""What a requirement is. Each is a function that talks to a light over its profile's bench, with
its number, its level and its clause; its docstring says why, and what is sent and looked at."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

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
    run: Callable[[Any], None]

    @property
    def group(self) -> str:
        return self.id.partition("-")[0]

    @property
    def url(self) -> str:
        return self.page if "://" in self.page else GUIDE + self.page

    @property
    def explanation(self) -> str:
        return inspect.cleandoc(self.run.__doc__ or "")


Check = Callable[[Any], None]

# Those of MAVLink, in the order in which they run; and those of each profile.
REQUIREMENTS: list[Requirement] = []
PROFILES: dict[str, list[Requirement]] = {"mavlink": REQUIREMENTS, "dronecan": [], "imc": []}
GROUPS: dict[str, str] = {}


def group(prefix: str, title: str) -> None:
    GROUPS[prefix] = title


def requirement(
    id: str, level: Level, title: str, clause: str, page: str, profile: str = "mavlink"
) -> Callable[[Any], Any]:
    """Makes a function the check of a requirement. title: what a light does; page: below GUIDE, or
    a whole URL."""

    def register(run: Any) -> Any:
        assert id.partition("-")[0] in GROUPS
        assert all(known.id != id for rows in PROFILES.values() for known in rows)
        PROFILES[profile].append(Requirement(id, level, title, clause, page, run))
        return run

    return register


def requirements_of(profile: str) -> list[Requirement]:
    """Those of that profile. The DSDL definitions take a while to load: only when asked for."""
    if not PROFILES[profile]:
        importlib.import_module(f".{profile}", __package__)
    return PROFILES[profile]
