"""The MPC's compiled loops answer as the same lines do in plain Python, and as numpy does."""

import numpy as np
import pytest
from any_model import AnyModel

from q2q_control.disturbance.observer import Estimate, MeasuredRows, ObserverGain, correct_estimate
from q2q_control.inputs.preview import SAME, interpolated, is_on_plan
from q2q_control.mpc.prediction.downwash_horizon import (
    GradientRule,
    predict_downwash,
)
from q2q_control.mpc.prediction.downwash_horizon_kernel import (
    DELTA,
    LEAST_DOWNWASH,
    Tracks,
    bounding_boxes,
    may_reach,
    sum_downwash,
)
from q2q_control.mpc.problem.axis_cost import AxisWeights
from q2q_control.mpc.problem.axis_model import axis_model
from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon, HorizonSolution
from q2q_control.mpc.problem.input_bounds import FALL, AccelerationLimits, input_bounds
from q2q_control.mpc.problem.joint_problem import group_shape, joint_problem
from q2q_control.mpc.solver.axis_sweep import sweep_axes, sweep_tables
from q2q_control.mpc.solver.group_solve import Group, solve_group
from q2q_control.mpc.solver.horizon_solver import group_roots, groups_of
from q2q_control.mpc.solver.riccati import solve
from q2q_model.downwash.interaction_model import PairMotion
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW, Jet
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

STAGES = 12
MODELS = (axis_model(0.2, 0.05, AxisWeights(2.0, 0.2)),) * 2 + (
    axis_model(0.07, 0.05, AxisWeights(5.0, 0.2)),
)


def stacked_tracks(n: int, seed: int) -> Tracks:
    """Return n vehicles in a column 0.4 m apart, wandering."""
    rng = np.random.default_rng(seed)
    times = np.arange(-5, STAGES + 1) * 0.05
    pos = np.cumsum(rng.normal(size=(times.size, n, 3)) * 0.01, axis=0)
    pos[..., 2] += 0.4 * np.arange(n)
    axis = np.tile([0.0, 0.0, 1.0], (n, STAGES, 1))
    return Tracks(times, pos, axis, rng.uniform(0.4, 1.2, (n, STAGES)), 5)


def horizon_of(n: int, seed: int) -> Horizon:
    rng = np.random.default_rng(seed)
    return Horizon(
        rng.normal(size=(n, 3, 3)) * 0.05,
        rng.normal(size=(n, STAGES + 1, 9)) * 0.1,
        rng.normal(size=(n, STAGES, 3)) * 0.5,
        rng.normal(size=(n, STAGES + 1, 3)) * 0.1,
        np.full((n, 3), -0.6),
        rng.uniform(0.4, 0.8, (n, STAGES, 3)),
        np.full(3, 0.4),
    )


def downwash_by_numpy(model: Jet, tracks: Tracks, i: int, j: int) -> tuple[Array, Array, bool]:
    """Return one pair's law (N, 3), its gradient along z (N, 3), whether it counts: no compiled loop."""
    path = tracks.pos[tracks.first :]
    middle, step = 0.5 * (path[1:] + path[:-1]), np.diff(tracks.times[tracks.first :])[:, None]
    when = 0.5 * (tracks.times[tracks.first + 1 :] + tracks.times[tracks.first : -1])
    when = when - model.delay(middle[:, j] - middle[:, i])
    source = np.stack([np.interp(when, tracks.times, tracks.pos[:, j, c]) for c in range(3)], axis=1)
    source_vel, vel = (np.diff(path[:, v], axis=0) / step for v in (j, i))
    motion = PairMotion(source_vel, tracks.axis[j], vel)
    now, rel, up = middle[:, j] - middle[:, i], source - middle[:, i], np.array([0.0, 0.0, DELTA])
    aside = np.minimum(np.hypot(now[:, 0], now[:, 1]), np.hypot(rel[:, 0], rel[:, 1]))
    within = (aside <= model.reach.horizontal) & (np.abs(rel[:, 2]) <= model.reach.vertical)
    law, above, below = (
        np.where(within[:, None], model.acceleration(rel + side * up, motion), 0.0)
        for side in (0.0, 1.0, -1.0)
    )
    counts = np.abs(law).max() > LEAST_DOWNWASH
    share = tracks.weight[j][:, None]
    return law * share, (above - below) / (2.0 * DELTA) * share, bool(counts)


@pytest.mark.parametrize("model", [MEASURED_LAW, MOVING_LAW])
@pytest.mark.parametrize("n", [2, 3, 6])  # all pairs, all pairs, the sweep over x
def test_downwashs_are_those_of_numpy_pair_by_pair(model: Jet, n: int):
    tracks = stacked_tracks(n, n)
    found = predict_downwash(model, tracks, GradientRule((2,), 10.0))
    pairs = set(zip(found.i.tolist(), found.j.tolist(), strict=True))
    total = np.zeros((n, STAGES, 3))
    for i in range(n):
        for j in range(n):
            if i == j:
                continue
            law, gradient, counts = downwash_by_numpy(model, tracks, i, j)
            assert ((i, j) in pairs) is counts
            if (i, j) in pairs:
                total[i] += law
                row = int(np.flatnonzero((found.i == i) & (found.j == j))[0])
                assert np.allclose(found.gradient[row, :, :, 2], gradient, rtol=1e-7, atol=1e-9)
    assert pairs
    assert np.allclose(found.eta, total, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("model", [PAPER_LAW, MEASURED_LAW, MOVING_LAW])
@pytest.mark.parametrize("moves", [(2,), (0, 1, 2)])
def test_the_loop_of_jets_computes_what_any_models_prediction_does_bit_for_bit(
    model: Jet, moves: tuple[int, ...]
):
    tracks, rule = stacked_tracks(6, 2), GradientRule(moves, 10.0)
    found, expected = (predict_downwash(one, tracks, rule) for one in (model, AnyModel(model)))
    assert 0 < found.i.size <= 30
    for one, other in zip(found, expected, strict=True):
        assert np.array_equal(one, other)


def test_who_meets_is_the_same_compiled_and_plain():
    path, (i, j) = stacked_tracks(5, 1).pos, np.nonzero(~np.eye(5, dtype=np.bool_))
    way = np.array([[0.0, 0.0], [0.05, 0.1], [0.0, 0.0], [0.1, 0.0], [0.0, 0.05]])
    found = may_reach(path, (i, j), (0.1, 0.6), way)
    assert np.array_equal(found, may_reach.py_func(path, (i, j), (0.1, 0.6), way))
    assert 0 < found.sum() < i.size
    middle = 0.5 * (path[1:] + path[:-1])
    centre, half = bounding_boxes(path)
    assert np.array_equal(centre, 0.5 * (middle.min(axis=0) + middle.max(axis=0)))
    assert np.allclose(half, 0.5 * (middle.max(axis=0) - middle.min(axis=0)).max(axis=0), atol=1e-15)


def test_a_law_that_is_no_number_at_one_stage_counts_nothing():
    law = np.full((3, 1, STAGES, 3), -1.0)
    law[0, 0, 4, 2] = np.nan
    downwash = DownwashHorizon(
        np.zeros((2, STAGES, 3)), np.array([0]), np.array([1]), np.zeros((1, STAGES, 3, 3))
    )
    assert not sum_downwash(law, np.ones((2, STAGES)), np.array([2]), 10.0, downwash).any()
    assert not downwash.eta.any()


def test_a_group_solved_in_one_call_is_built_and_solved_in_two():
    rng = np.random.default_rng(2)
    n, group = 4, np.array([1, 3])
    shape, horizon = group_shape(2, (0, 2), MODELS), horizon_of(n, 3)
    gradient = rng.normal(size=(2, STAGES, 3, 3))
    downwash = DownwashHorizon(horizon.push, np.array([1, 3]), np.array([3, 1]), gradient)
    warm_start = rng.integers(0, 3, (n, STAGES, 3)).astype(np.int8)
    pos, inputs = np.full((n, STAGES + 1, 3), np.nan), np.full((n, STAGES, 3), np.nan)
    active_set = np.zeros((n, STAGES, 3), np.int8)
    solution = HorizonSolution(pos, inputs, active_set, np.zeros(n, np.int8), 0)
    used, finite = solve_group(Group(shape, group, 30), warm_start, horizon, downwash, solution)
    start = np.stack([warm_start[v, :, axis] for v in group for axis in (0, 2)], axis=1)
    apart = solve(joint_problem(shape, group, horizon, downwash), start, 30)
    assert (used, finite) == (apart.iterations, True)
    for c, (v, axis) in enumerate((v, axis) for v in group for axis in (0, 2)):
        assert np.array_equal(pos[v, :, axis], apart.states[:, 3 * c])
        assert np.array_equal(inputs[v, :, axis], apart.inputs[:, c])
        assert np.array_equal(active_set[v, :, axis], apart.active_set[:, c])
    assert np.isnan(pos[0]).all()


def test_all_free_axes_swept_at_once_are_those_swept_one_by_one():
    n, horizon, rng = 3, horizon_of(3, 4), np.random.default_rng(5)
    free, gains = rng.random((n, 3)) < 0.7, sweep_tables(MODELS)
    at_once, singly = (
        HorizonSolution(
            np.zeros((n, STAGES + 1, 3)),
            np.zeros((n, STAGES, 3)),
            np.zeros((n, STAGES, 3), np.int8),
            np.zeros(n, np.int8),
            0,
        )
        for _ in range(2)
    )
    crossing = sweep_axes(horizon, free, gains, at_once)
    for v, axis in np.argwhere(free):
        alone = np.zeros((n, 3), dtype=np.bool_)
        alone[v, axis] = True
        assert np.array_equal(sweep_axes(horizon, alone, gains, singly), alone & crossing)
    assert np.array_equal(at_once.pos, singly.pos)
    assert np.array_equal(at_once.inputs, singly.inputs)
    assert not crossing[~free].any()


def coupled(pairs: dict[tuple[int, int], float], vehicles: int = 8) -> DownwashHorizon:
    """Return pairs (i, j) with their gradients."""
    i, j = np.array(list(pairs), np.intp).reshape(-1, 2).T.copy()
    gradient = np.tile(np.array(list(pairs.values()))[:, None, None, None], (1, STAGES, 3, 3))
    return DownwashHorizon(np.zeros((vehicles, STAGES, 3)), i, j, gradient)


def test_groups_are_what_pairs_join_together():
    one = coupled(dict.fromkeys([(0, 1), (1, 0), (2, 4), (5, 6), (7, 9), (6, 5)], 1.0))  # 9 is nobody of ours
    assert groups_of(group_roots(one, 8, 8)) == [[0, 1], [2, 4], [5, 6], [7]]
    assert groups_of(group_roots(one, 8, 1)) == [[0], [1], [2], [5], [6], [7]]
    assert groups_of(group_roots(coupled({(3, 2): 1.0, (2, 1): -2.0, (1, 0): 0.5}), 4, 4)) == [[0, 1, 2, 3]]
    assert groups_of(group_roots(coupled({}), 3, 8)) == []


def test_a_group_that_would_be_too_large_is_split_where_vehicles_couple_least():
    chain = coupled({(3, 2): 3.0, (2, 1): -2.0, (1, 0): 1.0})
    assert groups_of(group_roots(chain, 4, 2)) == [[0, 1], [2, 3]]
    assert groups_of(group_roots(chain, 4, 3)) == [[1, 2, 3]]  # 0 feels nothing
    both = coupled({(0, 1): 3.0, (1, 0): 0.0, (2, 3): 2.0, (1, 2): -2.5, (3, 2): 0.0})
    assert groups_of(group_roots(both, 4, 2)) == [[0, 1], [2, 3]]
    assert groups_of(group_roots(both, 4, 3)) == [[0, 1, 2], [3]]


def test_bounds_are_thrust_tilt_and_weight():
    quat = np.random.default_rng(6).normal(size=(5, 4)) * 0.2
    low, high = input_bounds(quat, AccelerationLimits(2.0, 14.0), np.zeros((5, 2)))
    upright = 1.0 - 2.0 * (quat[:, 0] ** 2 + quat[:, 1] ** 2)
    expected = np.column_stack([np.full((5, 2), 2.0), 14.0 * upright - GRAVITY])
    assert np.array_equal(high, np.stack([expected, expected], axis=1))
    assert np.array_equal(low[:, :2], -expected[:, :2])
    assert np.array_equal(low[:, 2], np.minimum(-FALL * GRAVITY, expected[:, 2]))


def test_what_a_stage_keeps_lowers_its_bound_on_z_alone_and_never_below_the_least_input():
    level, most = np.array([[0.0, 0.0, 0.0, 1.0]]), AccelerationLimits(2.0, GRAVITY + 3.0)
    low, high = input_bounds(level, most, np.array([[0.0, 0.5, 20.0]]))
    least = -FALL * GRAVITY
    assert low.tolist() == [[-2.0, -2.0, least]]
    # 3 m/s^2 beyond the weight, to rounding
    assert np.allclose(high, [[[2.0, 2.0, 3.0], [2.0, 2.0, 2.5], [2.0, 2.0, least]]], rtol=1e-14)


def test_samples_between_are_numpys_interpolation():
    samples = np.random.default_rng(7).normal(size=(2, 9, 3))
    times = np.array([0.5, 1.0, 1.03, 1.3, 1.799, 1.8, 7.0])  # the first one and the last one outside
    found = interpolated(samples, times, 1.0, 0.1)
    for v in range(2):
        for c in range(3):
            expected = np.interp(times, 1.0 + 0.1 * np.arange(9), samples[v, :, c])
            assert np.allclose(found[v, :, c], expected, atol=1e-14)
    still = interpolated(np.ascontiguousarray(samples[:, :1]), np.zeros(2), 1.0, 0.1)
    assert np.array_equal(still, np.repeat(samples[:, :1], 2, axis=1))


def test_a_setpoint_is_on_its_plan_if_no_value_of_it_differs_or_is_no_number():
    plan = np.random.default_rng(9).normal(size=(2, 3, 9))
    here = plan[:, 0] + 0.9 * SAME
    assert is_on_plan(here, plan)
    for off in (1.1 * SAME, -1.1 * SAME, np.nan):
        moved = here.copy()
        moved[1, 8] = plan[1, 0, 8] + off
        assert not is_on_plan(moved, plan)


def test_the_observers_loop_is_its_plain_form():
    rng = np.random.default_rng(8)
    old = Estimate(*(rng.normal(size=(4, 3)) for _ in range(3)))
    fresh, known = np.array([True, False, True, True]), np.array([True, True, False, True])
    measured = MeasuredRows(*(rng.normal(size=(4, 3)) for _ in range(3)), fresh)
    args = old, measured, known, ObserverGain(0.5, 6.0, 20.0, 0.01), 0.8
    for one, other in zip(correct_estimate(*args), correct_estimate.py_func(*args), strict=True):
        assert np.allclose(one, other, atol=1e-14)
    pos, vel, d = correct_estimate(*args)
    assert np.array_equal(pos[2], measured.pos[2])
    assert np.array_equal(vel[2], measured.vel[2])
    assert np.array_equal(d[1], np.clip(old.disturbance[1], -0.8, 0.8))
