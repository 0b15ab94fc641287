"""Exact solution of the minimum snap problem (17), in both readings of its constraints.

min int mu_r ||r^(4)||^2 + mu_psi (psi^(2))^2 dt through the waypoints (Mellinger and Kumar, Minimum snap
trajectory generation and control for quadrotors, 2011; the paper, eq. 17, k_r = 4, k_psi = 2); as in the
paper, both weights are 1 (mu_r [s^7/m^2], mu_psi [s^3/rad^2]).

- `stop_and_go`: derivatives 1..3 (yaw: 1) are zero at every waypoint. Pieces and axes then decouple, and
  each is the Hermite piece of `hermite`: closed form. The 4th derivative at a waypoint has no trace under
  a snap cost (an arbitrarily short jerk step changes it at no cost), so p = 1..3 is the infimum of (17).
- `free`: rest only at both ends; inner waypoints fix the position. The optimum is the C^6 (yaw: C^2)
  spline; its nodal derivatives solve one banded, positive definite system of bandwidth 2k - 3 per axis.

| symbol | name | meaning [unit] |
|---|---|---|
| k_r | POSITION_HALF | order of the derivative of position in the cost, 4 |
| k_psi | YAW_HALF | order of the derivative of yaw in the cost, 2 |
"""

from collections.abc import Sequence
from typing import Literal, assert_never

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.hermite import piece_energies, pieces_from_nodes, power_gram
from q2q_model.trajectory.polynomials import AXES, SwarmPlan, Trajectory
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, check_swarm

POSITION_HALF = 4
YAW_HALF = 2

_GROUPS = ((slice(0, 3), POSITION_HALF), (slice(3, 4), YAW_HALF))
"""Columns of a waypoint, and the order of their derivative in the cost."""

LEAST_EIGENVALUE = 1e-10
"""Smallest eigenvalue of a system with a unit diagonal that is solved [-].

Measured against exact arithmetic: above it costs are within 2e-5 of the optimum, below 1e-12 they are up to
1e9 times it. Times of a ratio up to 300 in any order have 1e-9 or more.
"""
INVERSE_STEPS = 8
"""Steps of the inverse iteration for that eigenvalue [-].

Measured against all eigenvalues: of 3970 random systems the result is 1 to 1.5 times the smallest, and the
same ones are refused, from two steps on.
"""

Reading = Literal["stop_and_go", "free"]


def minimum_snap(vehicle: VehicleWaypoints, reading: Reading = "stop_and_go") -> Trajectory:
    """Return the trajectory of minimum cost (17) through a vehicle's waypoints, from its first time on.

    Raises:
        ValueError: read as `free`, its times are too unequal to be solved for.
    """
    durations = np.diff(vehicle.times)
    points = vehicle.points
    try:
        nodes = [_nodes(points[:, a], durations, half, reading) for a, half in _GROUPS]
    except np.linalg.LinAlgError as error:
        spans = f"times between waypoints from {durations.min():g} to {durations.max():g} s"
        advice = "give more even times, or the reading stop_and_go"
        raise ValueError(f"{vehicle.name}: {spans} are too unequal for the reading free: {advice}") from error
    pos, yaw = (pieces_from_nodes(one, durations) for one in nodes)
    coefficients = np.zeros((len(durations), AXES, 2 * POSITION_HALF))
    coefficients[:, :3] = pos
    coefficients[:, 3:, : 2 * YAW_HALF] = yaw
    return Trajectory(durations, coefficients)


def minimum_snap_plan(swarm: Sequence[VehicleWaypoints], reading: Reading = "stop_and_go") -> SwarmPlan:
    """Return the plan of minimum cost (17) for each vehicle by itself, without avoidance."""
    check_swarm(swarm)
    names = tuple(vehicle.name for vehicle in swarm)
    return SwarmPlan(names, tuple(minimum_snap(vehicle, reading) for vehicle in swarm))


def snap_cost(trajectory: Trajectory) -> float:
    """Return the cost (17) of a trajectory, exact for its polynomials."""
    pos = _energy(trajectory.coefficients[:, :3], trajectory.durations, POSITION_HALF)
    yaw = _energy(trajectory.coefficients[:, 3:], trajectory.durations, YAW_HALF)
    return pos + yaw


def plan_cost(plan: SwarmPlan) -> float:
    """Return the cost (18): the sum of (17) over the vehicles."""
    return sum(snap_cost(trajectory) for trajectory in plan.trajectories)


def _energy(coefficients: Array, durations: Array, derivative: int) -> float:
    order = coefficients.shape[-1]
    unit = coefficients * (durations[:, None] ** np.arange(order))[:, None, :]  # of u = t / T
    squares = np.einsum("paj,jk,pak->p", unit, power_gram(order, derivative), unit)
    return float((squares / durations ** (2 * derivative - 1)).sum())


def _nodes(values: Array, durations: Array, half: int, reading: Reading) -> Array:
    match reading:
        case "stop_and_go":
            nodes = np.zeros((*values.shape, half))
            nodes[..., 0] = values
            return nodes
        case "free":
            return _free_nodes(values, durations, half)
        case unknown:
            assert_never(unknown)


def _free_nodes(values: Array, durations: Array, half: int) -> Array:
    """Return nodal data (knots, axes, k): the derivatives at inner knots minimise the energy."""
    scale = float(durations.mean())  # dimensionless time keeps the system well conditioned
    nodes = np.zeros((*values.shape, half))
    nodes[..., 0] = values
    inner = len(values) - 2
    if inner == 0:
        return nodes
    energies = piece_energies(durations / scale, half)  # (pieces, 2k, 2k)
    banded, force = _inner_system(energies, values, half)
    from scipy.linalg import solveh_banded  # not needed to fly a finished plan; half a second to import

    _check_conditioned(banded)
    slopes = solveh_banded(banded, force, lower=True)  # (inner (k-1), axes)
    unscale = scale ** -np.arange(1, half, dtype=float)
    nodes[1:-1, :, 1:] = slopes.reshape(inner, half - 1, -1).swapaxes(1, 2) * unscale
    return nodes


def _check_conditioned(banded: Array) -> None:
    """Raise LinAlgError if rounding may decide the solution of a system in lower band storage.

    Cholesky's error is that of the system scaled to a unit diagonal (Demmel, On floating point errors in
    Cholesky, 1989). Inverse iteration gives its smallest eigenvalue.
    """
    from scipy.linalg import cho_solve_banded, cholesky_banded

    factor, root = cholesky_banded(banded, lower=True), np.sqrt(banded[0])
    vector = np.random.default_rng(0).standard_normal(root.size)  # has a part of every eigenvector
    for _ in range(INVERSE_STEPS):
        vector = root * cho_solve_banded((factor, True), root * (vector / np.linalg.norm(vector)))
    least = 1.0 / float(np.linalg.norm(vector))
    if not least >= LEAST_EIGENVALUE:
        raise np.linalg.LinAlgError(f"smallest eigenvalue {least:g}, solved down to {LEAST_EIGENVALUE:g}")


def _inner_system(energies: Array, values: Array, half: int) -> tuple[Array, Array]:
    """Return the lower band (2(k-1), n) and right side (n, axes) of the inner slopes' normal equations."""
    width = half - 1
    size = (len(values) - 2) * width
    banded, force = np.zeros((min(2 * width, size), size)), np.zeros((size, values.shape[1]))
    start, end = slice(1, half), slice(half + 1, 2 * half)
    for piece, energy in enumerate(energies):
        left, right = (piece - 1) * width, piece * width  # rows of the slopes at the piece's two knots
        pull = energy[:, [0, half]] @ values[piece : piece + 2]  # (2k, axes)
        if piece > 0:
            _add_band(banded, energy[start, start], left, left)
            force[left : left + width] -= pull[start]
        if piece < len(energies) - 1:
            _add_band(banded, energy[end, end], right, right)
            force[right : right + width] -= pull[end]
        if 0 < piece < len(energies) - 1:
            _add_band(banded, energy[end, start], right, left)
    return banded, force


def _add_band(banded: Array, block: Array, row: int, column: int) -> None:
    """Add a dense block at (row, column) to lower band storage banded[i - j, j]."""
    for i in range(block.shape[0]):
        for j in range(block.shape[1]):
            if row + i >= column + j:
                banded[row + i - column - j, column + j] += block[i, j]
