"""Tube of tracking error: how far a vehicle of the swarm may be from its modified trajectory.

The tube is `tracking` (with `tracking_z`: horizontally, and `tracking_z` vertically). One that is learned
from flights covers their gaps of measurement, up to `grace`; while a measurement is older, the zone of the
vehicle grows by `drift` times the age beyond it. A vehicle is off its trajectory if it is measured outside
its tube, grown by what may have happened since the measurement of age A: drift A + acc_max A^2 / 2.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask
from q2q_planner.online.last_known_states import KnownStates
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion
from q2q_planner.online.safe.motion.followed_reference import SNAP_POS, SNAP_VEL
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.vectors import norm


class _Tube(NamedTuple):
    """Tube and drift; fields of SafeReplannerParams."""

    tracking: float
    """Radius of the tube; without a height, of a sphere [m]."""
    tracking_z: float
    """Half height of the tube [m]; 0: none."""
    drift: float
    """Speed of an unmeasured vehicle relative to its trajectory [m/s]."""
    grace: float
    """Age of a measurement that the tube covers [s]."""
    forget: float
    """Largest age that counts [s]."""
    acc: float
    """Largest acceleration of a vehicle [m/s^2]."""


def own_uncertainty(
    committed: CommittedMotion, states: KnownStates | None, params: SafeReplannerParams
) -> Array:
    """Return the growth (n, 2) of the swarm's zones; `states` None assumes ideal tracking."""
    age = np.zeros(len(committed.names)) if states is None else states.age
    return _uncertainty(age, _tube(params))


@compiled
def _uncertainty(age: Array, tube: _Tube) -> Array:
    growth = np.empty((age.size, 2))
    for row in range(age.size):
        unseen = max(min(age[row], tube.forget) - tube.grace, 0.0)
        growth[row, 0] = tube.tracking + SNAP_POS + tube.drift * unseen
        growth[row, 1] = SNAP_VEL + (tube.drift if unseen > 0.0 else 0.0)
    return growth


def off_trajectory(
    committed: CommittedMotion, states: KnownStates | None, params: SafeReplannerParams
) -> Mask:
    """Return which vehicles are off their modified trajectory by more than their age allows, (n,)."""
    if states is None:
        return np.zeros(len(committed.names), np.bool_)
    return _off(committed.rows.pos, states.pos, states.vel, states.age, _tube(params))


@compiled
def _off(committed: Array, pos: Array, vel: Array, ages: Array, tube: _Tube) -> Mask:
    off, error = np.empty(ages.size, np.bool_), np.empty(3)
    for row in range(ages.size):
        age = min(ages[row], tube.forget)
        for axis in range(3):
            error[axis] = pos[row, axis] + vel[row, axis] * age - committed[row, axis]
        since = tube.drift * age + 0.5 * tube.acc * age**2
        if tube.tracking_z > 0.0:
            aside, above = np.hypot(error[0], error[1]), abs(error[2])
            off[row] = aside > tube.tracking + since or above > tube.tracking_z + since
        else:
            off[row] = norm(error) > tube.tracking + since
    return off


def _tube(params: SafeReplannerParams) -> _Tube:
    return _Tube(
        params.tracking, params.tracking_z, params.drift, params.grace, params.forget, params.acc_max
    )
