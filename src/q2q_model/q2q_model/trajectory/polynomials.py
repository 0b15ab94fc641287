"""Piecewise polynomial trajectories and their evaluation.

xi(t) = sum_k coefficients[piece, axis, k] (t - starts[piece])^k, with xi = x, y, z [m], yaw [rad]. A
trajectory rests at its first point before its start and at its last after its end.
"""

from dataclasses import dataclass, field

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, SetpointStatus, Status, SwarmSetpoint

AXES = 4
"""x, y, z, yaw."""

_DERIVATIVES = 3
"""Derivatives in a setpoint: value, velocity, acceleration."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Piecewise polynomial of one vehicle."""

    durations: Array
    """Length of each piece [s], (pieces,), all above zero."""
    coefficients: Array
    """Ascending powers of the time since the piece's start, (pieces, 4, order)."""

    def __post_init__(self) -> None:
        """Check shapes and values.

        Raises:
            ValueError: a shape or value is not allowed.
        """
        pieces = self.durations.shape
        if self.coefficients.shape[:2] != (*pieces, AXES) or self.coefficients.ndim != 3 or pieces == (0,):
            shapes = f"{pieces} durations and {self.coefficients.shape} coefficients"
            raise ValueError(f"{shapes}: expected (pieces,) and (pieces, {AXES}, order), at least one piece")
        if not (np.isfinite(self.durations).all() and (self.durations > 0.0).all()):
            raise ValueError(f"durations {self.durations}: all must be finite and above 0 s")
        if not np.isfinite(self.coefficients).all():
            raise ValueError("a coefficient is not finite: polynomials need finite numbers")

    @property
    def duration(self) -> float:
        """Return the end of the last piece [s]."""
        return float(np.cumsum(self.durations)[-1])

    def at(self, t: Array, derivative: int = 0) -> Array:
        """Return xi or a derivative of it at times t (...,) [s] from the plan's start: (..., 4)."""
        ends = np.cumsum(self.durations)
        clipped = np.clip(t, 0.0, ends[-1])
        piece = np.minimum(np.searchsorted(ends, clipped, side="right"), len(ends) - 1)
        tau = clipped - (ends - self.durations)[piece]
        value = _horner(derive(self.coefficients, derivative)[piece], tau)
        resting = (t < 0.0) | (t > ends[-1])
        return np.where(resting[..., None], 0.0, value) if derivative > 0 else value


@dataclass(frozen=True, slots=True)
class _Table:
    """Polynomials of all vehicles in one array, for one compiled pass."""

    starts: Array
    """Start of each piece [s], (n, most pieces); beyond the last piece padded with infinity."""
    duration: Array
    """[s], (n,)"""
    coefficients: Array
    """Ascending powers as in Trajectory, (n, most pieces, 4, order)."""
    status: Status
    """NOMINAL for all vehicles, (n,), shared by all setpoints."""


@dataclass(frozen=True, slots=True, eq=False)
class SwarmPlan:
    """Trajectories of a swarm with a common start time."""

    names: Names
    trajectories: tuple[Trajectory, ...]
    """One a vehicle, in the order of names."""
    certified: bool = False
    """Whether every pair provably stays out of the interference zone."""
    zone_profile: tuple[tuple[float, float], ...] = ()
    """Corners (radius, height) of that zone's profile [m], of a ConvexZone; empty if unknown."""
    _table: _Table = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the rows and tabulate the polynomials.

        Raises:
            ValueError: names and trajectories do not match one to one.
        """
        if not self.names or len(self.names) != len(self.trajectories):
            counts = f"{len(self.names)} names for {len(self.trajectories)} trajectories"
            raise ValueError(f"{counts}: expected one trajectory per vehicle, at least one vehicle")
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"names {', '.join(self.names)}: each vehicle needs its own")
        object.__setattr__(self, "_table", _side_by_side(self.trajectories))
        setpoint_at(self, 0.0)  # loads the kernel before the first tick

    @property
    def duration(self) -> float:
        """Return the time of the longest trajectory [s]."""
        return max(trajectory.duration for trajectory in self.trajectories)

    def positions(self, t: Array) -> Array:
        """Return the positions of all vehicles at times t (T,) [s] from the start [m], world, (T, n, 3)."""
        return np.stack([trajectory.at(t)[:, :3] for trajectory in self.trajectories], axis=1)


def setpoint_at(plan: SwarmPlan, t: float, start: float = 0.0) -> SwarmSetpoint:
    """Return every vehicle's setpoint at time t [s] of a plan that starts at `start` [s]."""
    table = plan._table  # noqa: SLF001
    xi = np.empty((len(plan.names), _DERIVATIVES, AXES))
    swarm_at(table.starts, table.duration, table.coefficients, float(t - start), xi)
    return SwarmSetpoint(
        t=t,
        names=plan.names,
        pos=xi[:, 0, :3],
        vel=xi[:, 1, :3],
        acc=xi[:, 2, :3],
        yaw=xi[:, 0, 3],
        yaw_rate=xi[:, 1, 3],
        status=table.status,
    )


def derive(coefficients: Array, times: int) -> Array:
    """Return ascending coefficients (..., max(order - times, 1)) of a derivative."""
    for _ in range(times):
        if coefficients.shape[-1] == 1:
            return np.zeros_like(coefficients)
        coefficients = coefficients[..., 1:] * np.arange(1, coefficients.shape[-1])
    return coefficients


def _side_by_side(trajectories: tuple[Trajectory, ...]) -> _Table:
    n = len(trajectories)
    most = max(len(trajectory.durations) for trajectory in trajectories)
    order = max(trajectory.coefficients.shape[-1] for trajectory in trajectories)
    starts = np.full((n, most), np.inf)
    starts[:, 0] = 0.0
    coefficients = np.zeros((n, most, AXES, order))
    for row, trajectory in enumerate(trajectories):
        pieces = len(trajectory.durations)
        starts[row, 1:pieces] = np.cumsum(trajectory.durations)[:-1]
        coefficients[row, :pieces, :, : trajectory.coefficients.shape[-1]] = trajectory.coefficients
    duration = np.array([trajectory.duration for trajectory in trajectories])
    status = np.full(n, int(SetpointStatus.NOMINAL), dtype=np.uint8)
    status.flags.writeable = False
    return _Table(starts, duration, coefficients, status)


@compiled
def swarm_at(starts: Array, duration: Array, coefficients: Array, when: float, xi: Array) -> None:
    """Write xi, xi', xi'' of every vehicle at a time `when` since the start [s].

    Args:
        starts: of the pieces [s], (n, pieces).
        duration: of the trajectories [s], (n,).
        coefficients: ascending powers of the time in a piece, (n, pieces, 4, order).
        when: [s]
        xi: x, y, z [m], yaw [rad] and their first two derivatives, written, (n, 3, 4).
    """
    order = coefficients.shape[3]
    for i in range(duration.size):
        clipped = min(max(when, 0.0), duration[i])
        piece = 0
        while piece + 1 < starts.shape[1] and starts[i, piece + 1] <= clipped:
            piece += 1
        tau, resting = clipped - starts[i, piece], when < 0.0 or when > duration[i]
        for axis in range(AXES):
            value, vel, half_acc = 0.0, 0.0, 0.0
            for k in range(order - 1, -1, -1):  # Horner's scheme of a polynomial and its derivatives
                half_acc = half_acc * tau + vel
                vel = vel * tau + value
                value = value * tau + coefficients[i, piece, axis, k]
            xi[i, 0, axis] = value
            xi[i, 1, axis] = 0.0 if resting else vel
            xi[i, 2, axis] = 0.0 if resting else 2.0 * half_acc


def _horner(coefficients: Array, tau: Array) -> Array:
    value = np.zeros(coefficients.shape[:-1])
    for k in range(coefficients.shape[-1] - 1, -1, -1):
        value = value * tau[..., None] + coefficients[..., k]
    return value
