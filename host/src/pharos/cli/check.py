# SPDX-License-Identifier: Apache-2.0
"""`pharos check`: runs the requirements on a light and shows what came of it."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..connection import MavlinkConnection, signing_time
from ..dialect import load_dialect
from ..errors import PharosError, UsageError
from ..link import RealPacer, open_link
from ..photodiode import open_photodiode
from ..text import printable
from .key import read_key

if TYPE_CHECKING:
    from ..check import Report, Requirement, Result
    from .shell import Printer

# How much of a transcript is shown of what fails.
LOG_LINES = 12
STYLES = {"passed": "green", "failed": "red", "not offered": "dim", "not run": "dim"}


def run_check(args: argparse.Namespace, printer: Printer) -> int:
    """The exit code: 0 if no must fails, 1 if one does, 3 if the light fell silent."""
    from .. import check

    console = Console(file=sys.stdout, highlight=False, soft_wrap=True)
    known = check.requirements_of(args.profile)
    chosen = check.selected(args.only, args.skip, known)
    if args.explain:
        explain(check.selected([args.explain], (), known), printer)
        return 0
    if args.list:
        if args.markdown:
            print(check.as_page(), end="")
        else:
            show_list(chosen, printer)
        return 0
    if args.url is None:
        raise UsageError("check: which light? URL is missing; --list needs none")
    progress = Progress(console, args.verbose, quiet=args.json)
    run = {"mavlink": _mavlink, "dronecan": _dronecan, "imc": _imc}[args.profile]
    report = run(args, chosen, progress)
    for path, text in ((args.junit, check.as_junit), (args.html, check.as_html)):
        if path:
            write(path, text(report))
    if args.json:
        printer.fields("", **check.as_object(report))
    else:
        console.print()
        if report.maker:
            console.print(Text(printable(report.maker)), soft_wrap=True)
        style = "green" if report.passed else "red"
        console.print(Text(report.summary(), style=style))
        if report.left:
            console.print(Text(printable(report.left), style="red"))
    if report.count("not run"):
        return 3
    return 0 if report.passed else 1


def _mavlink(args: argparse.Namespace, chosen: list[Requirement], progress: Progress) -> Report:
    from .. import check

    key = read_key(args.key_file)
    with ExitStack() as stack:
        photodiode = None
        if args.photodiode:
            photodiode = open_photodiode(args.photodiode)
            stack.callback(photodiode.close)
        link = stack.enter_context(open_link(args.url))
        connection = MavlinkConnection(link, RealPacer([link]), load_dialect())
        if key:
            connection.sign(key, signing_time())
        connection.target = check.find(connection, args.target, round(args.timeout * 1e6))
        return check.check(connection, chosen, key=key, photodiode=photodiode, on_result=progress)


def _dronecan(args: argparse.Namespace, chosen: list[Requirement], progress: Progress) -> Report:
    from ..can_node import CanPort, DronecanNode, open_bus
    from ..check.dronecan import check_node
    from ..tunnel import parse_tunnel_url

    if not args.url.startswith("dronecan:"):
        raise UsageError("--profile dronecan needs a URL dronecan:INTERFACE/CHANNEL?node=N")
    url = parse_tunnel_url(args.url)
    options = {} if url.bitrate is None else {"bitrate": url.bitrate}
    port = CanPort(open_bus(url.interface, url.channel, fd=url.fd, **options))
    try:
        pacer = RealPacer([port])
        node = DronecanNode(port, pacer.now_us, url.own, fd=url.fd)
        return check_node(node, url.node, pacer, chosen, on_result=progress)
    finally:
        port.close()


def _imc(args: argparse.Namespace, chosen: list[Requirement], progress: Progress) -> Report:
    from ..check.imc import check_imc
    from ..imc import ImcPeer

    with open_link(args.url) as link:
        pacer = RealPacer([link])
        return check_imc(ImcPeer(link, pacer), pacer, chosen, led=args.led, on_result=progress)


class Progress:
    """Shows each result as it comes, and of what fails, what was sent and seen."""

    def __init__(self, console: Console, verbose: bool, quiet: bool) -> None:
        self._console = console
        self._verbose = verbose
        self._quiet = quiet
        self._group = ""

    def __call__(self, result: Result) -> None:
        from ..check.spec import GROUPS

        if self._quiet:
            return
        requirement = result.requirement
        if requirement.group != self._group:
            self._group = requirement.group
            self._console.print(Text(f"\n{GROUPS[self._group]}", style="bold"))
        style = STYLES[result.outcome]
        if result.outcome == "failed" and not result.breaks:
            style = "yellow"
        line = Text(f"  {requirement.id:<7}{requirement.level.value:<8}")
        line.append(f"{result.outcome:<13}", style=style)
        line.append(requirement.title)
        self._console.print(line)
        if result.seen and (result.outcome == "failed" or self._verbose):
            self._console.print(Text(f"{'':30}{printable(result.seen)}", style=style))
        if self._verbose or result.breaks:
            for entry in result.log[-LOG_LINES:]:
                self._console.print(Text(f"{'':30}{printable(entry)}", style="dim"))


def show_list(chosen: list[Requirement], printer: Printer) -> None:
    if printer.as_json:
        for r in chosen:
            printer.fields(
                "", id=r.id, level=r.level.value, title=r.title, clause=r.clause, url=r.url
            )
        return
    table = Table(box=None, pad_edge=False)
    for name in ("id", "level", "the light …", "clause"):
        table.add_column(name, no_wrap=name in ("id", "level"))
    for r in chosen:
        table.add_row(r.id, r.level.value, Text(r.title), Text(r.clause))
    Console(file=sys.stdout, highlight=False).print(table)


def explain(found: list[Requirement], printer: Printer) -> None:
    for r in found:
        lines = [f"{r.id} ({r.level.value}): the light {r.title}", "", *r.explanation.splitlines()]
        lines += ["", r.clause, r.url]
        printer.fields(
            lines, id=r.id, level=r.level.value, title=r.title, clause=r.clause, url=r.url,
            explanation=r.explanation,
        )  # fmt: skip


def write(path: str, text: str) -> None:
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise PharosError(f"{path}: {error.strerror}") from error
