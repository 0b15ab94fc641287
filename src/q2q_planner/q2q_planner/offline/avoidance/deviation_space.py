"""Deviations of a minimum snap trajectory, in coordinates in which cost is a Euclidean norm.

Knots are added between the waypoints. The nodal data v (value and three derivatives at the knots) that the
waypoints leave free have the energy 1/2 v'Hv (`hermite`). With H = LL' and y = L'v,

    r(t) = r_0(t) + phi(t) y,    cost = cost_0 + ||y||^2,    phi(t) = (Hermite row at t) L^-T

for each of x, y, z, where r_0 is the minimum snap trajectory: it is the optimum over v, so the cross term
vanishes. Any y satisfies all waypoint constraints exactly, and the curve keeps three continuous derivatives.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from q2q_model.signals.values import Array, Rows
from q2q_model.trajectory.hermite import end_scales, hermite_matrix, piece_energies, pieces_from_nodes
from q2q_model.trajectory.polynomials import Trajectory
from q2q_planner.offline.certificate.shared_pieces import split_at
from q2q_planner.offline.minimum_snap.minimum_snap import POSITION_HALF, Reading
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints


@dataclass(frozen=True, slots=True, eq=False)
class DeviationSpace:
    """Deviations of one vehicle; y has m numbers per axis."""

    knots: Array
    """Times [s], rising, (k,)."""
    nodes: Array
    """L^-T: y to nodal data, (k, 4, m); zero where the waypoints fix them."""

    @property
    def dimension(self) -> int:
        """Return m."""
        return int(self.nodes.shape[-1])

    def rows(self, t: Array) -> Array:
        """Return phi at times t (s,): (s, m). Zero while the vehicle rests before or after its flight."""
        durations = np.diff(self.knots)
        piece = np.clip(np.searchsorted(self.knots, t, side="right") - 1, 0, len(durations) - 1)
        share = np.clip((t - self.knots[piece]) / durations[piece], 0.0, 1.0)
        unit = share[:, None] ** np.arange(2 * POSITION_HALF) @ hermite_matrix(POSITION_HALF)
        ends = unit * end_scales(durations[piece], POSITION_HALF)  # weights of the data at both knots, (s, 8)
        near, far = ends[:, :POSITION_HALF], ends[:, POSITION_HALF:]
        row = np.einsum("sp,spm->sm", near, self.nodes[piece]) + np.einsum(
            "sp,spm->sm", far, self.nodes[piece + 1]
        )
        return np.where(((t >= self.knots[0]) & (t <= self.knots[-1]))[:, None], row, 0.0)


def deviation_space(vehicle: VehicleWaypoints, reading: Reading, pieces: int) -> DeviationSpace:
    """Return the deviations of a vehicle with each stretch between waypoints cut into equal pieces."""
    return _space(tuple(vehicle.times.tolist()), reading, pieces)


@lru_cache(maxsize=64)
def _space(times: tuple[float, ...], reading: Reading, pieces: int) -> DeviationSpace:
    """Return the deviations between waypoints at these times [s]; those of a swarm are often the same."""
    inner = [np.linspace(a, b, pieces + 1)[:-1] for a, b in pairwise(times)]
    knots = np.concatenate([*inner, times[-1:]])
    free = _free(len(knots), pieces, reading)
    lengths = np.diff(knots)
    scale = np.tile(lengths.mean() ** -np.arange(POSITION_HALF, dtype=float), len(knots))  # conditioning
    energy = _energy(lengths)[np.ix_(free, free)] * scale[free] * scale[free, None]
    root = cholesky(energy, lower=True)
    nodes = np.zeros((len(scale), len(free)))
    nodes[free] = scale[free, None] * solve_triangular(root, np.eye(len(free)), lower=True, trans="T")
    return DeviationSpace(knots, nodes.reshape(len(knots), POSITION_HALF, -1))


def deform(trajectory: Trajectory, space: DeviationSpace, y: Array) -> Trajectory:
    """Return the trajectory deformed by y (m, 3)."""
    whole = split_at(trajectory, space.knots)
    nodes = np.einsum("kpm,ma->kap", space.nodes, y)
    coefficients = whole.coefficients.copy()
    coefficients[:, :3, : 2 * POSITION_HALF] += pieces_from_nodes(nodes, np.diff(space.knots))
    return Trajectory(whole.durations, coefficients)


def _free(knots: int, pieces: int, reading: Reading) -> Rows:
    """Return which of the 4 x knots nodal data no waypoint fixes."""
    fixed = np.zeros((knots, POSITION_HALF), dtype=np.bool_)
    fixed[::pieces, 0] = True
    fixed[[0, -1]] = True
    if reading == "stop_and_go":
        fixed[::pieces] = True
    return np.flatnonzero(~fixed)


def _energy(durations: Array) -> Array:
    """Return the energy of a curve as a quadratic form of its nodal data, (4 knots, 4 knots)."""
    size = POSITION_HALF * (len(durations) + 1)
    total = np.zeros((size, size))
    for piece, energy in enumerate(piece_energies(durations, POSITION_HALF)):
        at = slice(POSITION_HALF * piece, POSITION_HALF * (piece + 2))
        total[at, at] += energy
    return total
