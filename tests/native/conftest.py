# SPDX-License-Identifier: Apache-2.0
"""See native_harness.py."""

from native_harness import binary, node, pytest_addoption, start

__all__ = ["binary", "node", "pytest_addoption", "start"]
