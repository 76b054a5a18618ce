# SPDX-License-Identifier: Apache-2.0
"""Power-ups with chips that are late, silent or broken; make simulate-powerup has more of them."""

from __future__ import annotations

import pytest

from powerup import run
from powerup_plan import GRID, draw

SEEDS = range(1, 241)


def test_every_cell_of_the_grid_is_met() -> None:
    assert {cell for seed in SEEDS for cell in draw(seed).cells} == set(GRID)


def test_a_seed_is_one_plan() -> None:
    assert all(draw(seed) == draw(seed) for seed in SEEDS)


@pytest.mark.parametrize("first", SEEDS[::10])
def test_never_lit_unsupervised_always_answering_bitten_only_when_stalled(first: int) -> None:
    wrong = {seed: run(draw(seed)) for seed in range(first, first + 10)}
    assert not any(wrong.values()), {seed: what[0] for seed, what in wrong.items() if what}
