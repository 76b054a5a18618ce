# SPDX-License-Identifier: Apache-2.0
"""`pharos update`: new firmware, over DroneCAN or MAVLink FTP."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from dataclasses import replace

from ..errors import PharosError, UrlError, UsageError
from ..link import RealPacer
from ..session import connect
from ..update import (
    NodeUpdater,
    UpdatePhase,
    UpdateProgress,
    read_image,
    update_light,
    update_nodes,
    version_of,
)
from .key import read_key
from .shell import OK, REFUSED, SILENT, Printer

STEP_PERCENT = 10


class Shown:
    """Each device's progress: a line that is written over on a terminal; else a line for each
    phase and each STEP_PERCENT."""

    def __init__(self, printer: Printer) -> None:
        self._printer = printer
        self._is_live = not printer.as_json and sys.stderr.isatty()
        self._last: dict[str, UpdateProgress] = {}
        self._line = ""

    def __call__(self, now: UpdateProgress) -> None:
        last = self._last.get(now.device)
        is_step = (
            last is None
            or last.phase is not now.phase
            or now.phase in (UpdatePhase.DONE, UpdatePhase.FAILED)
            or now.percent // STEP_PERCENT != last.percent // STEP_PERCENT
        )
        self._last[now.device] = replace(now)
        if self._is_live:
            self._write_over(", ".join(map(str, self._last.values())))
        if is_step and (not self._is_live or now.phase in (UpdatePhase.DONE, UpdatePhase.FAILED)):
            self.clear()
            self._printer.fields(str(now), command="update", event="progress", **now.as_fields())

    def _write_over(self, line: str) -> None:
        sys.stderr.write("\r" + line[:160].ljust(len(self._line)))
        sys.stderr.flush()
        self._line = line[:160]

    def clear(self) -> None:
        if self._line:
            self._write_over("")
            sys.stderr.write("\r")
            self._line = ""


def node_urls(url: str) -> list[str]:
    """dronecan:…?node=68,69 as a URL for each node. UrlError: not so."""
    match = re.search(r"([?&]node=)([^&]*)", url)
    if match is None:
        return [url]
    numbers = match[2].split(",")
    if len(set(numbers)) != len(numbers):
        raise UrlError(f"'{url}' names a node twice")
    return [url[: match.start(2)] + number + url[match.end(2) :] for number in numbers]


def run_update(args: argparse.Namespace, printer: Printer) -> int:
    content = read_image(args.file)
    is_can = args.url.startswith("dronecan:")
    if args.via == "dronecan" and not is_can:
        raise UsageError("--via dronecan needs a URL dronecan:INTERFACE/CHANNEL?node=N[,N…]")
    version = version_of(content)
    of = f", version {version}" if version else ""
    printer.fields(
        f"{args.file}: {len(content)} bytes{of}",
        command="update", event="image", size=len(content), version=version or None,
    )  # fmt: skip
    shown = Shown(printer)
    try:
        if is_can and args.via != "mavlink":
            return _update_nodes(args, printer, content, shown)
        return _update_light(args, content, shown)
    finally:
        shown.clear()


def _update_light(args: argparse.Namespace, content: bytes, shown: Shown) -> int:
    key = read_key(args.key_file)
    with connect(args.url, target=args.target, key=key, timeout_s=args.timeout) as light:
        update_light(light, content, shown, force=args.force, patience_us=_patience_us(args))
    return OK


def _update_nodes(args: argparse.Namespace, printer: Printer, content: bytes, shown: Shown) -> int:
    from ..can_node import CanPort, DronecanNode, open_bus
    from ..tunnel import parse_tunnel_url

    if args.key_file:
        raise UsageError("DroneCAN has no signatures: --via mavlink, or without --key-file")
    parsed = [parse_tunnel_url(url) for url in node_urls(args.url)]
    bus = parsed[0]
    options = {} if bus.bitrate is None else {"bitrate": bus.bitrate}
    port = CanPort(open_bus(bus.interface, bus.channel, fd=bus.fd, **options))
    try:
        pacer = RealPacer([port])
        node = DronecanNode(port, pacer.now_us, bus.own, fd=bus.fd)
        updater = NodeUpdater(
            node, content, [url.node for url in parsed], shown,
            patience_us=_patience_us(args), absent_us=round(args.timeout * 1e6),
        )  # fmt: skip
        return _code(update_nodes(updater, pacer), printer, shown)
    finally:
        port.close()


def _code(all_of_them: Sequence[UpdateProgress], printer: Printer, shown: Shown) -> int:
    failed = [progress for progress in all_of_them if progress.phase is UpdatePhase.FAILED]
    if not failed:
        return OK
    shown.clear()
    names = ", ".join(f"{progress.device} {progress.text}" for progress in failed)
    error = PharosError(f"{len(failed)} of {len(all_of_them)} not updated: {names}")
    printer.error(error, "update")
    return SILENT if all(progress.is_silent for progress in failed) else REFUSED


def _patience_us(args: argparse.Namespace) -> int:
    return round(float(args.patience) * 1e6)
