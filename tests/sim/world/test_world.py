# SPDX-License-Identifier: Apache-2.0
"""The hunt itself: that a seed is one world, that stories shrink, that a cluster loses nothing."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from distributed import Client, LocalCluster

from campaign import BINARY, ROOT, build_of, run, run_seed
from plan import FAULTS, FEATURES, SHORTEST_S, Action, Plan, draw
from seeded import Bug, all_bugs
from shrink import shrink
from workers import SameBuild
from world import Outcome, World

SEEDS = range(1, 301)
SECOND = 1_000_000


def test_a_seed_is_one_plan() -> None:
    for seed in SEEDS:
        assert draw(seed) == draw(seed)
        assert draw(seed) != draw(seed + 1)


def test_every_plan_is_long_and_has_something_go_wrong() -> None:
    for seed in SEEDS:
        plan = draw(seed)
        assert plan.duration_us >= SHORTEST_S * SECOND
        assert plan.faults
        assert list(plan.actions) == sorted(plan.actions, key=lambda action: action.at_us)


def test_a_cut_of_a_write_is_one_of_power() -> None:
    """The light whose flash fails is the one that starts anew."""
    cuts = 0
    for seed in SEEDS:
        plan = draw(seed)
        for cut in (action for action in plan.actions if action.verb == "cut"):
            cuts += 1
            assert any(
                each.verb == "reset"
                and each.light == cut.light
                and 0 <= each.at_us - cut.at_us <= 4 * SECOND
                for each in plan.actions
            )
    assert cuts > 50


def test_every_fault_meets_every_feature() -> None:
    """What CI runs has no empty cell."""
    met = {
        cell for seed in SEEDS for cell in itertools.product(draw(seed).faults, draw(seed).features)
    }
    assert met == set(itertools.product(FAULTS, FEATURES))


def test_a_seed_is_one_story() -> None:
    stories: list[list[str]] = [[], []]
    for story in stories:
        World(draw(7), BINARY, story.append).run()
    assert stories[0] == stories[1]
    assert len(stories[0]) > 20


def test_a_story_shrinks_to_what_it_needs() -> None:
    actions = tuple(Action(i, "status") for i in range(40))
    plan = Plan(1, 100, frozenset(), frozenset(), actions)
    tried = []

    def fails(part: Plan) -> bool:
        tried.append(part)
        return {3, 17, 38} <= {action.at_us for action in part.actions}

    assert [action.at_us for action in shrink(plan, fails).actions] == [3, 17, 38]
    assert len(tried) < 120


# --- seeded bugs ----------------------------------------------------------------------------------
@pytest.mark.parametrize("bug", all_bugs(), ids=lambda bug: str(bug.name))
def test_a_seeded_bug_still_applies_to_the_tree(bug: Bug) -> None:
    assert bug.what
    assert bug.breaks
    assert 0 < bug.within <= 1000
    command = ["git", "apply", "--check", str(bug.path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


# --- many -----------------------------------------------------------------------------------------
def test_what_goes_wrong_in_a_run_is_told_as_a_failure() -> None:
    outcome = run_seed(1, Path("/nowhere/pharos"))
    assert "`make build`?" in outcome.violations[0] or "dialect" in outcome.violations[0]


def test_a_cluster_finds_the_same_and_a_dead_worker_costs_no_seed() -> None:
    seeds = range(1, 25)
    alone = {outcome.seed: outcome for outcome, _ in run(seeds)}
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        together: dict[int, Outcome] = {}
        for outcome, summary in run(seeds, cluster.scheduler_address):
            if not together:
                victim = next(iter(cluster.workers.values()))
                os.kill(victim.pid, signal.SIGKILL)
            together[outcome.seed] = outcome
            counted = summary.seeds
    assert together == alone
    assert counted == len(seeds)


def test_a_worker_with_another_build_is_refused() -> None:
    with (
        LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        client.register_plugin(SameBuild(build_of()))
        with pytest.raises(RuntimeError, match="has another build"):
            client.register_plugin(SameBuild("0" * 64))


def test_one_that_joins_later_is_refused_too(tmp_path: Path) -> None:
    (tmp_path / "pharos").write_bytes(b"another light")
    path = os.pathsep.join(sys.path)
    with (
        LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        client.register_plugin(SameBuild(build_of()))
        late = subprocess.run(
            [sys.executable, "-m", "distributed.cli.dask_worker", cluster.scheduler_address,
             "--nthreads", "1", "--no-nanny", "--no-dashboard"],
            env={**os.environ, "PHAROS_BUILD": str(tmp_path), "PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )  # fmt: skip
        assert "has another build" in late.stderr
        assert len(client.scheduler_info()["workers"]) == 1
