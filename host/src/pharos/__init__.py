# SPDX-License-Identifier: Apache-2.0
"""The host's side of the Pharos light: links, a MAVLink client, and the simulator in lock-step."""

from __future__ import annotations

from .connection import MavlinkConnection, Source, Target
from .dialect import find_dialect, load_dialect
from .errors import (
    DialectError,
    LinkError,
    PharosError,
    RefusedError,
    SilentError,
    SimulatorError,
    UrlError,
)
from .link import Link, Pacer, RealPacer, open_link
from .sim import Edge, Simulator, Wire
from .vcd import Signal, read_vcd

__all__ = [
    "DialectError",
    "Edge",
    "Link",
    "LinkError",
    "MavlinkConnection",
    "Pacer",
    "PharosError",
    "RealPacer",
    "RefusedError",
    "Signal",
    "SilentError",
    "Simulator",
    "SimulatorError",
    "Source",
    "Target",
    "UrlError",
    "Wire",
    "find_dialect",
    "load_dialect",
    "open_link",
    "read_vcd",
]
