"""Online replanner by a potential field: eqs (19)-(21).

The paper, section 4.2, after Khatib (Real-time obstacle avoidance, 1986), for any number of vehicles:

    r~_i'' = r_i'' - k_d (r~_i' - r_i') - k_p (r~_i - r_i) + sum_j F_s(r~_i - r~_j)
    F_s(dr) = exp(-(dx^2 + dy^2) / (2 alpha eps^2)) exp(-dz^2 / (2 beta eps^2)) K_s dr

The leading term is the reference's acceleration r'' (the print has r~, with which a pair settles at 1.25 r);
the widths of the Gaussian are alpha eps^2 and beta eps^2 as printed. The paper's parameters do *not* keep a
pair out of I(0.1, 1.1), and dx = dy = 0 is a horizontal equilibrium: this is the paper's law, kept for
comparison. `safe_replanner` is the one with a promise. F_s is a gradient only if K_s is proportional to
diag(1/alpha, 1/alpha, 1/beta); the default, equal along all axes, has no potential.

The error e = r~ - r is integrated between ticks in steps of at most STEP. Within a step the force is constant
and the linear part e'' = -k_d e' - k_p e + F is solved exactly (exponential Euler, first order in the step),
so all positive gains are stable. Pairs whose Gaussian is below CUTOFF are skipped.

| symbol | name | meaning [unit] |
|---|---|---|
| k_d | k_d | damping of the error [1/s] |
| k_p | k_p | stiffness of the error [1/s^2] |
| K_s | k_s | stiffness of the repulsion along x, y, z [1/s^2] |
| eps | eps | width of the repulsion [m] |
| alpha, beta | alpha, beta | horizontal and vertical width factors |
| e | SetpointError | r~ - r [m] |
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, log

import numpy as np
from scipy.linalg import expm

from q2q_model.downwash.interaction_model import Reach
from q2q_model.downwash.sweep_and_prune import pairs_in_reach
from q2q_model.signals.repeated_stamp import StampOrder, is_repeated
from q2q_model.signals.values import Array, SwarmSetpoint, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_planner.online.replanner import LONGEST_GAP
from q2q_planner.online.setpoint_error import (
    SetpointError,
    match_error_rows,
    no_error,
    reference_between,
    settle,
    shift_reference,
)

STEP = 0.01
"""Longest step of the integrator [s]: one tick at 100 Hz."""
CUTOFF = 1e-12
"""Smallest Gaussian that is computed: below 1e-11 m/s^2 with the paper's stiffness."""


@dataclass(frozen=True, slots=True)
class PotentialFieldParams:
    """Parameters of (19)-(21); defaults are the paper's, section 4.2."""

    enabled: bool = tunable(
        default=True,
        description=("avoid other vehicles; false: every vehicle returns to its reference and follows it"),
    )
    k_d: float = tunable(
        3.0,
        "damping of the deviation from the reference; larger values damp more",
        unit="1/s",
        low=0.0,
        high=100.0,
    )
    k_p: float = tunable(
        5.0,
        "stiffness of the deviation from the reference; larger values return faster",
        unit="1/s^2",
        low=1e-3,
        high=1e4,
    )
    k_s: tuple[float, ...] = tunable(
        (10.0, 10.0, 10.0),
        "stiffness of the repulsion between vehicles along x, y, z; larger values repel more",
        unit="1/s^2",
        low=0.0,
        high=1e4,
    )
    alpha: float = tunable(0.7, "factor on the squared horizontal width of the repulsion", low=1e-6, high=1e3)
    beta: float = tunable(0.5, "factor on the squared vertical width of the repulsion", low=1e-6, high=1e3)
    eps: float = tunable(0.3, "width of the repulsion between vehicles", unit="m", low=1e-3, high=10.0)

    def __post_init__(self) -> None:
        """Raise ValueError where a number is out of bounds."""
        check_bounds(self)
        if len(self.k_s) != 3:
            raise ValueError(f"PotentialFieldParams.k_s = {self.k_s}; must be three numbers, for x, y, z")

    @property
    def variance(self) -> Array:
        """Return the Gaussian's variances [m^2], (3,)."""
        return np.array([self.alpha, self.alpha, self.beta]) * self.eps**2

    @property
    def reach(self) -> Reach:
        """Return the distances beyond which the repulsion is below CUTOFF."""
        horizontal, _, vertical = np.sqrt(-2.0 * log(CUTOFF) * self.variance)
        return Reach(float(horizontal), float(vertical))


class PotentialField:
    """Replanner by (20)-(21). It assumes ideal tracking: `state` is not used."""

    def __init__(self, params: PotentialFieldParams | None = None) -> None:
        """Start on the reference."""
        self.params = params or PotentialFieldParams()
        self._order = StampOrder()
        self.reset()

    def configure(self, params: PotentialFieldParams) -> None:
        """Change the parameters in flight; the modified trajectories continue without a jump."""
        self.params = params

    def reset(self) -> None:
        """Forget the modified trajectories; the next update starts on the reference."""
        self._error = no_error(())
        self._on_reference = True
        self._order.reset()
        self._before: SwarmSetpoint | None = None
        self._output: SwarmSetpoint | None = None

    def update(self, setpoint: SwarmSetpoint, state: SwarmState | None) -> SwarmSetpoint:  # noqa: ARG002
        """Return the modified setpoints of the tick.

        A repeated stamp returns the same setpoints, and a late one its own with the newest error. The first
        of a clock that was set back keeps the error; a gap over LONGEST_GAP either way restarts on the
        reference; other gaps are integrated.
        """
        if is_repeated(self._output, setpoint.t, setpoint.names):
            return self._output
        if self._order.reject_stamp(setpoint.t):
            error = match_error_rows(self._error, setpoint.names)
            return _shifted(
                setpoint, error, swarm_repulsion(setpoint.pos + error.pos, self.params), self.params
            )
        if self._on_reference and not self.params.enabled:  # neither a repulsion nor an error to integrate
            self._before = self._output = setpoint
            return setpoint
        before = self._before
        if before is None or abs(setpoint.t - before.t) > LONGEST_GAP:
            self._error = no_error(setpoint.names)
        else:
            self._error = match_error_rows(self._error, setpoint.names)
            if setpoint.t > before.t:
                self._error = _advance(self._error, _rows_as(before, setpoint), setpoint, self.params)
        repulsion = swarm_repulsion(setpoint.pos + self._error.pos, self.params)
        self._error = settle(self._error, np.asarray(repulsion.any(axis=1)))
        self._on_reference = not (self._error.pos.any() or self._error.vel.any())
        self._before, self._output = setpoint, _shifted(setpoint, self._error, repulsion, self.params)
        return self._output


def repulsive_force(rel_pos: Array, params: PotentialFieldParams) -> Array:
    """Return F_s of (19) [m/s^2], (..., 3), on the vehicle at r_1, for rel_pos = r_1 - r_2 (..., 3)."""
    x, y, z = np.moveaxis(rel_pos**2 / params.variance, -1, 0)
    return np.asarray(np.exp(-0.5 * (x + y + z))[..., None] * np.asarray(params.k_s) * rel_pos)


def swarm_repulsion(pos: Array, params: PotentialFieldParams) -> Array:
    """Return the sum of the repulsions on every vehicle [m/s^2], (n, 3), at positions pos (n, 3)."""
    repulsion = np.zeros_like(pos)
    if not params.enabled:
        return repulsion
    i, j = pairs_in_reach(pos, params.reach)
    if i.size:
        force = repulsive_force(pos.take(i, axis=0) - pos.take(j, axis=0), params)
        for axis in range(3):
            repulsion[:, axis] = np.bincount(i, force[:, axis], len(pos))
    return repulsion


def _shifted(
    setpoint: SwarmSetpoint, error: SetpointError, repulsion: Array, params: PotentialFieldParams
) -> SwarmSetpoint:
    """Return the reference shifted by the error, with its acceleration by (20) under repulsions (n, 3)."""
    return shift_reference(setpoint, error, repulsion - params.k_d * error.vel - params.k_p * error.pos)


def _rows_as(before: SwarmSetpoint, setpoint: SwarmSetpoint) -> SwarmSetpoint:
    """Return the last tick's setpoint; this tick's if the vehicles have changed."""
    return before if before.names == setpoint.names else setpoint


def _advance(
    error: SetpointError, before: SwarmSetpoint, after: SwarmSetpoint, params: PotentialFieldParams
) -> SetpointError:
    """Return the error one tick later."""
    span = max(after.t - before.t, 0.0)
    steps = max(1, ceil(span / STEP - 1e-6))  # rounding of a stamp adds no step
    motion = _step_matrix(params.k_p, params.k_d, round(span / steps, 9))  # stamps are whole nanoseconds
    for step in range(steps):
        pos = reference_between(before, after, step / steps) + error.pos
        repulsion = swarm_repulsion(pos, params)
        if not (repulsion.any() or error.pos.any() or error.vel.any()):
            continue
        pos, vel = (row[0] * error.pos + row[1] * error.vel + row[2] * repulsion for row in motion)
        error = SetpointError(error.names, pos, vel)
    return error


@lru_cache(maxsize=16)
def _step_matrix(k_p: float, k_d: float, step: float) -> Array:
    """Return the (2, 3) map from (e, e', F) to (e, e') a step later, exact for constant F."""
    generator = np.array([[0.0, 1.0, 0.0], [-k_p, -k_d, 1.0], [0.0, 0.0, 0.0]])
    return np.asarray(expm(generator * step)[:2])
