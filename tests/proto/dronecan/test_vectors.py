# SPDX-License-Identifier: Apache-2.0
"""The committed vectors are what PyPI's dronecan makes today."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

VECTORS = Path(__file__).resolve().parents[2] / "vectors"


def test_committed_vectors_are_those_of_the_script() -> None:
    made = subprocess.run(
        [sys.executable, VECTORS / "make_dronecan.py"], check=True, capture_output=True
    ).stdout
    assert made == (VECTORS / "dronecan_vectors.h").read_bytes()
