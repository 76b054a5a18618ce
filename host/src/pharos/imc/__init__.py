# SPDX-License-Identifier: Apache-2.0
"""IMC: messages by name, packets to and from bytes."""

from __future__ import annotations

from .codec import (
    ALL_ENTITIES,
    EVERYONE,
    ImcError,
    Message,
    Packet,
    Stream,
    decode,
    encode,
    message,
)
from .peer import DatagramLink, ImcPeer
from .table import KINDS, Kind

__all__ = [
    "ALL_ENTITIES",
    "EVERYONE",
    "KINDS",
    "DatagramLink",
    "ImcError",
    "ImcPeer",
    "Kind",
    "Message",
    "Packet",
    "Stream",
    "decode",
    "encode",
    "message",
]
