"""Who could matter to whom, and who is put onto its reference: both sides of every bound."""

from dataclasses import replace

import numpy as np
import pytest
from traffic_bench import NOBODY, PARAMS, held, setpoint

from q2q_model.signals.values import Array
from q2q_planner.online.safe.motion.committed_motion import MotionRows
from q2q_planner.online.safe.motion.followed_reference import SNAP_POS, SNAP_VEL, reference_rows
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.traffic import rows_in_pairs, traffic_at


def meet(apart: float, vel: Array, growth: Array | None = None, params: SafeReplannerParams = PARAMS) -> bool:
    """Return whether two vehicles so far apart in y [m] could matter to each other."""
    pos = np.array([[0.0, 0.0, 0.0], [0.0, apart, 0.0]])
    doubt = np.zeros((2, 2)) if growth is None else growth
    reference = reference_rows(setpoint(1.0, ("a", "b"), pos + 1.0))
    _, traffic = traffic_at(held(pos, vel), reference, doubt, NOBODY, params)
    both = rows_in_pairs(traffic.pairs, 2)
    assert both.tolist() == [len(traffic.pairs.i) == 1] * 2
    return bool(both[0])


def test_vehicles_matter_to_each_other_up_to_where_their_ways_to_rest_overlap() -> None:
    """At 3 and 2 m/s side by side they do not close in, so that it is their ways that count."""
    vel = np.array([[3.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    way = {v: (v + 0.06) * (0.02 + 0.5 * (v + 0.06) / 3.0) for v in (3.0, 2.0)}  # 0.06 m/s more in a hold
    far = PARAMS.eps + way[3.0] + way[2.0]
    assert meet(far - 1e-9, vel)
    assert not meet(far + 1e-9, vel)
    growth = np.array([[0.0, 0.1], [0.0, 0.3]])  # goes on until all rest, the fastest 0.6 m/s late
    rest = 0.02 + (3.06 + 0.6) / 3.0
    assert meet(far + 0.4 * rest - 1e-9, vel, growth)
    assert not meet(far + 0.4 * rest + 1e-9, vel, growth)


@pytest.mark.parametrize("jerk", [0.75, 60.0])
def test_ways_to_rest_are_longer_by_the_ramps_of_a_bounded_jerk(jerk: float) -> None:
    """From one full acceleration to the other and back, 4 acc_max / jerk, after two holds."""
    vel = np.array([[3.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    late = 2 * 0.02 + 4.0 * 3.0 / jerk
    way = {v: (v + 3.0 * late) * (late + 0.5 * (v + 3.0 * late) / 3.0) for v in (3.0, 2.0)}
    far, limited = PARAMS.eps + way[3.0] + way[2.0], replace(PARAMS, jerk_max=jerk)
    assert meet(far - 1e-6, vel, params=limited)
    assert not meet(far + 1e-6, vel, params=limited)


def test_zones_that_have_grown_count_in_the_ways_and_in_the_distance() -> None:
    vel, growth = np.tile([3.0, 0.0, 0.0], (2, 1)), np.array([[0.5, 0.0], [0.25, 0.0]])
    way = 3.06 * (0.02 + 0.5 * 3.06 / 3.0)
    far = PARAMS.eps + 2.0 * way + 2.0 * 0.75
    assert meet(far - 1e-9, vel, growth)
    assert not meet(far + 1e-9, vel, growth)


def test_who_stands_matters_where_a_push_of_both_could_be_asked() -> None:
    """pole^2 h against twice acc_max, with poles of 2/s."""
    far = PARAMS.eps + 2.0 * 3.0 / 4.0
    assert meet(far - 1e-9, np.zeros((2, 3)))
    assert not meet(far + 1e-9, np.zeros((2, 3)))


def placed(reference: Array, apart: float, *, on: bool, pushed: bool = False) -> MotionRows:
    """Return two vehicles so far apart in x [m] once they are put on their references, or not."""
    pos = np.array([[0.0, 0.0, 0.0], [apart, 0.0, 0.0]])
    motion = held(pos, np.zeros((2, 3)))
    rows = motion.rows._replace(on_reference=np.full(2, on), pushed=np.full(2, pushed))
    there = setpoint(1.0, ("a", "b"), pos + reference, np.full((2, 3), SNAP_VEL / 2.0))
    begun = motion.with_rows(rows)
    return traffic_at(begun, reference_rows(there), np.zeros((2, 2)), NOBODY, PARAMS)[0].rows


def test_who_meets_nobody_stays_on_its_reference_however_that_jumps() -> None:
    jump = np.array([0.0, 0.0, 3.0])
    for apart, on, stays in ((30.0, True, True), (30.0, False, False), (0.5, True, False)):
        motion = placed(jump, apart, on=on)
        assert motion.on_reference.tolist() == [stays] * 2
        assert motion.pos[:, 2].tolist() == [3.0 if stays else 0.0] * 2
        assert motion.vel[:, 2].tolist() == [SNAP_VEL / 2.0 if stays else 0.0] * 2


def test_who_is_near_its_reference_is_put_onto_it_whomever_it_meets() -> None:
    step = np.array([0.0, 0.0, SNAP_POS / 2.0])
    for apart, pushed, put in ((30.0, False, True), (0.5, False, True), (0.5, True, False)):
        motion = placed(step, apart, on=False, pushed=pushed)
        assert motion.on_reference.tolist() == [put] * 2
        assert motion.pos[:, 2].tolist() == [step[2] if put else 0.0] * 2
