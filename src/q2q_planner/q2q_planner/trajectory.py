"""Hold piecewise polynomial trajectories and read them at any time.

xi(t) = sum_k coefficients[piece, axis, k] (t - starts[piece])^k, with xi = x, y, z [m], yaw [rad]. Before
its start a trajectory rests at its first point, after its end at its last.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.signals import Array, Names, SetpointStatus, SwarmSetpoint

AXES = 4
"""x, y, z, yaw."""


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Hold one vehicle's piecewise polynomial."""

    durations: Array
    """Length of each piece [s], (pieces,), all above zero."""
    coefficients: Array
    """Ascending powers of the time since the piece's start, (pieces, 4, order)."""

    @property
    def duration(self) -> float:
        """Return the whole length [s]."""
        return float(self.durations.sum())

    def at(self, t: Array, derivative: int = 0) -> Array:
        """Return xi or a derivative of it at times t (...,) [s] from the plan's start: (..., 4)."""
        ends = np.cumsum(self.durations)
        clipped = np.clip(t, 0.0, ends[-1])
        piece = np.minimum(np.searchsorted(ends, clipped, side="right"), len(ends) - 1)
        tau = clipped - (ends - self.durations)[piece]
        value = _horner(_derive(self.coefficients, derivative)[piece], tau)
        resting = (t < 0.0) | (t > ends[-1])
        return np.where(resting[..., None], 0.0, value) if derivative > 0 else value


@dataclass(frozen=True, slots=True)
class SwarmPlan:
    """Hold the trajectories of a swarm, all starting at the same time."""

    names: Names
    trajectories: tuple[Trajectory, ...]
    """One a vehicle, in the order of names."""
    certified: bool = False
    """Proven to keep every pair out of the interference zone."""

    @property
    def duration(self) -> float:
        """Return the time of the longest trajectory [s]."""
        return max(trajectory.duration for trajectory in self.trajectories)


def setpoint_at(plan: SwarmPlan, t: float, start: float = 0.0) -> SwarmSetpoint:
    """Return every vehicle's setpoint at time t [s] of a plan that starts at `start` [s]."""
    when = np.asarray(t - start)
    pos, vel, acc = (_swarm_at(plan.trajectories, when, k) for k in range(3))
    return SwarmSetpoint(
        t=t,
        names=plan.names,
        pos=pos[:, :3],
        vel=vel[:, :3],
        acc=acc[:, :3],
        yaw=pos[:, 3],
        yaw_rate=vel[:, 3],
        status=np.full(len(plan.names), SetpointStatus.NOMINAL, dtype=np.uint8),
    )


def _swarm_at(trajectories: Sequence[Trajectory], t: Array, derivative: int) -> Array:
    return np.stack([trajectory.at(t, derivative) for trajectory in trajectories])  # (n, 4)


def _derive(coefficients: Array, times: int) -> Array:
    for _ in range(times):
        powers = np.arange(1, coefficients.shape[-1])
        coefficients = coefficients[..., 1:] * powers
    return coefficients


def _horner(coefficients: Array, tau: Array) -> Array:
    value = np.zeros(coefficients.shape[:-1])
    for k in range(coefficients.shape[-1] - 1, -1, -1):
        value = value * tau[..., None] + coefficients[..., k]
    return value
