"""Problem (26) over a whole flight: references, dynamics and downwash.

    min  sum_k sum_j |r_j(t_k) - r_j,ref(t_k)|^2
    s.t. r_j'' = U_j / m b(phi_j, theta_j) - g e_z + eta(r_1 - r_2)          psi_j = 0
         0 <= U_j <= U_max,  r and r' given at the start

Readings: the downwash belongs in the second constraint and is missing in print; only the bound on U1 is
given. So U2 to U4 are free, any twice differentiable phi, theta can be reached by (1)-(3), and these inputs
and constraints can be dropped without changing the optimum. (26) has no transport delay, and its eta depends
on the relative position alone: `downwash` evaluates a law for pairs at rest at their present positions, and
`collocation` interpolates the same law by a spline, of which CasADi knows the derivatives. All blocks that
know a delay apply it by q2q_model.downwash.interaction_model.retarded_pairs.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel, pairs_at_rest
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle


@dataclass(frozen=True, slots=True)
class GlobalProblem:
    """Optimal control problem of n vehicles and T samples at equal steps."""

    times: Array
    """(T,) [s]"""
    reference: Array
    """Position [m], velocity [m/s], acceleration [m/s^2], world, (n, T, 9), from the initial state on."""
    vehicle: Vehicle
    thrust_max: float
    """U_max [N]."""
    model: InteractionModel

    def __post_init__(self) -> None:
        """Check that the samples fit together and the vehicles can hover."""
        n, count, width = self.reference.shape
        if self.times.shape != (count,) or width != 9 or n < 1:
            raise ValueError(
                f"reference {self.reference.shape} and times {self.times.shape}: expected (n, T, 9) and (T,)"
            )
        if self.thrust_max <= self.vehicle.hover_thrust:
            raise ValueError(
                f"thrust_max = {self.thrust_max} N: above the hover thrust {self.vehicle.hover_thrust:.3f} N"
            )


@dataclass(frozen=True, slots=True)
class GlobalSolution:
    """Solution of one method."""

    pos: Array
    """[m], world, (n, T, 3)."""
    thrust: Array
    """U1 [N], (n, T)."""
    defect: Array
    """r'' minus the acceleration by thrust and downwash [m/s^2], (n, T, 3)."""


def thrust_acceleration(thrust: Array, tilt: Array, mass: float) -> Array:
    """Return U1 / m b - g e_z [m/s^2], world, (..., 3), of U1 (...,) [N] and roll, pitch (..., 2) [rad]."""
    roll, pitch = tilt[..., 0], tilt[..., 1]
    axis = np.stack([np.cos(roll) * np.sin(pitch), -np.sin(roll), np.cos(roll) * np.cos(pitch)], axis=-1)
    return np.asarray(axis * (thrust / mass)[..., None] - [0.0, 0.0, GRAVITY])


def downwash(model: InteractionModel, pos: Array) -> Array:
    """Return every vehicle's downwash by all others [m/s^2], world, (n, T, 3), of paths (n, T, 3) [m]."""
    total = np.zeros_like(pos)
    for i in range(len(pos)):
        for j in range(len(pos)):
            if i != j:
                rel = pos[j] - pos[i]
                total[i] += model.acceleration(rel, pairs_at_rest(rel))
    return total
