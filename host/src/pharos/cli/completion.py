# SPDX-License-Identifier: Apache-2.0
"""Completion in bash, zsh and fish."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator

import argcomplete
from argcomplete.shell_integration import shellcode

from ..find import usual_places

KINDS = ("udp:", "udpin:", "tcp:", "tcpin:", "pty:", "serial:", "dronecan:")


def shell_code(shell: str) -> str:
    return str(shellcode(["pharos"], shell=shell))


def complete(parser: argparse.ArgumentParser) -> None:
    """Answers the shell that asks, and ends; returns if none does."""
    for action in _actions(parser):
        if action.dest in ("url", "places"):
            action.completer = urls  # type: ignore[attr-defined]
    argcomplete.autocomplete(parser)


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for child in action.choices.values():
                yield from _actions(child)


def urls(prefix: str, **_: object) -> Iterable[str]:
    """The kinds of URL, and what of them is here: serial lines, loopback's ports."""
    here = [place for place in usual_places() if "255" not in place and place[:4] != "can:"]
    return [url for url in (*KINDS, *here) if url.startswith(prefix)]
