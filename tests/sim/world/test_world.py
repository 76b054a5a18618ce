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
from gimbal_oracle import GimbalOracle
from oracle import ACCEPTED, Lamp, Oracle, Sent, configured, turned
from plan import FAULTS, FEATURES, SHORTEST_S, Action, Plan, draw
from seeded import Bug, all_bugs
from shrink import shrink
from workers import SameBuild
from world import World

SEEDS = range(1, 301)
SENDER = (255, 190)
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


# --- the oracle -----------------------------------------------------------------------------------
def _sent(oracle: Oracle, at_us: int, on: bool) -> None:
    oracle.sent(
        Sent(SENDER, 405, turned(on), frozenset({ACCEPTED}), at_us, sure=True), authorised=True
    )


def test_an_unanswered_command_may_be_in_force_or_not() -> None:
    oracle = Oracle(key=False, restore=False, fallback="")
    _sent(oracle, 1 * SECOND, True)
    assert oracle.possible() == {Lamp(), Lamp(enable=True)}
    oracle.acknowledged(1 * SECOND, SENDER, 405, ACCEPTED)
    assert oracle.possible() == {Lamp(enable=True)}
    _sent(oracle, 2 * SECOND, False)
    _sent(oracle, 3 * SECOND, True)
    oracle.acknowledged(3 * SECOND, SENDER, 405, ACCEPTED)
    assert oracle.possible() == {Lamp(enable=True)}
    assert oracle.violations == []


def test_an_answer_that_nobody_waits_for_is_told() -> None:
    oracle = Oracle(key=False, restore=False, fallback="")
    oracle.acknowledged(1 * SECOND, SENDER, 405, ACCEPTED)
    assert oracle.violations == ["1.000 s: an ACK of 405 to (255, 190) that nobody waits for"]


def test_who_is_not_authorised_changes_nothing() -> None:
    oracle = Oracle(key=True, restore=False, fallback="")
    effect = configured(50.0, 0.0, 100.0, 1)
    one = Sent(SENDER, 406, effect, frozenset({ACCEPTED}), 1 * SECOND, sure=True)
    oracle.sent(one, authorised=False)
    assert oracle.possible() == {Lamp()}


def test_silence_is_a_command_of_its_own() -> None:
    oracle = Oracle(key=False, restore=False, fallback="loss-off")
    oracle.certain = {Lamp(enable=True)}
    oracle.life(10 * SECOND, True)
    for seconds, expected in (
        (13, {Lamp(enable=True)}),
        (15, {Lamp(enable=True), Lamp()}),  # when it was heard is known to a second
        (17, {Lamp()}),
    ):
        oracle.acknowledged(seconds * SECOND, SENDER, 1, ACCEPTED)
        assert oracle.possible() == expected


def test_what_goes_over_other_lights_may_be_obeyed_later() -> None:
    oracle = Oracle(key=False, restore=False, fallback="")
    results = frozenset({ACCEPTED})
    far = Sent((200, 190), 405, turned(True), results, 10 * SECOND, sure=False, is_far=True)
    oracle.sent(far, authorised=True)
    _sent(oracle, 10 * SECOND, False)
    oracle.acknowledged(10 * SECOND, SENDER, 405, ACCEPTED)
    assert oracle.possible() == {Lamp(), Lamp(enable=True)}
    oracle.acknowledged(10 * SECOND, (200, 190), 405, ACCEPTED)
    assert oracle.possible() == {Lamp(), Lamp(enable=True)}
    oracle.acknowledged(10 * SECOND, (200, 190), 405, ACCEPTED)
    assert len(oracle.violations) == 1, "acknowledged twice"


def test_a_gimbal_is_where_it_may_have_been_pointed() -> None:
    told: list[str] = []
    gimbal = GimbalOracle(lambda _now, what: told.append(what))
    gimbal.sample(5 * SECOND, (0.0, 0.0), True)
    gimbal.sent(5 * SECOND, (30.0, -10.0))
    gimbal.sample(10 * SECOND, (0.0, 0.0), True)
    gimbal.sample(10 * SECOND, (30.0, -10.0), True)
    assert told == []
    gimbal.acknowledged(10 * SECOND, True)
    gimbal.sample(15 * SECOND, (0.0, 0.0), True)
    assert len(told) == 1


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
    alone = {outcome.seed: outcome.violations for outcome, _ in run(seeds)}
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        together: dict[int, list[str]] = {}
        for outcome, summary in run(seeds, cluster.scheduler_address):
            if not together:
                victim = next(iter(cluster.workers.values()))
                os.kill(victim.pid, signal.SIGKILL)
            together[outcome.seed] = outcome.violations
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
