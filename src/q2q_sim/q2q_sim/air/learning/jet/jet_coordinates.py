"""Place of a vehicle in the jet of another: what a table of the jet is indexed by.

    tau = s max(dz_now, 0)            dz_now = z_j(t) - z_i(t)
    d   = r_j(t - tau) - r_i(t),      gap = d_z
    r   = |d_xy + c v_j,xy tau - k gap b_xy / b_z|      v_j, b of the source at t - tau

| symbol | name | meaning [unit] |
|---|---|---|
| s | slowness | 1 / travel speed of the air [s/m] |
| c | carried | share of the source's horizontal velocity that its air keeps [-] |
| k | slope | share of the source's tilt in the direction of its jet [-] |
| b | axis | body z of the source; its slope is cut at STEEPEST |
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.downwash.jet_kernel import STEEPEST
from q2q_model.signals.values import Array, Rows
from q2q_sim.air.learning.records.air_record import AirRecord


class Travel(NamedTuple):
    """How the air of a source travels."""

    slowness: float
    carried: float
    slope: float


@dataclass(frozen=True, slots=True)
class JetPlace:
    """Places of one vehicle in another's jet, (k,) each."""

    gap: Array
    """[m]"""
    radius: Array
    """[m]"""
    toward: Array
    """Horizontal unit vector from the vehicle to the jet's axis, world, (k, 2)."""
    thrust_ratio: Array
    """Thrust of the source at departure over that in clear air [-]."""


def jet_place(record: AirRecord, pair: tuple[int, int], rows: Rows, travel: Travel) -> JetPlace:
    """Return the place of vehicle pair[0] in the jet of pair[1] at rows (k,)."""
    i, j = pair
    motion = record.motion
    here = motion.pos[rows, i]
    tau = travel.slowness * np.maximum(motion.pos[rows, j, 2] - here[:, 2], 0.0)
    left = motion.t[rows] - tau
    pos, vel, axis = (_at(motion.t, values[:, j], left) for values in (motion.pos, motion.vel, motion.axis))
    apart = pos - here
    tilt = axis[:, :2] / np.maximum(axis[:, 2:], STEEPEST)
    tilt /= np.maximum(np.linalg.norm(tilt, axis=1, keepdims=True) / STEEPEST, 1.0)
    drift = travel.carried * vel[:, :2] * tau[:, None] - travel.slope * np.maximum(apart[:, 2:], 0.0) * tilt
    across = apart[:, :2] + drift
    radius = np.hypot(*across.T)
    toward = across / np.maximum(radius, np.finfo(float).tiny)[:, None]
    return JetPlace(apart[:, 2], radius, toward, np.interp(left, motion.t, record.thrust_ratio[:, j]))


def _at(t: Array, values: Array, when: Array) -> Array:
    """Return values (T, 3) at times (k,), linearly interpolated."""
    after = np.searchsorted(t, when).clip(1, t.size - 1)
    share = ((when - t[after - 1]) / (t[after] - t[after - 1])).clip(0.0, 1.0)[:, None]
    return np.asarray((1.0 - share) * values[after - 1] + share * values[after])
