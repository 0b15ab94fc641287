"""Push that an accelerometer feels beyond thrust and predicted downwash.

    y = (R f_body)_z - (T b)_z / m - eta

at the sample's own time: attitude R, thrust T by then (with delay and lag of the command path) and eta are
those of the tick with its stamp. A sample may arrive before its tick or up to OLDEST after it.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

from q2q_model.downwash.residual_process import OLDEST
from q2q_model.geometry.rotations import rotate
from q2q_model.signals.values import Array, Names, SwarmImu, index_of

SAME_STAMP = 1e-6
"""[s]"""


class ExplainedTick(NamedTuple):
    """What thrust and prediction explain at a tick."""

    t: float
    """[s]"""
    names: Names
    quat: Array
    """(n, 4)"""
    acc: Array
    """Vertical specific force by thrust and predicted downwash [m/s^2], (n,)."""


class FeltPush:
    """Memory of ticks and of the sample whose tick has not come yet."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._ticks: deque[ExplainedTick] = deque()
        self._early: SwarmImu | None = None

    def explain(self, tick: ExplainedTick) -> tuple[float, Array] | None:
        """Remember a tick; return time and y of a sample that has waited for it."""
        if self._ticks and tick.names != self._ticks[-1].names:
            self._ticks.clear()
        self._ticks.append(tick)
        while self._ticks[0].t < tick.t - OLDEST:
            self._ticks.popleft()
        return None if self._early is None else self.sense(self._early)

    def sense(self, imu: SwarmImu) -> tuple[float, Array] | None:
        """Return time and y [m/s^2], (n,), of a sample; None before its tick, or without one.

        y is NaN for a vehicle without accelerometer.
        """
        last = self._ticks[-1].t if self._ticks else -np.inf
        self._early = imu if imu.t > last + SAME_STAMP else None
        for tick in self._ticks:
            if abs(tick.t - imu.t) < SAME_STAMP:
                rows = index_of(tick.names, imu.names)
                force = np.concatenate([imu.specific_force_body, np.full((1, 3), np.nan)])[rows]
                return tick.t, rotate(tick.quat, force)[:, 2] - tick.acc
        return None
