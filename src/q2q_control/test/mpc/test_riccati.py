"""The structured solver finds the optimum that dense methods find, and keeps bounds when cut off."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import lsq_linear, minimize

from q2q_control.mpc.problem.axis_cost import AxisWeights
from q2q_control.mpc.problem.axis_model import axis_model, axis_models, transition
from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon, blank_solution
from q2q_control.mpc.problem.joint_problem import group_shape, joint_problem
from q2q_control.mpc.problem.lq_problem import LqProblem, cost, dense_matrices, input_matrix
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.axis_sweep import sweep_axes, sweep_tables
from q2q_control.mpc.solver.riccati import solve
from q2q_model.signals.values import Array
from q2q_model.tunable import tunable_of
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065, Vehicle

H = 0.05
"""Stage [s]."""
FREE_RATE = np.full(3, np.inf)
ALTITUDES = np.tile([False, False, True], (6, 1))
"""Altitude axes of six vehicles."""
MODELS = (
    axis_model(0.15, H, AxisWeights(2.0, 1.0)),
    axis_model(0.15, H, AxisWeights(2.0, 1.0)),
    axis_model(0.07, H, AxisWeights(5.0, 0.5)),
)


def horizon(
    rng: np.random.Generator, n: int, stages: int, bound: float, slew_max: Array = FREE_RATE
) -> Horizon:
    """Return a question whose answer meets bounds of +-bound [m/s^2] when that is small.

    The upper bound falls by a fifth along the horizon.
    """
    start = rng.normal(size=(n, 3, 3)) * [0.3, 0.3, 0.05]
    reference = rng.normal(size=(n, stages + 1, 9)) * 0.1
    low, high = np.full((n, 3), -bound), np.empty((n, stages, 3))
    high[:] = bound * np.linspace(1.0, 0.8, stages)[:, None]
    path = rng.normal(size=(n, stages + 1, 3))
    return Horizon(start, reference, rng.normal(size=(n, stages, 3)) * 0.1, path, low, high, slew_max)


def pairs(rng: np.random.Generator, n: int, stages: int, gradient: float) -> DownwashHorizon:
    """Return gradients between all pairs."""
    i, j = np.nonzero(~np.eye(n, dtype=bool))
    return DownwashHorizon(np.zeros((n, stages, 3)), i, j, rng.normal(size=(len(i), stages, 3, 3)) * gradient)


def problem(seed: int, n: int, stages: int, bound: float, slew_max: Array = FREE_RATE) -> LqProblem:
    """Return a joint problem of n vehicles on z, coupled by gradients of downwash."""
    rng = np.random.default_rng(seed)
    asked = horizon(rng, n, stages, bound, slew_max)
    shape = group_shape(n, (2,), MODELS)
    return joint_problem(shape, np.arange(n), asked, pairs(rng, n, stages, 0.5))


def condensed(asked: LqProblem) -> tuple[Array, Array]:
    """Return M, b with cost = |M u - b|^2 for all inputs stacked: the dense way."""
    a, b = dense_matrices(asked), input_matrix(asked)
    stages, n = asked.low.shape
    effect, free = np.zeros((3 * n, stages * n)), asked.start.copy()
    rows: list[Array] = []
    right: list[Array] = []

    def add(weight: Array, matrix: Array, value: Array) -> None:
        rows.append(weight @ matrix)
        right.append(weight @ value)

    for k in range(stages):
        own = np.zeros((n, stages * n))
        own[:, k * n : (k + 1) * n] = np.eye(n)
        add(np.diag(np.sqrt(asked.state_weight.ravel())), effect, asked.target[k] - free)
        add(np.diag(np.sqrt(asked.input_weight[:, 0])), own, asked.input_target[k])
        add(np.diag(np.sqrt(asked.input_weight[:, 1])), own - effect[2::3], free[2::3])
        effect, free = a[k] @ effect + b @ own, a[k] @ free + asked.drift[k]
    for c in range(n):
        part = slice(3 * c, 3 * c + 3)
        root = np.linalg.cholesky(asked.terminal[c]).T
        add(root, effect[part], asked.target[-1][part] - free[part])
    return np.concatenate(rows), np.concatenate(right)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("n", "bound"), [(1, 0.3), (2, 0.3), (2, 1.0), (3, 0.5)])
def test_bounded_answer_equals_a_dense_bounded_least_squares(seed: int, n: int, bound: float):
    asked = problem(seed, n, 25, bound)
    answer = solve(asked, iterations=60)
    matrix, right = condensed(asked)
    dense = lsq_linear(matrix, right, (asked.low.ravel(), asked.high.ravel()), method="bvls", tol=1e-14)
    assert answer.converged
    # bvls stops at a relative cost change of 1e-14: inputs agree to its square root
    assert np.allclose(answer.inputs.ravel(), dense.x, atol=1e-6)
    assert cost(asked, answer.states, answer.inputs) == pytest.approx(2.0 * dense.cost, rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_rate_bounds_are_met_at_the_optimum_that_slsqp_finds(seed: int):
    slew_max = 0.1
    asked = problem(seed, 1, 8, 1.0, np.full(3, slew_max))
    answer = solve(asked, iterations=60)
    matrix, right = condensed(asked)
    a, b = dense_matrices(asked), input_matrix(asked)

    def lead(inputs: Array) -> Array:
        state, leads = asked.start, []
        for k, u in enumerate(inputs):
            leads.append(u - state[2])
            state = a[k] @ state + b @ [u] + asked.drift[k]
        return np.array(leads)

    found = minimize(
        lambda u: ((matrix @ u - right) ** 2).sum(),
        answer.inputs.ravel() * 0.0 + asked.start[2],
        jac=lambda u: 2.0 * matrix.T @ (matrix @ u - right),
        bounds=np.hstack([asked.low, asked.high]),
        constraints=[
            {"type": "ineq", "fun": lambda u: slew_max - lead(u)},
            {"type": "ineq", "fun": lambda u: slew_max + lead(u)},
        ],
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 500},
    )
    assert answer.converged
    assert np.abs(lead(answer.inputs.ravel())).max() <= slew_max + 1e-9
    assert np.allclose(answer.inputs.ravel(), found.x, atol=1e-5)  # SLSQP's square root of ftol


def test_states_follow_the_dynamics_from_the_start():
    asked = problem(3, 2, 20, 0.4)
    answer = solve(asked)
    a, b = dense_matrices(asked), input_matrix(asked)
    after = (
        np.einsum("kij,kj->ki", a, answer.states[:-1]) + answer.inputs @ b.T + asked.drift
    )  # A x + B u + c
    assert np.array_equal(answer.states[0], asked.start)
    assert np.allclose(after, answer.states[1:], atol=1e-12)


def test_a_solve_that_is_cut_off_says_so_and_keeps_every_bound():
    asked = problem(1, 2, 30, 0.2, np.full(3, 0.15))
    answer = solve(asked, iterations=1)
    assert not answer.converged
    acc = answer.states[:-1, 2::3]
    assert (answer.inputs <= asked.high + 1e-12).all()
    assert (answer.inputs >= asked.low - 1e-12).all()
    lead = answer.inputs - acc
    outside = (acc > asked.high) | (acc < asked.low)  # there the bound wins over the rate
    assert np.abs(lead[~outside]).max() <= 0.15 + 1e-12


def test_the_last_active_set_as_a_warm_start_needs_one_recursion():
    asked = problem(2, 2, 40, 0.3)
    first = solve(asked)
    again = solve(asked, first.active_set)
    assert first.iterations > 1
    assert again.iterations == 1
    assert np.array_equal(again.inputs, first.inputs)


def test_the_sweep_of_separate_axes_equals_the_general_recursion():
    rng = np.random.default_rng(5)
    asked = horizon(rng, 4, 40, 100.0)
    swept = blank_solution(4, 40)
    crossing = sweep_axes(asked, ALTITUDES[:4], sweep_tables(MODELS), swept)
    shape = group_shape(1, (2,), MODELS)
    none = DownwashHorizon(np.zeros((4, 40, 3)), np.zeros(0, int), np.zeros(0, int), np.zeros((0, 40, 3, 3)))
    assert not crossing.any()
    for v in range(4):
        answer = solve(joint_problem(shape, np.array([v]), asked, none))
        assert np.allclose(swept.inputs[v, :, 2], answer.inputs[:, 0], atol=1e-10)  # rounding of 40 steps
        assert np.allclose(swept.pos[v, :, 2], answer.states[:, 0], atol=1e-10)


def test_the_sweep_reports_which_axes_cross_a_bound():
    rng = np.random.default_rng(6)
    asked = horizon(rng, 6, 40, 3.0)
    swept = blank_solution(6, 40)
    crossing = sweep_axes(asked, ALTITUDES, sweep_tables(MODELS), swept)
    assert np.array_equal(crossing[:, 2], np.abs(swept.inputs[:, :, 2]).max(axis=1) > 3.0)
    assert 0 < crossing.sum() < 6
    assert not crossing[:, :2].any()


@pytest.mark.parametrize("lag", [0.02, 0.07, 0.5])
def test_an_axis_steps_exactly_as_the_matrix_exponential(lag: float):
    rates = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, -1 / lag, 1 / lag], [0, 0, 0, 0]], dtype=float)
    exact = expm(rates * H)
    a, b = transition(lag, H)
    assert np.allclose(a, exact[:3, :3], atol=1e-14)
    assert np.allclose(b, exact[:3, 3], atol=1e-14)


def test_an_axis_without_lag_is_a_double_integrator():
    a, b = transition(0.0, H)
    assert np.allclose(a, [[1, H, 0], [0, 1, 0], [0, 0, 0]])
    assert np.allclose(b, [0.5 * H**2, H, 1.0])


def test_unbounded_weights_place_the_poles_they_promise():
    fine, bandwidth = 1e-4, 5.0
    model = axis_model(0.0, fine, AxisWeights(bandwidth, 0.0))
    b, p = model.input_gain, model.cost.terminal
    feedback = (b @ p @ model.transition) / (model.cost.input_weight[0] + b @ p @ b)
    closed = (model.transition - np.outer(b, feedback))[:2, :2]  # the acceleration has no memory
    placed = np.log(np.linalg.eigvals(closed)) / fine
    expected = np.roots([1.0, np.sqrt(2.0) * bandwidth, bandwidth**2])
    # sampled at w h = 5e-4: poles err by a few times that
    assert np.allclose(np.sort_complex(placed), np.sort_complex(expected), rtol=5e-3)


@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065], ids=lambda one: one.name)
@pytest.mark.parametrize(
    ("name", "axis", "scale"), [("thrust_rate_max", 2, 1.0), ("tilt_rate_max", 0, GRAVITY)]
)
def test_at_the_least_rates_allowed_nearly_every_problem_is_solved(
    vehicle: Vehicle, name: str, axis: int, scale: float
) -> None:
    """Rate bounds let the updates of the active set cycle where many of them bind."""
    low = tunable_of(MpcParams.__dataclass_fields__[name]).low
    assert low is not None
    assert solved(MpcParams(), vehicle, axis, scale * low) >= 190  # 95 %; at a tenth of these 40 % and fewer


def test_at_a_high_bandwidth_most_problems_are_solved_by_some_more_recursions() -> None:
    """At 12 rad/s and the default rate; inputs updated one by one after three recursions solved 76 %."""
    params = replace(MpcParams(), bandwidth_z=12.0, iterations_max=30)
    assert solved(params, CRAZYFLIE_2_0, 2, params.thrust_rate_max) >= 170  # 85 %


def solved(params: MpcParams, vehicle: Vehicle, axis: int, rate: float) -> int:
    """Return how many of 200 random problems are solved at a rate of the acceleration [m/s^3]."""
    models = axis_models(params, vehicle)
    slew_max = np.full(3, rate * params.step / (1.0 - models[axis].transition[2, 2]))
    shape, none = group_shape(1, (axis,), models, params.terminal_weight), np.zeros(0, np.intp)
    count = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        asked = horizon(rng, 1, params.steps, 3.0, slew_max)
        gusts = np.repeat(rng.normal(size=(1, params.steps // 4, 3)) * 1.5, 4, axis=1)
        asked = asked._replace(reference=0.0 * asked.reference, push=gusts)
        downwash = DownwashHorizon(gusts, none, none, np.zeros((0, params.steps, 3, 3)))
        joint = joint_problem(shape, np.array([0]), asked, downwash)
        count += solve(joint, iterations=params.iterations_max).converged
    return count
