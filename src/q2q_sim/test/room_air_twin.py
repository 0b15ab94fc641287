"""Push and torque of a room's air in plain numpy, from the equations of q2q_sim.air.room_air."""

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from q2q_model.geometry.rotations import rotate_inverse
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.air_terms import INSIDE
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake import Push
from q2q_sim.air.wake_laws import BLEND


def resting_push(air: RoomAir, pos: Array, quat: Array, thrust_ratio: Array) -> Push:
    """Return the mean push on vehicles that have always been where they are; thrust_ratio is T / (m g)."""
    n = len(pos)
    down, up, torque = np.zeros(n), np.zeros(n), np.zeros((n, 3))
    for j in range(n):
        met = [(i, *_place(air, pos[i] - pos[j], _slope(quat[j]))) for i in range(n) if i != j]
        under = [(i, dz, away, *_push(air, dz, np.hypot(*away))) for i, dz, away in met if dz > -BLEND]
        for i, dz, away, push, weight in under:
            left = 1.0
            for _, other_dz, other, other_push, other_weight in under:
                if other_dz < dz:
                    left *= 1.0 - other_weight * _taken(air, other_dz, np.hypot(*other), other_push)
            strength = left * thrust_ratio[j] * weight
            down[i] += strength * push
            up[j] += air.jet.upper_ratio * strength * push
            torque[i] += _edge(air, dz, away, strength)
    eta = up - down
    return Push(np.column_stack([np.zeros((n, 2)), eta]), rotate_inverse(quat, torque))


def _slope(quat: Array) -> Array:
    x, y, z, w = quat
    upright = 1.0 - 2.0 * (x * x + y * y)
    return np.array([2.0 * (x * z + w * y), 2.0 * (y * z - w * x)]) / upright


def _place(air: RoomAir, rel: Array, slope: Array) -> tuple[float, Array]:
    """Return dz, and the way from the axis to the vehicle."""
    dz = -rel[2]
    axis = max(dz, 0.0) * (np.array(air.jet.bend) - air.jet.slope * slope)
    return dz, rel[:2] - axis


def _spread(air: RoomAir, dz: float) -> float:
    return max(dz / air.jet.gaps_m[-1], 1.0)


def _push(air: RoomAir, dz: float, radius: float) -> tuple[float, float]:
    """Return P and the weight of the lower part."""
    jet, spread = air.jet, _spread(air, dz)
    table = RegularGridInterpolator((jet.gaps_m, jet.radii_m), jet.push_mps2)
    along = np.clip(0.5 * (dz / BLEND + 1.0), 0.0, 1.0)
    weight = along**2 * (3.0 - 2.0 * along) / spread**2
    gap = np.clip(abs(dz) / spread, jet.gaps_m[0], jet.gaps_m[-1])
    if not _is_in(air, gap, radius / spread):
        return 0.0, 0.0
    return float(table((gap, radius / spread))), float(weight)


def _is_in(air: RoomAir, gap: float, radius: float) -> bool:
    """Return whether a vehicle feels push at its place or farther out, or absorbs more than 0.1 %."""
    jet = air.jet
    row, column = np.searchsorted(jet.gaps_m[1:-1], gap), np.searchsorted(jet.radii_m, radius, side="right")
    feels = bool(jet.push_mps2[row : row + 2, column - 1 :].any())
    absorbs = air.absorption is not None and (
        air.absorption.share * np.exp(-0.5 * (radius / air.absorption.width_m) ** 2) > 1e-3
    )
    return bool(radius < jet.radii_m[-1] and (feels or absorbs))


def _taken(air: RoomAir, dz: float, radius: float, push: float) -> float:
    if air.absorption is None:
        return 0.0
    aside = radius / _spread(air, dz) / air.absorption.width_m
    return max(air.absorption.share * np.exp(-0.5 * aside**2), push / GRAVITY)


def _edge(air: RoomAir, dz: float, away: Array, strength: float) -> Array:
    if air.edge_torque is None or strength == 0.0:
        return np.zeros(3)
    radius = np.hypot(*away)
    ratio = radius / _spread(air, dz) / air.edge_torque.radius_m
    size = air.edge_torque.peak_nm * strength * ratio * np.exp(0.5 * (1.0 - ratio**2))
    # the push on the side of the axis is the larger one: torque = (-away) x (down)
    return size * np.cross(np.array([-away[0], -away[1], 0.0]) / radius, [0.0, 0.0, -1.0])


def deviation(air: RoomAir, eta: Array) -> Array:
    """Return the standard deviation of the residual."""
    size = np.abs(eta)
    return np.asarray(air.residual.floor_mps2 * np.minimum(size / INSIDE, 1.0) + air.residual.slope * size)
