# SPDX-License-Identifier: Apache-2.0
"""The host's side of the Pharos light: links, a MAVLink client, and the simulator in lock-step."""

from __future__ import annotations

from typing import Any

from .connection import MavlinkConnection, Source, Target
from .dialect import find_dialect, load_dialect
from .errors import (
    CommandError,
    DialectError,
    LinkError,
    PharosError,
    RefusedError,
    SilentError,
    SimulatorError,
    UrlError,
    UsageError,
)
from .find import Found, find_lights
from .ftp import FileClient, FileError
from .light import Information, Light, Status
from .link import Link, Pacer, Port, RealPacer, open_link
from .parameters import Parameter, ParameterError, Parameters
from .session import connect
from .sim import Edge, Simulator, Tunnel, Wire
from .update import UpdatePhase, UpdateProgress, update_light
from .vcd import Signal, read_vcd

__all__ = [
    "CommandError",
    "DialectError",
    "Edge",
    "FileClient",
    "FileError",
    "Found",
    "Information",
    "Light",
    "Link",
    "LinkError",
    "MavlinkConnection",
    "Pacer",
    "Parameter",
    "ParameterError",
    "Parameters",
    "PharosError",
    "Port",
    "RealPacer",
    "RefusedError",
    "Signal",
    "SilentError",
    "Simulator",
    "SimulatorError",
    "Source",
    "Status",
    "Target",
    "Tunnel",
    "UpdatePhase",
    "UpdateProgress",
    "UrlError",
    "UsageError",
    "Wire",
    "connect",
    "find_dialect",
    "find_lights",
    "load_dialect",
    "open_link",
    "read_vcd",
    "update_light",
]


def init(mpstate: Any) -> Any:
    """What MAVProxy looks for in a module: `module load pharos`."""
    from .mavproxy import LightModule

    return LightModule(mpstate)
