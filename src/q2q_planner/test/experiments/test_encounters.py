"""Random encounters keep the safe law's promise; what judges them sees what it should."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from q2q_model.signals.values import SetpointStatus
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_planner.experiments.encounter_verdict import EncounterVerdict, judge_encounter
from q2q_planner.experiments.random_encounters import Encounter, random_encounter
from q2q_planner.experiments.replanned_encounter import fly_encounter
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams

PARAMS = SafeReplannerParams(eps=0.2, tracking=0.02)
TICK = 0.01


def verdict_of(seed: int, most: int) -> EncounterVerdict:
    """Return the verdict on a random encounter of up to `most` vehicles."""
    generator = np.random.default_rng(seed)
    encounter = random_encounter(generator, most=most)
    return judge_encounter(fly_encounter(encounter, PARAMS, generator), encounter, PARAMS)


def kept_promise(verdict: EncounterVerdict) -> None:
    assert verdict.conditions_hold
    assert verdict.silent_time == 0.0
    assert not verdict.broken
    assert verdict.zone_time == 0.0
    assert verdict.clearance > 2.0 * PARAMS.tracking  # room for both to be off their trajectories


@settings(deadline=None, max_examples=3)
@given(st.integers(0, 10**9))
def test_any_encounter_keeps_the_promise_where_its_conditions_hold(seed: int) -> None:
    verdict = verdict_of(seed, most=4)
    assume(verdict.conditions_hold)
    kept_promise(verdict)


@pytest.mark.parametrize("seed", [1, 2, 4, 5])
def test_encounters_of_up_to_ten_keep_the_promise_where_its_conditions_hold(seed: int) -> None:
    kept_promise(verdict_of(seed, most=10))


@pytest.mark.parametrize("seed", [0, 8])
def test_encounters_whose_conditions_fail_break_the_promise_and_say_so(seed: int) -> None:
    verdict = verdict_of(seed, most=10)
    assert not verdict.conditions_hold
    assert verdict.zone_time > 0.0
    assert verdict.broken
    assert verdict.silent_time == 0.0


def head_on() -> Encounter:
    """Return two vehicles that swap places 3 m apart in 6 s, passing exactly head on."""
    plan = minimum_snap_plan(
        [
            VehicleWaypoints("cf1", (Waypoint(0, (-1.5, 0, 1)), Waypoint(6, (1.5, 0, 1)))),
            VehicleWaypoints("cf2", (Waypoint(0, (1.5, 0, 1)), Waypoint(6, (-1.5, 0, 1)))),
        ]
    )
    return Encounter(plan, TICK, apart=True, delay=np.array([[0.0, 0.3], [0.05, 0.0]]), loss=0.05)


def test_two_replanners_that_hear_each_other_late_avoid_each_other() -> None:
    encounter = head_on()
    verdict = judge_encounter(fly_encounter(encounter, PARAMS, np.random.default_rng(0)), encounter, PARAMS)
    assert verdict.conditions_hold
    assert verdict.zone_time == 0.0
    assert not verdict.broken


def test_references_that_nobody_moves_are_judged_inside_and_silent() -> None:
    """The middle of a swap is flown at 35/16 of 0.5 m/s: 0.4 m of zone pass at twice that speed."""
    encounter = head_on()
    references = [setpoint_at(encounter.plan, k * TICK) for k in range(700)]
    verdict = judge_encounter(references, encounter, PARAMS)
    assert verdict.zone_time == pytest.approx(0.4 / (2.0 * 35.0 / 16.0 * 0.5), abs=0.01)
    assert verdict.silent_time == verdict.zone_time
    assert verdict.clearance == pytest.approx(-PARAMS.eps, abs=0.01)
    assert verdict.shift == 0.0
    assert verdict.arrived
    lines = np.array([SetpointStatus.PROMISE_BROKEN, SetpointStatus.NOMINAL], dtype=np.uint8)
    output = judge_encounter([replace(one, status=lines) for one in references], encounter, PARAMS)
    assert output.zone_time == verdict.zone_time
    assert output.silent_time == 0.0
    assert output.broken
