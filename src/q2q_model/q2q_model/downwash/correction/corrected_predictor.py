"""Predicted downwash, corrected by the residual measured a little earlier.

    eta^(t) = eta(t) + exp(-h / T) r^(t - h)

r^ is the Kalman estimate of the residual process (q2q_model.downwash.correction.residual_process) from
measured pushes y = eta + b + r + noise at t - h; h is the age of the last one. Between measurements,

    r^ <- a r^,   P <- a^2 P + (1 - a^2) sigma^2,   a = exp(-dt / T)

and the standard deviation of eta^ is the square root of P, propagated over h. The constant b of each vehicle
(battery, mass, sensor) is its mean of y where |eta| is below `CLEAR`.

| input | output |
|---|---|
| a repeated stamp | the previous output, also if its tick was measured, or a late one predicted, since |
| no measurement yet, one of another vehicle, NaN | the prediction unchanged |
| a measurement older than `OLDEST` | the prediction unchanged: nothing of the residual is left |
| a measurement not later than the last, or of a time without prediction | ignored |
| a prediction under a wrong stamp (q2q_model.signals.repeated_stamp) | unchanged, not remembered |
| one of a clock that was set back | all is forgotten |
| measurements of other vehicles than the last time | what is known of each follows its name |
| a vehicle without prediction (NO_MODEL) | the prediction unchanged |
| a vehicle that its rotors do not carry (carried_by_rotors) | as without a measurement of it |
"""

from dataclasses import replace

import numpy as np

from q2q_model.downwash.correction.measured_push import MeasuredPush
from q2q_model.downwash.correction.residual_process import OLDEST, ResidualProcess
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.signals.recent_ticks import RecentTicks
from q2q_model.signals.repeated_stamp import StampOrder, is_repeated
from q2q_model.signals.values import (
    Array,
    Interference,
    InterferenceStatus,
    Mask,
    Names,
    SwarmCommand,
    SwarmImu,
    SwarmState,
    index_of,
    rows_by_name,
)
from q2q_model.vehicle.constants import Vehicle

CLEAR = 0.05
"""Downwash that a vehicle in clear air may feel at most [m/s^2]: a tenth of the residual's size."""
OFFSET_S = 5.0
"""Time constant of b [s]: shorter than a battery's discharge, longer than a passage."""


class ResidualCorrector:
    """Corrector of predictions by measured pushes."""

    def __init__(self, process: ResidualProcess) -> None:
        self._process = process
        self.reset()

    def reset(self) -> None:
        """Forget predictions and measurements."""
        self._order = StampOrder()
        self._forget()

    def _forget(self) -> None:
        self._predicted: RecentTicks[Interference] = RecentTicks(OLDEST)
        self._corrected: Interference | None = None
        self._t = -np.inf
        self._names: Names = ()
        self._residual: Array = np.zeros(0)
        self._variance: Array = np.zeros(0)
        self._offset: Array = np.zeros(0)
        self._clear_s: Array = np.zeros(0)
        self._seen: Mask = np.zeros(0, dtype=np.bool_)

    def update(self, prediction: Interference) -> Interference:
        """Return a prediction corrected by what has been measured."""
        if self._order.reject_stamp(prediction.t):
            return prediction
        if is_repeated(self._corrected, prediction.t, prediction.names):
            return self._corrected
        last = self._predicted.last
        if last is not None and prediction.t < last.t:
            self._forget()
        self._predicted.remember(prediction)
        self._corrected = self._correct(prediction)
        return self._corrected

    def _correct(self, prediction: Interference) -> Interference:
        age = prediction.t - self._t
        rows = index_of(prediction.names, self._names)
        known = (rows >= 0) & (prediction.status != InterferenceStatus.NO_MODEL)
        if age > OLDEST or not known.any():
            return prediction
        known[known] &= self._seen[rows[known]]
        acc, std, own = prediction.acc.copy(), prediction.std.copy(), rows[known]
        share = self._process.correlation(age)
        size = self._process.std(acc[known, 2])
        acc[known, 2] += share * self._residual[own]
        std[known, 2] = np.sqrt(share**2 * self._variance[own] + (1.0 - share**2) * size**2)
        return replace(prediction, acc=acc, std=std)

    def measure(self, t: float, names: Names, push: Array) -> None:
        """Take measured pushes y [m/s^2], (n,), of time t [s]; NaN where unknown."""
        then = self._predicted.at(t)
        if then is None or t <= self._t:
            return
        if names != self._names:
            self._follow(names)
        rows = index_of(names, then.names)
        eta = np.where(rows >= 0, then.acc[rows, 2], np.nan)
        dt, self._t = min(t - self._t, OLDEST), t
        missed = push - eta
        good = np.isfinite(missed)
        self._learn_offset(missed, eta, good, dt)
        self._propagate(eta, good, dt)
        innovation = missed - self._offset - self._residual
        gain = self._variance / (self._variance + self._process.noise**2)
        self._residual[good] += (gain * innovation)[good]
        self._variance[good] *= (1.0 - gain)[good]
        self._seen |= good

    def _propagate(self, eta: Array, good: Mask, dt: float) -> None:
        share, size = self._process.correlation(dt), self._process.std(np.where(good, eta, 0.0))
        self._residual *= share
        self._variance = share**2 * self._variance + (1.0 - share**2) * size**2

    def _learn_offset(self, missed: Array, eta: Array, good: Mask, dt: float) -> None:
        clear = good & (np.abs(eta) < CLEAR)
        self._clear_s[clear] += dt
        rate = dt / np.minimum(np.maximum(self._clear_s, dt), OFFSET_S)
        self._offset[clear] += (rate * (missed - self._offset))[clear]

    def _follow(self, names: Names) -> None:
        """Reorder what is known by name; nothing is known of new vehicles."""
        have = self._names
        self._residual = rows_by_name(self._residual, have, names)
        self._variance = rows_by_name(self._variance, have, names, self._process.floor**2)
        self._offset = rows_by_name(self._offset, have, names)
        self._clear_s = rows_by_name(self._clear_s, have, names)
        self._seen = rows_by_name(self._seen, have, names)
        self._names = names


class CorrectedPredictor:
    """Predictor whose outputs are corrected by accelerometers and commands."""

    def __init__(self, predictor: InteractionPredictor, process: ResidualProcess, vehicle: Vehicle) -> None:
        self._predictor, self._push = predictor, MeasuredPush(vehicle)
        self._corrector = ResidualCorrector(process)

    def reset(self) -> None:
        """Forget the past."""
        self._predictor.reset()
        self._push.reset()
        self._corrector.reset()

    def update(self, state: SwarmState) -> Interference:
        """Return the corrected downwash on every vehicle of `state`, in its order."""
        return self._corrector.update(self._predictor.update(state))

    def sense(self, state: SwarmState, command: SwarmCommand, imu: SwarmImu) -> None:
        """Take the measurements of a tick, after the prediction of that tick."""
        self._corrector.measure(state.t, state.names, self._push.update(state, command, imu))
