# SPDX-License-Identifier: Apache-2.0
"""The package is tested from the tree, installed or not."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))
