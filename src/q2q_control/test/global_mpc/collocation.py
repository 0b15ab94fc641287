"""Direct collocation of (26): states and inputs at every sample, CasADi's derivatives, IPOPT.

    r_{k+1} - r_k = h/2 (v_k + v_{k+1}) - h^2/12 (a_{k+1} - a_k)       Hermite-Simpson's rule in one step
    v_{k+1} - v_k = h/2 (a_k + a_{k+1})
    a_k = U_k / m b(phi_k, theta_k) - g e_z + eta_k,   0 <= U_k <= U_max

The downwash enters as a cubic spline over horizontal distance and height difference, sampled from the model
once, so that any model of these two can be used, and IPOPT gets exact derivatives of a smooth law.
"""

import casadi
import numpy as np
from global_mpc.problem import (
    GlobalProblem,
    GlobalSolution,
    downwash,
    thrust_acceleration,
)

from q2q_model.downwash.interaction_model import InteractionModel, pairs_at_rest
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

ACROSS_MAX, DEPTH_MAX = 1.2, 2.5
"""Range of the spline, horizontally and vertically [m]; constant beyond."""
TILT_MAX = 0.6
"""Bound on roll and pitch [rad]: (26) does not bound them, and more is never needed."""

EFFORT = 1e-6
"""Weight of input changes between samples [m^2]: it makes the optimum unique."""

ITERATIONS = 200
"""Most steps of IPOPT."""


def solve_collocation(problem: GlobalProblem) -> GlobalSolution:
    """Return IPOPT's solution, started on the references.

    Raises:
        ValueError: IPOPT did not converge within ITERATIONS.
    """
    n, count, _ = problem.reference.shape
    law = _law(problem.model)
    pos = [casadi.MX.sym(f"r{j}", 3, count) for j in range(n)]
    vel = [casadi.MX.sym(f"v{j}", 3, count) for j in range(n)]
    inputs = [casadi.MX.sym(f"u{j}", 3, count) for j in range(n)]  # roll, pitch, U1 / (m g)
    step = float(problem.times[1] - problem.times[0])
    goal, equal = casadi.MX(0.0), []
    for j in range(n):
        acc = _acceleration(inputs[j])
        for i in range(n):
            acc = acc if i == j else acc + _downwash(law, pos[i] - pos[j])
        here, after = slice(0, count - 1), slice(1, count)
        mean = 0.5 * step * (vel[j][:, here] + vel[j][:, after])
        bend = step**2 / 12.0 * (acc[:, after] - acc[:, here])
        equal.append(casadi.vec(pos[j][:, after] - pos[j][:, here] - mean + bend))
        equal.append(
            casadi.vec(vel[j][:, after] - vel[j][:, here] - 0.5 * step * (acc[:, here] + acc[:, after]))
        )
        equal.append(pos[j][:, 0] - problem.reference[j, 0, :3])
        equal.append(vel[j][:, 0] - problem.reference[j, 0, 3:6])
        goal += casadi.sumsqr(pos[j] - problem.reference[j, :, :3].T)
        goal += EFFORT * casadi.sumsqr(casadi.diff(inputs[j], 1, 1))
    found = _solved((pos, vel, inputs), (goal, casadi.vertcat(*equal)), problem)
    tilt, thrust = found[2][..., :2], found[2][..., 2] * problem.vehicle.hover_thrust
    total = np.gradient(found[1], step, axis=1)
    by_thrust = thrust_acceleration(thrust, tilt, problem.vehicle.mass)
    return GlobalSolution(found[0], thrust, total - by_thrust - downwash(problem.model, found[0]))


QUIET: dict[str, object] = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False}
"""No output of IPOPT."""


def _solved(
    variables: tuple[list[casadi.MX], list[casadi.MX], list[casadi.MX]],
    program: tuple[casadi.MX, casadi.MX],
    problem: GlobalProblem,
) -> tuple[Array, Array, Array]:
    n, count, _ = problem.reference.shape
    stacked = casadi.vertcat(*(casadi.vec(part) for group in variables for part in group))
    options = QUIET | {"ipopt.max_iter": ITERATIONS, "ipopt.tol": 1e-8}
    nlp = {"x": stacked, "f": program[0], "g": program[1]}
    solver = casadi.nlpsol("global", "ipopt", nlp, options)
    hover = np.tile([0.0, 0.0, 1.0], (n, count, 1))
    start = np.concatenate(
        [problem.reference[..., :3].ravel(), problem.reference[..., 3:6].ravel(), hover.ravel()]
    )
    top = problem.thrust_max / problem.vehicle.hover_thrust
    free = np.full(2 * n * count * 3, np.inf)
    low = np.concatenate([-free, np.tile([-TILT_MAX, -TILT_MAX, 0.0], n * count)])
    high = np.concatenate([free, np.tile([TILT_MAX, TILT_MAX, top], n * count)])
    answer = solver(x0=start, lbx=low, ubx=high, lbg=0.0, ubg=0.0)
    if not solver.stats()["success"]:
        raise ValueError(
            f"IPOPT ended with {solver.stats()['return_status']}: allow more than {ITERATIONS} steps"
        )
    whole = np.array(answer["x"]).ravel().reshape(3, n, count, 3)
    return whole[0], whole[1], whole[2]


def _acceleration(inputs: casadi.MX) -> casadi.MX:
    roll, pitch, specific = inputs[0, :], inputs[1, :], GRAVITY * inputs[2, :]  # thrust over mass
    return casadi.vertcat(
        specific * casadi.cos(roll) * casadi.sin(pitch),
        -specific * casadi.sin(roll),
        specific * casadi.cos(roll) * casadi.cos(pitch) - GRAVITY,
    )


def _downwash(law: casadi.Function, rel: casadi.MX) -> casadi.MX:
    across = casadi.sqrt(casadi.sum1(rel[:2, :] ** 2) + 1e-8)  # smooth where the distance is zero
    eta = law(casadi.vertcat(across, rel[2, :]))
    return casadi.vertcat(casadi.MX.zeros(2, rel.shape[1]), eta)


def _law(model: InteractionModel) -> casadi.Function:
    """Return eta_z [m/s^2] of (horizontal distance, height difference) [m], one column a place."""
    across, depth = np.linspace(0.0, ACROSS_MAX, 121), np.linspace(-DEPTH_MAX, DEPTH_MAX, 251)
    rel = np.zeros((depth.size, across.size, 3))
    rel[..., 0], rel[..., 2] = across, depth[:, None]
    eta = model.acceleration(rel, pairs_at_rest(rel))[..., 2]
    spline = casadi.interpolant("eta", "bspline", [across.tolist(), depth.tolist()], eta.ravel().tolist())
    place = casadi.MX.sym("place", 2)
    inside = casadi.vertcat(
        casadi.fmin(place[0], ACROSS_MAX), casadi.fmax(casadi.fmin(place[1], DEPTH_MAX), -DEPTH_MAX)
    )
    return casadi.Function("law", [place], [spline(inside)])
