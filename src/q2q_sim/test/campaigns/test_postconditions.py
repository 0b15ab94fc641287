"""Each postcondition holds in the sound stack and is violated by the seeded bug that breaks it."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import SetpointStatus
from q2q_sim.campaigns.falsification.candidate_flight import CandidateFlight, fly_candidate
from q2q_sim.campaigns.falsification.counterexample import with_faults
from q2q_sim.campaigns.falsification.postconditions.filter_properties import swap_moved_track
from q2q_sim.campaigns.falsification.postconditions.replanner_properties import (
    acc_held_too_long,
    promise,
    stop_enters_zone,
)
from q2q_sim.campaigns.falsification.postconditions.run_ticks import run_ticks
from q2q_sim.campaigns.falsification.seeded_bugs import SEEDED_BUGS
from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.flight_blocks import safe_replanner_params

BUGS = {bug.name: bug for bug in SEEDED_BUGS}
PASS = 4.5
"""Time at which cf2 passes above cf1 in campaigns' excerpts of Table 2's flights [s]."""
CASES: dict[str, tuple[str, str, tuple[Fault, ...]]] = {
    "upper lost": ("flight 3,", "none", (Fault("dropout", PASS - 0.5, 1.0, ("cf2",)),)),
    "slow one lost": ("flight 5,", "none", (Fault("dropout", PASS - 1.35, 1.0, ("cf2",)),)),
    "swapped with a lost one": (
        "flight 5,",
        "none",
        (
            Fault("swap", 3.5, 0.15, ("cf1", "cf2")),
            Fault("dropout", 3.0, 0.5, ("cf2",)),
            Fault("dropout", 3.5, 0.15, ("cf1",)),
        ),
    ),
    "reordered": ("flight 3,", "none", (Fault("reordered", 3.0, 0.3),)),
    "set back": ("flight 3,", "none", (Fault("clock_jump", 3.0, 1.0, (), -0.45),)),
    "set back while one is lost": (
        "flight 3,",
        "none",
        (Fault("clock_jump", 3.0, 1.0, (), -0.45), Fault("dropout", 2.9, 1.0, ("cf2",))),
    ),
    "lost at the zone": ("flight 5,", "safe", (Fault("dropout", 3.5, 1.0, ("cf2",)),)),
    "off its path": ("flight 3,", "safe", (Fault("jump", 3.0, 1.0, ("cf1",), 0.4),)),
}
"""Words of the flight's description, replanner and faults."""


@cache
def flown(case: str) -> Run:
    """Return a run of a case, by the PID."""
    words, replan, faults = CASES[case]
    for seed in range(200):
        run = draw_run(seed, replan=replan)
        plain = "safe_replanner" not in run.scenario.overrides
        if words in str(run.document["description"]) and run.options.controller == "pid" and plain:
            return with_faults(run, faults)
    raise ValueError(f"no seed below 200 flies {words!r} by the PID")


@cache
def sound(case: str) -> CandidateFlight:
    """Return the outcome of a case without a bug."""
    return fly_candidate(flown(case))


@pytest.mark.parametrize(
    ("bug", "case", "broken"),
    [
        ("long_coast", "upper lost", "lost_moving"),
        ("never_ambiguous", "swapped with a lost one", "swap_moved_track"),
        ("held_unreported", "reordered", "repeat_reported_ok"),
        ("clock_never_reset", "set back", "hold_too_long"),
        ("ages_unshifted", "set back while one is lost", "stale_reported_ok"),
        ("no_braking", "upper lost", "brake"),
        ("braking_reversed", "upper lost", "brake"),
        ("no_evasion", "upper lost", "evasion"),
        ("evasion_reversed", "slow one lost", "evasion"),
        ("hold_forgotten", "lost at the zone", "acc_held_too_long"),
        ("break_unreported", "off its path", "off_path_unreported"),
    ],
)
def test_a_bug_violates_the_property_that_the_sound_stack_keeps(bug: str, case: str, broken: str):
    assert sound(case).violations == ()
    with BUGS[bug].seeded():
        found = fly_candidate(flown(case))
    assert broken in found.policies


@pytest.mark.parametrize(
    ("jump", "speed", "broken"), [(0.0, 0.1, 1), (-0.0016, 0.1, 0), (0.0016, 0.1, 0), (0.0, 0.0, 0)]
)
def test_an_acceleration_is_held_for_too_long_in_ticks_of_equal_length(
    jump: float, speed: float, broken: int
) -> None:
    """Where the clock jumps, or a setpoint is given again, ticks say nothing about how long it is held."""
    run = flown("off its path")
    ticks = run_ticks(fly_pure(run).topics)
    last = 100 + round(safe_replanner_params(run.scenario).hold / TICK_S)
    acc, moved = np.array([[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]]), np.full(2, SetpointStatus.SHIFTED, np.uint8)
    setpoints = [
        replace(one, pos=0.0 * one.pos + speed * k, acc=acc if 100 <= k <= last else 0.0 * acc, status=moved)
        for k, one in enumerate(ticks.setpoints)
    ]
    stamp = ticks.stamp + np.where(np.arange(len(ticks.stamp)) >= last, jump, 0.0)
    found = acc_held_too_long(run, replace(ticks, setpoints=tuple(setpoints), stamp=stamp))
    assert len(found.violations) == broken


def test_an_entry_into_the_zone_is_a_violation_unless_it_is_reported():
    run = flown("off its path")
    ticks = run_ticks(fly_pure(run).topics)
    first = ticks.setpoints[0]
    inside = first.pos.copy()
    inside[1] = inside[0] + [0.1, 0.0, 0.0]
    for status, broken in ((SetpointStatus.NOMINAL, 1), (SetpointStatus.PROMISE_BROKEN, 0)):
        entering = replace(first, pos=inside, status=np.full(2, status, dtype=np.uint8))
        found = promise(run, replace(ticks, setpoints=(entering, *ticks.setpoints[1:])))
        assert len(found.violations) == broken
        assert found.margin < 0.0


@pytest.mark.parametrize(("speed", "broken"), [(0.1, False), (1.5, True)])
def test_a_setpoint_from_which_a_stop_enters_the_zone_is_a_violation(speed: float, broken: bool) -> None:
    """0.3 m from the zone: a stop from 1.5 m/s takes 0.56 m at 2 m/s^2, and more with bounded jerk."""
    run = flown("off its path")
    ticks = run_ticks(fly_pure(run).topics)
    first, params = ticks.setpoints[0], safe_replanner_params(run.scenario)
    pos, vel = np.zeros((2, 3)), np.zeros((2, 3))
    pos[1, 0], vel[1, 0] = params.eps + 0.3, -speed
    for status in (SetpointStatus.NOMINAL, SetpointStatus.PROMISE_BROKEN):
        nearing = replace(first, pos=pos, vel=vel, acc=np.zeros((2, 3)), status=np.full(2, status, np.uint8))
        found = stop_enters_zone(run, replace(ticks, setpoints=(nearing, *ticks.setpoints[1:])))
        assert bool(found.violations) == (broken and status == SetpointStatus.NOMINAL)


@pytest.mark.parametrize(("missing", "judged"), [("cf2", False), ("cf1", True)])
def test_a_swap_is_not_judged_while_one_marker_is_displaced_and_the_other_missing(
    missing: str, judged: bool
) -> None:
    faults = (
        Fault("swap", 4.4, 0.1, ("cf1", "cf2")),
        Fault("jump", 4.4, 1.0, ("cf1",), 0.5),
        Fault("dropout", 4.1, 0.8, (missing,)),
    )
    run = with_faults(flown("upper lost"), faults)
    assert math.isfinite(swap_moved_track(run, run_ticks(fly_pure(run).topics)).margin) == judged


@pytest.mark.parametrize(("missing", "judged"), [("cf2", False), ("cf1", True)])
def test_nor_while_the_room_itself_has_lost_the_other(missing: str, judged: bool) -> None:
    faults = (Fault("swap", 4.4, 0.1, ("cf1", "cf2")), Fault("jump", 4.4, 1.0, ("cf1",), 0.5))
    run = with_faults(flown("upper lost"), faults)
    ticks = run_ticks(fly_pure(run).topics)
    unseen = np.where([name == missing for name in ticks.names], 0.2, 0.0)
    states = tuple(replace(one, age=unseen) if 4.3 < one.t < 4.395 else one for one in ticks.states)
    assert math.isfinite(swap_moved_track(run, replace(ticks, states=states)).margin) == judged
