# SPDX-License-Identifier: Apache-2.0
"""The smallest part of a failing plan that still fails: delta debugging over its actions.

By hand, because what PyPI has does not serve: picire wants pkg_resources, which Python has not any
more, and Hypothesis shrinks only what it has drawn itself."""

from __future__ import annotations

from collections.abc import Callable

from plan import Plan


def shrink(plan: Plan, fails: Callable[[Plan], bool]) -> Plan:
    """fails: whether a plan fails as the whole one does, which it must. In the result each single
    action is needed."""
    kept = list(range(len(plan.actions)))
    size = max(len(kept) // 2, 1)
    while True:
        at = 0
        before = len(kept)
        while at < len(kept):
            less = kept[:at] + kept[at + size :]
            if fails(plan.only(less)):
                kept = less
            else:
                at += size
        if size > 1:
            size //= 2
        elif len(kept) == before:
            return plan.only(kept)
