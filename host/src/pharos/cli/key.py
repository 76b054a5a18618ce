# SPDX-License-Identifier: Apache-2.0
"""`pharos signing`: the key of a light that obeys only who signs, and the file that it lies in."""

from __future__ import annotations

import argparse
import os
import secrets
from pathlib import Path

from ..connection import MavlinkConnection, signing_time
from ..dialect import load_dialect
from ..errors import PharosError, SilentError, UsageError
from ..light import Light
from ..link import RealPacer, open_link
from .shell import OK, Printer

KEY_BYTES = 32
# SETUP_SIGNING has no answer: it is sent so often.
TRIES = 3
SECOND = 100_000  # of a timestamp


def read_key(path: str | None) -> bytes:
    """32 bytes, or as many in hexadecimal digits; b"" without a file."""
    if path is None:
        return b""
    try:
        data = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise UsageError(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    if len(data) != KEY_BYTES:
        try:
            data = bytes.fromhex(data.decode("ascii"))
        except ValueError:
            data = b""
    if len(data) != KEY_BYTES:
        raise UsageError(f"{path}: a key has 32 bytes, or 64 hexadecimal digits")
    return data


def make_key(path: str) -> bytes:
    """A new one, in a file that only its owner reads. UsageError: there is such a file."""
    key = secrets.token_bytes(KEY_BYTES)
    try:
        fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
    except (OSError, ValueError) as error:
        raise UsageError(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    with os.fdopen(fd, "w", encoding="ascii") as file:
        file.write(key.hex() + "\n")
    return key


def run_signing(args: argparse.Namespace, printer: Printer) -> int:
    is_new = not os.path.lexists(args.key_file)
    if args.action == "off" and is_new:
        raise UsageError(f"{args.key_file}: No such file or directory")
    key = make_key(args.key_file) if is_new else read_key(args.key_file)
    with open_link(args.url) as link:
        light = Light(MavlinkConnection(link, RealPacer([link]), load_dialect()))
        if args.action == "off":
            light.connection.sign(key, signing_time())
        light.find(round(args.timeout * 1e6), args.target)
        change_key(light, key if args.action == "setup" else b"")
    made = f", a new key is in {args.key_file}" if is_new else ""
    text = "the light signs and obeys only who does" if args.action == "setup" else "open to all"
    printer.fields(
        text + made, command=f"signing {args.action}", ok=True, file=args.key_file, made=is_new
    )
    return OK


def change_key(light: Light, key: bytes) -> None:
    """Gives the light that key, or none. PharosError: it did not take it."""
    connection = light.connection
    target = connection.target
    now = signing_time()
    for _ in range(TRIES):
        connection.send(
            connection.dialect.MAVLink_setup_signing_message(
                target.system, target.component, key or bytes(KEY_BYTES), now if key else 0
            )
        )
        light.poll(100_000)
        # It does not take it twice: what comes is signed with the new one.
        connection.sign(key, now + SECOND)
        try:
            light.fetch_status()
        except SilentError:
            connection.sign(b"", 0)
            continue
        if connection.hears_signed() == bool(key):
            return
    raise PharosError(
        "the light did not change its key: it does so on links that are marked secure "
        "(parameter MAV_SECURE), and for who has the key it has"
    )
