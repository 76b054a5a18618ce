# SPDX-License-Identifier: Apache-2.0
"""The model of a light: that it allows what may be, and nothing else."""

from __future__ import annotations

import pytest

from gimbal_oracle import GimbalOracle
from hardpoint_oracle import HardpointOracle
from lamp import BEACON, Lamp, configured, turned
from oracle import ACCEPTED, FAILED, HEAL_US, Oracle, Sent
from sensor_oracle import SensorOracle
from strobe_oracle import StrobeOracle

SENDER = (255, 190)
SECOND = 1_000_000


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


# --- the store ------------------------------------------------------------------------------------
def _reset(oracle: Oracle, at_us: int) -> None:
    oracle.reset_expected(at_us)
    oracle.sample(at_us, {**OUTPUTS, "resets": oracle.resets_seen + 1, "reset_cause": "power-on"})


SERVOS = {"pan": {"angle_mdeg": 0}, "tilt": {"angle_mdeg": 0}}
OUTPUTS = {"resets": 0, "reset_cause": "", "temp_mdegc": 25_000, "level_ppm": 0, "servos": SERVOS}
OFF = Lamp(kept=True)
ON = Lamp(enable=True, kept=True)


@pytest.mark.parametrize(("stood_us", "after"), [(3 * SECOND, {ON}), (2 * SECOND, {OFF, ON})])
def test_what_has_stood_is_stored(stood_us: int, after: set[Lamp]) -> None:
    """docs/settings.md: written a second after the last change."""
    oracle = Oracle(key=False, restore=True, fallback="")
    _sent(oracle, 10 * SECOND, True)
    oracle.acknowledged(10 * SECOND, SENDER, 405, ACCEPTED)
    _reset(oracle, 10 * SECOND + stood_us)
    assert oracle.certain == after


def test_behind_a_flash_that_fails_is_what_was_before() -> None:
    oracle = Oracle(key=False, restore=True, fallback="")
    _sent(oracle, 10 * SECOND, True)
    oracle.acknowledged(10 * SECOND, SENDER, 405, ACCEPTED)
    oracle.around.torn_us = 10 * SECOND
    _reset(oracle, 80 * SECOND)
    assert oracle.certain == {OFF, ON}
    assert oracle.around.torn_us is None


# --- silence --------------------------------------------------------------------------------------
@pytest.mark.parametrize(("heard", "after"), [(True, {BEACON}), (False, {BEACON, Lamp()})])
def test_a_reset_that_ate_the_last_sign_of_life_leaves_both(heard: bool, after: set[Lamp]) -> None:
    oracle = Oracle(key=False, restore=False, fallback="loss-beacon")
    oracle.life(10 * SECOND, True)
    _reset(oracle, 10 * SECOND + 50_000)
    if heard:
        oracle.life(10 * SECOND + 100_000, True)
    oracle.look_again(17 * SECOND, OUTPUTS)
    assert oracle.certain == after


def test_others_do_not_take_what_is_on_its_way_over_the_ring() -> None:
    oracle = Oracle(key=False, restore=False, fallback="")
    results = frozenset({ACCEPTED})
    far = Sent((200, 190), 405, turned(True), results, 10 * SECOND, sure=False, is_far=True)
    oracle.sent(far, authorised=True)
    oracle.switched(10 * SECOND, turned(False))
    oracle.acknowledged(10 * SECOND, (200, 190), 405, ACCEPTED)
    assert oracle.violations == []
    assert oracle.possible() == {Lamp(), Lamp(enable=True)}


# --- heat -----------------------------------------------------------------------------------------
def _warm(sensor: SensorOracle, start_c: float, per_s: float) -> int:
    for tenth in range(40):
        sensor.sample(tenth * 100_000, start_c + per_s * tenth / 10, "none", False, 98.5)
    return 4 * SECOND


@pytest.mark.parametrize(
    ("start_c", "per_s", "is_heat"), [(80.0, 2.0, True), (70.0, 0.1, False), (90.0, -2.0, False)]
)
def test_a_sensor_that_fails_on_the_way_to_the_shutdown_is_heat(
    start_c: float, per_s: float, is_heat: bool
) -> None:
    sensor = SensorOracle()
    now_us = _warm(sensor, start_c, per_s)
    assert sensor.sample(now_us, 25.0, "none", True, 98.5) == is_heat
    assert not SensorOracle().sample(now_us, 25.0, "open", True, 98.5)
    assert SensorOracle().sample(now_us, 25.0, "short", True, 98.5)


def test_a_light_that_was_shut_down_may_refuse_until_it_is_cool() -> None:
    oracle = Oracle(key=False, restore=False, fallback="")
    for tenth in range(100):
        oracle.sample(tenth * 100_000, {**OUTPUTS, "temp_mdegc": 75_000 + tenth * 150})
    oracle.around.sensor_us = 10 * SECOND  # the world moves it to where it had not been
    for tenth in range(100, 200):
        oracle.sample(tenth * 100_000, {**OUTPUTS, "temp_mdegc": 80_000})
    assert 20 * SECOND - oracle.around.sensor_us > HEAL_US
    _sent(oracle, 20 * SECOND, True)
    oracle.acknowledged(20 * SECOND, SENDER, 405, FAILED)
    assert oracle.violations == []
    oracle.sample(21 * SECOND, {**OUTPUTS, "temp_mdegc": 60_000})
    _sent(oracle, 21 * SECOND, True)
    oracle.acknowledged(21 * SECOND, SENDER, 405, FAILED)
    assert len(oracle.violations) == 1


# --- the strobe -----------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("edges", "told"),
    [
        ([(0, 1), (100_000, 0), (1_000_000, 1), (1_100_000, 0)], []),
        ([(0, 1), (60_000, 0)], ["lit for 60000 us, not 100000"]),
        ([(0, 1), (100_000, 0), (999_998, 1)], ["a period of 999998 us, not 1000000"]),
        ([(0, 1), (100_000, 0), (1_000_000, 1), (1_100_003, 0)],
         ["lit for 100003 us, not 100000", "a period of 1000003 us, not 1000000"]),
    ],
)  # fmt: skip
def test_each_phase_has_its_length_from_the_first_on(
    edges: list[tuple[int, int]], told: list[str]
) -> None:
    found: list[str] = []
    strobe = StrobeOracle(lambda _now, what: found.append(what))
    for at_us, ppm in edges:
        assert strobe.edge(at_us, ppm)
        assert not strobe.edge(at_us, ppm), "the same level again"
        strobe.check(0, 1e6, 1e5)
    assert found == told


# --- who repeats ----------------------------------------------------------------------------------
def test_a_repetition_does_not_take_the_light_back() -> None:
    hardpoint = HardpointOracle()
    assert hardpoint.sent(1, 1, True), "the first"
    assert hardpoint.sent(2, 1, True), "nobody else has commanded"
    hardpoint.taken(3)
    assert not hardpoint.sent(4, 1, True)
    assert not hardpoint.sent(5, 1, True)
    assert hardpoint.sent(6, 0, True), "another value is a command"
    hardpoint.taken(7)
    assert not hardpoint.sent(8, 0, False), "the last one surely arrived"
    assert hardpoint.sent(9, 0, True), "this one's forerunner perhaps did not"
    hardpoint.taken(10)
    hardpoint.forget()
    assert hardpoint.sent(11, 0, True)
