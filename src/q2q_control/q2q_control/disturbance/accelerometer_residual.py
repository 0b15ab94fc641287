"""Push that an accelerometer feels beyond thrust and predicted downwash.

    y = (R f_body)_z - (T b)_z / m - eta

at the sample's own time: attitude R, thrust T by then (with delay and lag of the command path) and eta are
those of the tick with its stamp. A sample may arrive before its tick or up to OLDEST after it.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.downwash.correction.residual_process import OLDEST
from q2q_model.geometry.rotations import rotate
from q2q_model.signals.recent_ticks import RecentTicks
from q2q_model.signals.values import Array, Names, SwarmImu, rows_by_name


class ExplainedTick(NamedTuple):
    """What thrust and prediction explain at a tick."""

    t: float
    """[s]"""
    names: Names
    quat: Array
    """(n, 4)"""
    acc: Array
    """Vertical specific force by thrust and predicted downwash [m/s^2], (n,); NaN: not to be measured."""


class AccelerometerResidual:
    """Memory of ticks and of the sample whose tick has not come yet."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._ticks: RecentTicks[ExplainedTick] = RecentTicks(OLDEST)
        self._early: SwarmImu | None = None

    def explain(self, tick: ExplainedTick) -> tuple[float, Array] | None:
        """Remember a tick; return time [s] and y [m/s^2], (n,), of a sample that has waited for it."""
        if self._ticks.last is not None and tick.names != self._ticks.last.names:
            self._ticks.reset()
        self._ticks.remember(tick)
        return None if self._early is None else self.sense(self._early)

    def sense(self, imu: SwarmImu) -> tuple[float, Array] | None:
        """Return time and y [m/s^2], (n,), of a sample; None before its tick, or without one.

        y is NaN for a vehicle without accelerometer, or not to be measured.
        """
        self._early = None if self._ticks.is_over(imu.t) else imu
        tick = self._ticks.at(imu.t)
        if tick is None:
            return None
        force = rows_by_name(imu.specific_force_body, imu.names, tick.names, np.nan)
        return tick.t, rotate(tick.quat, force)[:, 2] - tick.acc
