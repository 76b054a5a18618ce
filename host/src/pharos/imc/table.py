# SPDX-License-Identifier: Apache-2.0
"""The IMC messages that a Pharos light speaks, by their specification (IMC 5.4.31), in wire order.

Written down independently of the firmware's own table, so that each checks the other.
"""

from __future__ import annotations

from dataclasses import dataclass

_TABLE = """
1 EntityState state:u8 flags:u8 description:text
2 QueryEntityState
3 EntityInfo id:u8 label:text component:text act_time:u16 deact_time:u16
4 QueryEntityInfo id:u8
5 EntityList op:u8 list:text
14 EntityActivationState state:u8 error:text
15 QueryEntityActivationState
150 Heartbeat
151 Announce sys_name:text sys_type:u8 owner:u16 lat:f64 lon:f64 height:f32 services:text
152 AnnounceService service:text service_type:u8
300 CameraZoom id:u8 zoom:u8 action:u8
301 SetThrusterActuation id:u8 value:f32
302 SetServoPosition id:u8 value:f32
303 SetControlSurfaceDeflection id:u8 angle:f32
304 RemoteActionsRequest op:u8 actions:text
305 RemoteActions actions:text
306 ButtonEvent button:u8 value:u8
307 LcdControl op:u8 text:text
308 PowerOperation op:u8 time_remain:f32 sched_time:f64
309 PowerChannelControl name:text op:u8 sched_time:f64
310 QueryPowerChannelState
311 PowerChannelState name:text state:u8
312 LedBrightness name:text value:u8
313 QueryLedBrightness name:text
314 SetLedBrightness name:text value:u8
315 SetPWM id:u8 period:u32 duty_cycle:u32
316 PWM id:u8 period:u32 duty_cycle:u32
801 EntityParameter name:text value:text
802 EntityParameters name:text params:list
803 QueryEntityParameters name:text visibility:text scope:text
804 SetEntityParameters name:text params:list
805 SaveEntityParameters name:text
2000 GpioState name:text value:u8
2001 GpioStateGet name:text
2002 GpioStateSet name:text value:u8
2021 VersionInfo op:u8 version:text description:text
"""


@dataclass(frozen=True)
class Field:
    """A field and how it lies on the wire: u8, u16, u32, f32, f64, text, or a list of messages."""

    name: str
    kind: str


@dataclass(frozen=True)
class Kind:
    """A kind of message."""

    id: int
    name: str
    fields: tuple[Field, ...]


def _parse(line: str) -> Kind:
    number, name, *fields = line.split()
    return Kind(int(number), name, tuple(Field(*field.split(":")) for field in fields))


KINDS = tuple(_parse(line) for line in _TABLE.strip().splitlines())
BY_ID = {kind.id: kind for kind in KINDS}
BY_NAME = {kind.name: kind for kind in KINDS}
