"""Forecast of a tick: references, last solution and downwash along the horizon."""

from dataclasses import dataclass

import numpy as np

from q2q_control.inputs.alignment import ETA, POS, VEL, Aligned
from q2q_control.mpc.neighbours.constant_velocity import Neighbours
from q2q_control.mpc.prediction.downwash_horizon import (
    GradientRule,
    Others,
    no_downwash,
    predict_downwash,
)
from q2q_control.mpc.prediction.previous_solution import PredictedSolution, PreviousSolution
from q2q_control.mpc.prediction.vehicle_tracks import Future, VehicleTracks
from q2q_control.mpc.problem.horizon import DownwashHorizon
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.source_strength import source_terms
from q2q_model.signals.values import (
    Array,
    Interference,
    InterferenceStatus,
    Names,
    SwarmSetpoint,
    rows_by_name,
)


@dataclass(frozen=True, slots=True)
class Forecast:
    """Predictions for the n vehicles of one tick."""

    reference: Array
    """Position [m], velocity [m/s], acceleration [m/s^2], world, (n, N + 1, 9)."""
    previous: PredictedSolution
    """The last tick's, shifted to now."""
    downwash: DownwashHorizon
    path: Array
    """Predicted positions [m], world, of the n vehicles and of others, (n or more, N + 1, 3)."""


class Forecaster:
    """Memory of solutions and of past positions, from which forecasts are made."""

    def __init__(self, params: MpcParams, model: InteractionModel, gradients: GradientRule) -> None:
        """Predict downwash by `model`."""
        self._params, self._model, self._gradients = params, model, gradients
        self._previous = PreviousSolution(params.steps, params.step)
        self._tracks = VehicleTracks(model.max_delay, source_terms(model).loading or params.loading)
        self._ahead = params.step * np.arange(params.steps + 1)

    def stages(self, t: float) -> Array:
        """Return the times of the stages of a tick at t, (N + 1,) [s]."""
        return np.asarray(t + self._params.latency + self._ahead, dtype=np.float64)

    def forecast(
        self, tick: Aligned, reference: Array, times: Array, neighbours: Neighbours, *, aware: bool
    ) -> Forecast:
        """Return the forecast of the tick's vehicles, without downwash unless `aware`.

        Args:
            tick: the controlled vehicles.
            reference: theirs at `times`, (n, N + 1, 9).
            times: of the stages, (N + 1,) [s].
            neighbours: the vehicles of other controllers.
            aware: whether the downwash is predicted.
        """
        previous = self._previous.shifted(tick.names, float(times[0]))
        path = reference[..., :3] + previous.offset
        if not tick.all_usable:
            path[tick.stray] = reference[tick.stray, :, :3]
        future = Future(times, path, previous.inputs)
        tracks = self._tracks.tracks(tick, future, neighbours)
        others = None
        if neighbours.names:
            certain = np.zeros(len(tick.names))
            others = Others(len(tick.names), np.concatenate((certain, neighbours.spread)))
            path = np.concatenate((path, neighbours.path))
        downwash = (
            predict_downwash(self._model, tracks, self._gradients, others) if aware else no_downwash(tracks)
        )
        return Forecast(reference, previous, downwash, path)

    def keep(self, names: Names, solution: PredictedSolution) -> None:
        """Remember the solutions of a tick."""
        self._previous.keep(names, solution)


def correct_downwash(
    tick: Aligned, interference: Interference, downwash: DownwashHorizon, params: MpcParams
) -> None:
    """Replace the predictor's present downwash where it is invalid or neglects the sources' thrust.

    The predictor does not know where unseen vehicles were going, nor how hard any vehicle pushes.
    """
    no_model = InterferenceStatus.NO_MODEL
    status = rows_by_name(interference.status, interference.names, tick.names, no_model)
    uncertain = status != InterferenceStatus.VALID
    uncertain |= params.loading > 0.0
    eta = downwash.eta[: len(tick.names)]
    early = 0.5 + params.latency / params.step  # stages from now to the first one's middle
    now = eta[:, 0] - early * (eta[:, 1] - eta[:, 0])
    tick.table[:, ETA] = np.where(uncertain[:, None], now, tick.table[:, ETA])


def future_reference(tick: Aligned, setpoint: SwarmSetpoint, references: Array, times: Array) -> Array:
    """Return the references of the tick's vehicles at `times` (N + 1,) [s], (n, N + 1, 9).

    A vehicle that is seen but has no usable attitude or setpoint flies on at its velocity; what is not finite
    is 0.
    `references` are those of the vehicles of `setpoint`, (m, N + 1, 9).
    """
    if setpoint.names == tick.names and tick.all_usable:
        return np.ascontiguousarray(references)
    found = rows_by_name(references, setpoint.names, tick.names)
    found = np.where(np.isfinite(found), found, 0.0)
    stray = tick.stray
    pos, vel = tick.table[stray, None, POS], tick.table[stray, None, VEL]
    found[stray, :, :3] = pos + vel * (times - tick.t)[:, None]
    found[stray, :, 3:6], found[stray, :, 6:] = vel, 0.0
    return found
