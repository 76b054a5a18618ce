# SPDX-License-Identifier: Apache-2.0
"""`pharos find`: lights within reach, a line each."""

from __future__ import annotations

import argparse

from ..errors import PharosError, SilentError, UrlError
from ..find import find_lights, usual_places
from .shell import Printer


def run_find(args: argparse.Namespace, printer: Printer) -> int:
    def skip(place: str, error: PharosError) -> None:
        if isinstance(error, UrlError):
            raise error
        if args.places or args.verbose:
            printer.error(error, place)

    places = args.places or usual_places(args.baud)
    found = find_lights(places, args.seconds, skip)
    if not found:
        raise SilentError(f"no light within {args.seconds:g} s")
    for light in found:
        printer.fields(str(light), **light.as_fields())
    return 0
