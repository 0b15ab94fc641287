"""Gains of the recorded controllers by a robust regression of their commands.

Over all vehicles of a flight, |f| is fitted to T / m, and f_xy to f_z times the commanded tilt where commands
of the attitude were recorded. f and the symbols are those of recorded_law. The parameters are the gains of z,
those of x and y, and one vertical constant of each vehicle. Lateral gains enter |f| by the tilt only, so
typical ones stand in where a flight says little.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from q2q_model.geometry.rotations import UP
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight

LEAST_S = 2.0
"""Least time of all vehicles with commands, and of those in clear air [s]."""
FEWEST_SAMPLES = 40
"""Fewest samples of references in that time: those of 20 Hz in 2 s."""
ROW_ERROR = 0.01
"""Residual of T / m above which a row loses weight [m/s^2]: three times that of a swap."""
TYPICAL = np.array([20.0, 10.0, 0.6])
"""Lateral K_p, K_d, K_i where a flight does not determine them: those of the flights of June 2020."""
TYPICAL_SPREAD = 0.5
"""Standard deviation of lateral gains between laws, over their value [-]."""
ROWS_TOGETHER = 100
"""Rows that are one independent one: the residuals of a second have one cause."""


@dataclass(frozen=True, slots=True)
class ForceFit:
    """Gains of one flight's controllers."""

    k_p: Array
    """(3,)"""
    k_d: Array
    """(3,)"""
    k_i: Array
    """(3,)"""
    rms: float
    """Standard deviation of the residual of T / m, from the median [m/s^2]."""
    loss: float
    """Robust sum of squares of all residuals [m^2/s^4]."""


@dataclass(frozen=True, slots=True)
class ForceRows:
    """k rows; their parameters x, (6 + n,), are K_p, K_d, K_i of z, those of x and y, and the constants."""

    errors: Array
    """e, e' and xi, (3, k, 3)."""
    plain: Array
    """a_ref + g e_z - eta_ff e_z [m/s^2], (k, 3)."""
    own: Mask
    """Vehicle of each row, (k, n)."""
    wanted: Array
    """T / m [m/s^2], (k,)."""
    tilt: Array
    """Commanded f_xy / f_z, (k, 2), (0, 2) where it was not recorded."""

    def force(self, x: Array) -> Array:
        """Return f [m/s^2], (k, 3)."""
        gains = np.stack([x[3:6], x[3:6], x[:3]], axis=1)  # K_p, K_d, K_i of x, y and z
        feed = np.einsum("gj,gkj->kj", gains, self.errors) + (self.own @ x[6:])[:, None] * UP
        return np.asarray(self.plain + feed)

    def missed(self, x: Array) -> Array:
        """Return |f| - T / m, and f_xy - f_z tilt, [m/s^2], (k,) or (3 k,)."""
        force = self.force(x)
        aside = force[: len(self.tilt), :2] - force[: len(self.tilt), 2:] * self.tilt
        return np.concatenate([np.linalg.norm(force, axis=1) - self.wanted, *aside.T])

    def slopes(self, x: Array) -> Array:
        """Return the derivatives of `missed` by x, one row for each."""
        axis = self.force(x) / np.linalg.norm(self.force(x), axis=1, keepdims=True)
        if not len(self.tilt):
            return self._along(axis)
        aside = [across - tilt[:, None] * UP for across, tilt in zip(np.eye(3)[:2], self.tilt.T, strict=True)]
        return np.vstack([self._along(one) for one in (axis, *aside)])

    def _along(self, axis: Array) -> Array:
        """Return the derivatives of the force along axes (k, 3) by x, (k, 6 + n)."""
        along = axis * self.errors  # (3, k, 3)
        vertical, lateral = along[..., 2].T, along[..., :2].sum(axis=-1).T
        return np.column_stack([vertical, lateral, axis[:, 2:] * self.own])


def fit_force(flight: TrackedFlight, limited: Mask, mass: float) -> ForceFit:
    """Return the gains of vehicles of a mass [kg], from rows that are not `limited`, (T, n, 3).

    Raises:
        ValueError: fewer than LEAST_S with commands or FEWEST_SAMPLES of references in them.
    """
    commanded = flight.usable & ~limited.any(axis=-1) & np.isfinite(flight.thrust)
    rows, seconds = commanded & flight.sure, commanded.sum() * flight.dt
    if seconds < LEAST_S or rows.sum() < FEWEST_SAMPLES or limited.any(axis=-1).all(axis=0).any():
        raise ValueError(
            f"flight {flight.name} cannot be flown again: {seconds:.1f} s with thrust commands, and "
            f"{rows.sum()} samples of references with rates in them; the gains of its controllers need "
            f"{LEAST_S:g} s, {FEWEST_SAMPLES} samples, and rates of each vehicle"
        )
    system = ForceRows(
        errors=np.stack([error[rows] for error in tracking_errors(flight)]),
        plain=(flight.ref_acc + (GRAVITY - flight.compensated[..., None]) * UP)[rows],
        own=np.nonzero(rows)[1][:, None] == np.arange(len(flight.names)),
        wanted=flight.thrust[rows] / mass,
        tilt=np.zeros((0, 2)) if flight.tilt is None else flight.tilt[rows],
    )
    weight = ROW_ERROR * np.sqrt(ROWS_TOGETHER) / TYPICAL_SPREAD
    prior = np.zeros((3, 6 + len(flight.names)))
    prior[:, 3:6] = np.diag(weight / TYPICAL)
    found = least_squares(
        lambda x: np.append(system.missed(x), prior @ x - weight),
        np.concatenate([TYPICAL, TYPICAL, np.zeros(len(flight.names))]),
        jac=lambda x: np.vstack([system.slopes(x), prior]),
        loss="soft_l1",
        f_scale=ROW_ERROR,
    )
    x = found.x
    k_p, k_d, k_i = (np.array([xy, xy, z]) for xy, z in zip(x[3:6], x[:3], strict=True))
    rms = 1.4826 * float(np.median(np.abs(system.missed(x)[: rows.sum()])))
    return ForceFit(k_p, k_d, k_i, rms, float(found.cost))


def tracking_errors(flight: TrackedFlight) -> tuple[Array, Array, Array]:
    """Return e, e' and xi, (T, n, 3) each."""
    error = flight.ref_pos - flight.pos
    return error, flight.ref_vel - flight.vel, np.cumsum(error, axis=0) * flight.dt
