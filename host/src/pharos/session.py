# SPDX-License-Identifier: Apache-2.0
"""A light at a URL, in one call."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from .connection import MavlinkConnection, Target, signing_time
from .dialect import load_dialect
from .light import Light
from .link import RealPacer, open_link


@contextmanager
def connect(
    url: str, *, target: Target | None = None, key: bytes = b"", timeout_s: float = 3.0
) -> Iterator[Light]:
    """The light at `url`, in real time; the link is closed at the end. target: which component, if
    there are several; key: the light's, 32 bytes. UrlError: there is no such link; LinkError: it is
    not there; SilentError: no light answered within timeout_s."""
    with open_link(url) as link:
        connection = MavlinkConnection(link, RealPacer([link]), load_dialect())
        if key:
            connection.sign(key, signing_time())
        light = Light(connection)
        light.find(round(timeout_s * 1e6), target)
        yield light
