"""Two ways of solving (26) over a whole flight agree, keep the bound, and obey the dynamics."""

import numpy as np
import pytest
from global_mpc.collocation import solve_collocation
from global_mpc.networks import NetworkFit, NetworkSolutionParams, solve_networks
from global_mpc.problem import GlobalProblem, downwash, thrust_acceleration

from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.geometry.rotations import matrix_from_quat, quat_from_euler
from q2q_model.vehicle.constants import GRAVITY, TEXTBOOK_065


def slow_pass(count: int = 81, seconds: float = 8.0) -> GlobalProblem:
    """Return cf1 hovering and cf2 flying over it at 0.05 m/s: more downwash than 6.6 N can carry."""
    t = np.linspace(0.0, seconds, count)
    reference = np.zeros((2, count, 9))
    reference[0, :, 2] = 1.5
    reference[1, :, 1], reference[1, :, 2], reference[1, :, 4] = 0.2 - 0.05 * t, 2.0, -0.05
    return GlobalProblem(t, reference, TEXTBOOK_065, 6.6, PAPER_LAW)


def test_the_networks_jacobian_is_the_derivative_of_their_residual():
    fit = NetworkFit(slow_pass(30), NetworkSolutionParams(hidden=4))
    rng = np.random.default_rng(0)
    weights = fit.networks.random_weights(rng) + 0.1 * rng.normal(size=fit.networks.random_weights(rng).size)
    direction = rng.normal(size=weights.size)
    numeric = (fit.residual(weights + 1e-6 * direction) - fit.residual(weights - 1e-6 * direction)) / 2e-6
    # central differences at 1e-6 of residuals of order 1: 1e-10 rounding over 1e-6
    assert np.abs(fit.jacobian(weights) @ direction - numeric).max() < 1e-6


def test_networks_and_collocation_reach_the_same_flight():
    problem = slow_pass()
    by_collocation = solve_collocation(problem)
    by_networks = solve_networks(
        problem, NetworkSolutionParams(hidden=12, iterations=25), np.random.default_rng(1)
    )
    hover = downwash(PAPER_LAW, problem.reference[..., :3])[0, :, 2].min()
    assert hover < -0.38  # beyond the 0.344 m/s^2 that 6.6 N leave
    for solution in (by_collocation, by_networks):
        off = solution.pos[..., 2] - problem.reference[..., 2]
        assert np.sqrt((off**2).mean(axis=1)).max() < 0.012  # m
        assert np.sqrt((solution.defect[:, 2:-2] ** 2).mean()) < 0.02
    assert by_collocation.thrust.max() <= 6.6 + 1e-6  # IPOPT's bound relaxation
    assert by_networks.thrust.max() <= 6.6 + 0.03  # a penalty bends, it does not bind
    # twelve units against 81 free samples: the networks round the corners
    assert np.abs(by_collocation.pos - by_networks.pos).max() < 0.02


def test_without_downwash_the_reference_itself_is_the_solution():
    problem = slow_pass(41)
    calm = GlobalProblem(problem.times, problem.reference, TEXTBOOK_065, 6.6, NoInteraction())
    solution = solve_collocation(calm)
    assert np.abs(solution.pos - problem.reference[..., :3]).max() < 1e-6  # IPOPT's tolerance
    # the last samples' inputs hardly count, and 1e-6 of position is 1e-4 m/s^2 between samples
    assert np.allclose(solution.thrust[:, :-8], TEXTBOOK_065.hover_thrust, atol=1e-3)


def test_thrust_acts_along_the_body_axis():
    roll, pitch, thrust = 0.2, -0.3, 5.0
    axis = matrix_from_quat(quat_from_euler(roll, pitch, 0.0))[:, 2]
    acc = thrust_acceleration(np.array(thrust), np.array([roll, pitch]), 0.65)
    assert np.allclose(acc, axis * thrust / 0.65 - [0.0, 0.0, GRAVITY])


def test_a_bound_below_hover_is_refused():
    problem = slow_pass()
    with pytest.raises(ValueError, match=r"thrust_max = 6.0 N: above the hover thrust 6.377 N"):
        GlobalProblem(problem.times, problem.reference, TEXTBOOK_065, 6.0, PAPER_LAW)
