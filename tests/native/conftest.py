# SPDX-License-Identifier: Apache-2.0
"""See native_harness.py."""

from native_harness import binary, node, start

__all__ = ["binary", "node", "start"]
