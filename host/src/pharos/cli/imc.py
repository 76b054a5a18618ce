# SPDX-License-Identifier: Apache-2.0
"""`pharos imc`: what an IMC node says, and messages to it."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from typing import Any

from ..errors import UsageError
from ..imc import EVERYONE, KINDS, ImcPeer, Message, Packet, message
from ..link import RealPacer, open_link
from .shell import Printer

PUMP_US = 100_000
KINDS_BY_NAME = {kind.name.lower(): kind for kind in KINDS}


def plain(value: Any) -> Any:
    """A field's value for people, and for JSON."""
    if isinstance(value, bytes):
        return value.decode(errors="backslashreplace")
    if isinstance(value, list):
        return [{name: plain(v) for name, v in item.fields.items()} for item in value]
    return value


def show(packet: Packet, printer: Printer) -> None:
    fields = {name: plain(value) for name, value in packet.message.fields.items()}
    text = " ".join(f"{name}={value!r}" for name, value in fields.items())
    where = f"{packet.src:04x}/{packet.src_ent} > {packet.dst:04x}/{packet.dst_ent}"
    printer.fields(
        f"{where}  {packet.name} {text}".rstrip(),
        name=packet.name,
        src=packet.src,
        src_ent=packet.src_ent,
        dst=packet.dst,
        dst_ent=packet.dst_ent,
        timestamp=packet.timestamp,
        fields=fields,
    )


def parse_message(name: str, words: Sequence[str]) -> Message:
    """A message from the command line: `SetLedBrightness`, `name=lamp value=128`."""
    kind = KINDS_BY_NAME.get(name.lower())
    if kind is None:
        raise UsageError(f"'{name}' is no message; {', '.join(k.name for k in KINDS)} are")
    kinds = {field.name: field.kind for field in kind.fields}
    fields: dict[str, Any] = {}
    for word in words:
        field, equals, text = word.partition("=")
        if not equals or field not in kinds:
            known = ", ".join(kinds) or "none"
            raise UsageError(f"'{word}' is no FIELD=VALUE of {kind.name}; its fields: {known}")
        fields[field] = _parse_value(field, kinds[field], text)
    return message(kind.name, **fields)


def _parse_value(field: str, kind: str, text: str) -> Any:
    try:
        if kind == "text":
            return text
        if kind == "list":
            pairs = [item.partition("=") for item in text.split(",") if item]
            return [message("EntityParameter", name=n, value=v) for n, _, v in pairs]
        return float(text) if kind.startswith("f") else int(text, 0)
    except ValueError:
        raise UsageError(f"{field}: '{text}' is no number") from None


def run_monitor(args: argparse.Namespace, printer: Printer) -> None:
    with open_link(args.url) as link:
        peer = ImcPeer(link, RealPacer([link]), id=args.own)
        end = None if args.seconds is None else time.monotonic() + args.seconds
        shown = 0
        # A light that listens on UDP or TCP sends to those that it has heard.
        heard = 0.0
        while end is None or time.monotonic() < end:
            if link.can_send() and time.monotonic() - heard >= 1.0:
                heard = time.monotonic()
                peer.send("Heartbeat", dst=EVERYONE)
            for packet in peer.pass_time(PUMP_US):
                show(packet, printer)
                shown += 1
                if shown == args.count:
                    return


def run_send(args: argparse.Namespace, printer: Printer) -> None:
    what = parse_message(args.name, args.fields)
    with open_link(args.url) as link:
        peer = ImcPeer(link, RealPacer([link]), id=args.own)
        packet = Packet(what, peer.id, peer.entity, args.dst, args.dst_ent, time.time())
        link.send(peer.encode(packet))
        end = time.monotonic() + args.seconds
        while time.monotonic() < end:
            for answer in peer.pass_time(PUMP_US):
                if answer.name != "Heartbeat" and answer.dst == peer.id:
                    show(answer, printer)
