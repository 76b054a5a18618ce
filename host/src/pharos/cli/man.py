# SPDX-License-Identifier: Apache-2.0
"""The man page, for packages: `python -m pharos.cli.man > pharos.1`. Needs argparse-manpage."""

from __future__ import annotations

from . import make_parser, pharos_version


def page() -> str:
    from argparse_manpage.manpage import Manpage

    parser = make_parser()
    parser.prog = "pharos"
    parser.man_short_description = (  # type: ignore[attr-defined]
        "find, command and check lights on drones and vessels"
    )
    page = Manpage(parser)
    page.source = f"pharos {pharos_version()}"
    page.manual = "User Commands"
    # It takes help texts as they are written for argparse's formatting.
    return str(page).replace("%%", "%")


if __name__ == "__main__":
    print(page())
