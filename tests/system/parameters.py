# SPDX-License-Identifier: Apache-2.0
"""What tests need to read and set parameters: INT32, in the bytes of a float."""

from __future__ import annotations

import struct
from typing import Any

from harness import Light
from pharos import MavlinkConnection, Target

# MAV_PARAM_TYPE
INT32 = 6
REAL32 = 9


def as_float(value: int) -> float:
    return float(struct.unpack("<f", struct.pack("<i", value))[0])


def value_of(message: Any) -> int:
    """The INT32 as it lies in the frame: a NaN's bits would not survive Python's floats."""
    assert message.param_type == INT32
    frame = bytes(message.get_msgbuf())
    at = 10 if frame[0] == 0xFD else 6
    return int(struct.unpack_from("<i", frame, at)[0])


def send_set(
    mav: MavlinkConnection,
    name: str,
    value: float,
    kind: int = INT32,
    target: Target | None = None,
) -> None:
    to = target or mav.target
    mav.send(
        mav.dialect.MAVLink_param_set_message(to.system, to.component, name.encode(), value, kind)
    )


def set_param(light: Light, name: str, value: int, **kwargs: Any) -> int:
    """What the light says is in force then."""
    send_set(light.mav, name, as_float(value), **kwargs)
    return value_of(light.mav.recv("PARAM_VALUE", where=lambda m: m.param_id == name))


def ask(light: Light, name: str = "", index: int = -1, target: Target | None = None) -> None:
    to = target or light.mav.target
    light.mav.send(
        light.mav.dialect.MAVLink_param_request_read_message(
            to.system, to.component, name.encode(), index
        )
    )


def get_param(light: Light, name: str) -> int:
    light.mav.drain()
    light.mav.inbox.clear()  # it may tell of changes by others
    ask(light, name)
    return value_of(light.mav.recv("PARAM_VALUE", where=lambda m: m.param_id == name))


def ask_list(mav: MavlinkConnection, target: Target | None = None) -> None:
    to = target or mav.target
    mav.send(mav.dialect.MAVLink_param_request_list_message(to.system, to.component))
