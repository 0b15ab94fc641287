"""Whether vehicles could be back on their references in time, were each alone in the room.

No replanner is back sooner than the bounds of its motions let a vehicle be that nobody is in the way of.
Each axis is a linear programme over the jerk of every tick (SciPy, HiGHS): within `near` of the reference's
end from the given time on, and at rest there in the end.
"""

import numpy as np
from scipy.linalg import toeplitz
from scipy.optimize import linprog

from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams

REST = 0.5
"""Time within which a vehicle comes to rest once it is back [s]; from 0.1 m before, a stop takes 0.4 s."""
ROUNDING = 1e-6
"""Allowed excess over a bound [m/s^2], [m/s]: setpoints meet their bounds up to rounding."""


def can_return(offset: Array, seconds: float, near: float, params: SafeReplannerParams) -> bool:
    """Return whether all axes can be within `near` [m] of their ends in `seconds`, and come to rest there.

    Args:
        offset: position from its end [m], velocity, acceleration, world, (n, 3 axes, 3).
        seconds: time for it [s], whole ticks.
        near: distance of an axis that counts as back [m].
        params: bounds of the motions; a `jerk_max` of 0 does not bound the jerk.
    """
    away = offset.reshape(-1, 3)
    there = (np.abs(away) <= np.array([near, 0.0, 0.0])).all(axis=1)
    return all(_axis_can_return(axis, seconds, near, params) for axis in away[~there])


def _axis_can_return(axis: Array, seconds: float, near: float, params: SafeReplannerParams) -> bool:
    ticks, first = round((seconds + REST) / TICK_S), round(seconds / TICK_S) - 1
    t = TICK_S * np.arange(1, ticks + 1)
    pos, vel, acc = (
        axis[0] + t * axis[1] + 0.5 * t**2 * axis[2],
        axis[1] + t * axis[2],
        np.full(ticks, axis[2]),
    )
    since = TICK_S * np.arange(ticks)  # from the end of a tick's jerk to the end of a later tick
    by_acc, by_vel = np.full(ticks, TICK_S), TICK_S * (since + 0.5 * TICK_S)
    by_pos = ((since + TICK_S) ** 3 - since**3) / 6.0
    to_acc, to_vel, to_pos = (toeplitz(column, np.zeros(ticks)) for column in (by_acc, by_vel, by_pos))
    rows, most = _within(to_acc, acc, params.acc_max + ROUNDING)
    of_vel, most_vel = _within(to_vel, vel, params.speed_max + ROUNDING)
    of_pos, most_pos = _within(to_pos[first:], pos[first:], near)
    jerk = params.jerk_max or None
    found = linprog(
        np.zeros(ticks),
        np.concatenate((rows, of_vel, of_pos)),
        np.concatenate((most, most_vel, most_pos)),
        np.stack((to_vel[-1], to_acc[-1])),
        -np.array((vel[-1], acc[-1])),
        bounds=(None if jerk is None else -jerk, jerk),
        method="highs",
    )
    return bool(found.status == 0)


def _within(effect: Array, without: Array, most: float) -> tuple[Array, Array]:
    """Return rows and bounds of |without + effect @ jerk| <= most."""
    return np.concatenate((effect, -effect)), np.concatenate((most - without, most + without))
