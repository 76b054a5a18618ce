# SPDX-License-Identifier: Apache-2.0
"""The package's version is the firmware's: src/pharos/version.h is app/version.h in the tree, and a
copy in what is published. All else is in pyproject.toml."""

import re
from pathlib import Path

from setuptools import setup

HEADER = Path(__file__).parent / "src" / "pharos" / "version.h"
NUMBERS = re.findall(r"^#define PHAROS_VERSION_[A-Z]+ (\d+)$", HEADER.read_text(), re.MULTILINE)

setup(version=".".join(NUMBERS))
