# SPDX-License-Identifier: Apache-2.0
"""The key of a light that signs its messages."""

from __future__ import annotations

from pathlib import Path

from ..errors import UsageError

KEY_BYTES = 32


def read_key(path: str | None) -> bytes:
    """32 bytes, or as many in hexadecimal digits; b"" without a file."""
    if path is None:
        return b""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}") from error
    if len(data) != KEY_BYTES:
        try:
            data = bytes.fromhex(data.decode("ascii"))
        except ValueError:
            data = b""
    if len(data) != KEY_BYTES:
        raise UsageError(f"{path}: a key has 32 bytes, or 64 hexadecimal digits")
    return data
