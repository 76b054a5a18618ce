# SPDX-License-Identifier: Apache-2.0
"""The set-up: Debian's own interpreter and compilers, whichever others come first in PATH."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("PHAROS_BUILD", ROOT / "build" / "native")).resolve()


def test_the_interpreter_is_debians() -> None:
    assert Path(sys.prefix) == ROOT / ".venv"
    assert sys.base_prefix == "/usr"


def test_the_build_took_debians_compiler_and_this_interpreter() -> None:
    cache = (BUILD / "CMakeCache.txt").read_text()
    compiler = re.search(r"^CMAKE_C_COMPILER:\w+=(.*)$", cache, re.MULTILINE)
    python = re.search(r"^Python3_EXECUTABLE:\w+=(.*)$", cache, re.MULTILINE)
    assert compiler is not None
    assert python is not None
    assert Path(compiler[1]).parent == Path("/usr/bin")
    assert Path(python[1]) == ROOT / ".venv" / "bin" / "python"
