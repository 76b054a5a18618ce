# SPDX-License-Identifier: Apache-2.0
"""What tests need to read and set parameters: REAL32, in the units that people use."""

from __future__ import annotations

import re
import struct
from typing import Any

from harness import ROOT, Light
from pharos import MavlinkConnection, Target
from pharos.parameters import text_of

# MAV_PARAM_TYPE
INT32 = 6
REAL32 = 9


# The page is what the table says (test_parameters_page.py); the gimbal's component has its part.
PAGE = (ROOT / "docs" / "parameters.md").read_text(encoding="utf-8")
ALL = set(re.findall(r"^\| `(\w+)` \|", PAGE, re.MULTILINE))
OF_GIMBAL = {n for n in ALL if n.startswith("GMB_")} - {"GMB_ENABLE", "GMB_COMPID"}
OF_LIGHT = ALL - OF_GIMBAL


def as_float(value: int) -> float:
    """An INT32 in the bytes of a float."""
    return float(struct.unpack("<f", struct.pack("<i", value))[0])


def shortest(value: float) -> float:
    """The decimal that people mean by a 32-bit float."""
    return float(text_of(float(value)))


def value_of(message: Any) -> float:
    assert message.param_type == REAL32
    return shortest(message.param_value)


def send_set(
    mav: MavlinkConnection,
    name: str,
    value: float,
    kind: int = REAL32,
    target: Target | None = None,
) -> None:
    to = target or mav.target
    mav.send(
        mav.dialect.MAVLink_param_set_message(to.system, to.component, name.encode(), value, kind)
    )


def set_param(light: Light, name: str, value: float, **kwargs: Any) -> float:
    """What the light says is in force then."""
    send_set(light.mav, name, value, **kwargs)
    return value_of(light.mav.recv("PARAM_VALUE", where=lambda m: m.param_id == name))


def ask(light: Light, name: str = "", index: int = -1, target: Target | None = None) -> None:
    to = target or light.mav.target
    light.mav.send(
        light.mav.dialect.MAVLink_param_request_read_message(
            to.system, to.component, name.encode(), index
        )
    )


def get_param(light: Light, name: str) -> float:
    light.mav.drain()
    light.mav.inbox.clear()  # it may tell of changes by others
    ask(light, name)
    return value_of(light.mav.recv("PARAM_VALUE", where=lambda m: m.param_id == name))


def ask_list(mav: MavlinkConnection, target: Target | None = None) -> None:
    to = target or mav.target
    mav.send(mav.dialect.MAVLink_param_request_list_message(to.system, to.component))
