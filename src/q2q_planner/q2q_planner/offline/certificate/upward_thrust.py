"""Least upward thrust that a trajectory needs, over the vehicle's weight, bounded for every t.

    (g + a_z(t)) / g >= LEAST_THRUST

Controllers command no less, whatever the vehicle: it does not follow a reference that falls faster. On a
stretch of time the quotient is a polynomial, bounded by its Bernstein control points (`branch_and_bound`).
"""

from typing import NamedTuple

import numpy as np

from q2q_model.trajectory.bernstein import control_points
from q2q_model.trajectory.polynomials import Trajectory, derive
from q2q_model.vehicle.attitude_limits import LEAST_THRUST
from q2q_model.vehicle.constants import GRAVITY
from q2q_planner.offline.certificate.branch_and_bound import least_on_stretches, polynomial_bounds

HEIGHT = 2
"""Axis z of a trajectory."""


class UpwardThrust(NamedTuple):
    """Least upward thrust of a trajectory."""

    share: float
    """Of the weight [-]; a bound from below, within 1e-5 (`branch_and_bound`)."""
    t: float
    """Time at which it is needed [s]."""

    @property
    def is_commanded(self) -> bool:
        """Return whether controllers command this little."""
        return self.share >= LEAST_THRUST

    def __str__(self) -> str:
        """Return the thrust in words, with what is allowed."""
        least = f"controllers command at least {LEAST_THRUST:g}"
        return f"needs an upward thrust of {self.share:.2g} times the weight, {least}"


def least_upward_thrust(trajectory: Trajectory) -> UpwardThrust:
    """Return the least upward thrust over all t."""
    durations = trajectory.durations
    shares = derive(trajectory.coefficients[:, HEIGHT], 2) / GRAVITY  # (pieces, order)
    shares[:, 0] += 1.0
    found = least_on_stretches(control_points(shares, durations), polynomial_bounds)
    start = float(np.sum(durations[: found.row]))
    return UpwardThrust(found.bound, start + found.share * float(durations[found.row]))
