"""Online refinement of the downwash model's gain and the vehicles' offsets.

    y_i = (R f_body)_z - lagged(U1) b_z / m = g eta_i + b_i + noise

eta is the prediction of the model to be refined, g its common scale, b_i a constant of each vehicle.
Recursive least squares with exponential forgetting (time constant `memory`) is solved exactly from sums:

    g = (P + sum_i C_i[eta, y]) / (P + sum_i C_i[eta, eta]),   b_i = mean(y_i) - g mean(eta_i)

C_i are centred sums of vehicle i; P is a prior for g = 1. g and b_i are bounded, so a failing sensor cannot
invert the model. Where nothing is measured, as on the ground, nothing is forgotten.

| symbol | name | meaning [unit] |
|---|---|---|
| y | push | vertical acceleration not due to thrust [m/s^2] |
| g | gain | true over predicted downwash [-] |
| b | offset | constant acceleration of a vehicle [m/s^2], (n,) |
| P | prior | weight of g = 1, as a sum of eta^2 [m^2/s^4] |
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.downwash.correction.measured_push import LONGEST_STEP, MeasuredPush
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.identification.refined_model import largest_gain, scale_downwash
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.signals.values import Array, Names, SwarmCommand, SwarmImu, SwarmState, rows_by_name
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import Vehicle

WEIGHT, ETA, PUSH, ETA_ETA, ETA_PUSH = range(5)
"""Columns of the sums of each vehicle."""
ROUNDING = 1e-9
"""Centred sum of eta^2 over the sum itself below which eta was constant but for rounding [-]."""


@dataclass(frozen=True, slots=True)
class OnlineRefinementParams:
    """Rates and bounds of the online refinement."""

    memory: float = tunable(60.0, "time constant of forgetting", unit="s", low=1.0, high=3600.0)
    prior: float = tunable(10.0, "weight of a gain of 1, as a sum of eta^2", unit="m^2/s^4", low=0.0)
    gain_min: float = tunable(0.5, "smallest gain", low=0.0, high=1.0)
    gain_max: float = tunable(2.0, "largest gain", low=1.0, high=10.0)
    offset_max: float = tunable(1.0, "largest magnitude of an offset", unit="m/s^2", low=0.0, high=5.0)
    publish_every: float = tunable(1.0, "minimum time between published models", unit="s", low=0.1, high=60.0)
    change_min: float = tunable(0.01, "minimum change of the gain for a new model", low=0.0, high=1.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class OnlineEstimate:
    """Current estimate."""

    t: float
    gain: float
    names: Names
    offset: Array
    information: float
    """Centred sum of eta^2 behind the gain [m^2/s^4], to compare with the prior."""
    unbounded_gain: float
    """Gain before it is bounded [-]."""


class OnlineRefinement:
    """Estimator of the gain of a model, which itself is unchanged."""

    def __init__(
        self, model: InteractionModel, vehicle: Vehicle, params: OnlineRefinementParams | None = None
    ) -> None:
        """Refine a model that is flown with `vehicle`.

        Raises:
            UnscalableModelError: a model of a class that has no gain.
        """
        given = params or OnlineRefinementParams()
        self.params = replace(given, gain_max=largest_gain(model, given.gain_max))
        self._push = MeasuredPush(vehicle)
        self._predictor = InteractionPredictor(model)
        self.reset()

    def reset(self) -> None:
        """Clear the sums."""
        self._names: Names = ()
        self._sums = np.zeros((0, 5))
        self._forget_motion()

    def _forget_motion(self) -> None:
        """Begin again with prediction and push, as with the first tick; the sums stay."""
        self._predictor.reset()
        self._push.reset()
        self._t = -np.inf

    def update(self, state: SwarmState, command: SwarmCommand, imu: SwarmImu) -> OnlineEstimate:
        """Return the estimate after one tick; a stamp not later than the last is ignored.

        One that is more than SET_BACK_S earlier is of a clock that was set back, as by another flight: what
        was learned stays, and the tick is the first.
        """
        if state.t < self._t - SET_BACK_S:
            self._forget_motion()
        if state.t <= self._t:
            return self._estimate()
        self._follow(state.names)
        dt = min(state.t - self._t, LONGEST_STEP)
        push = self._push.update(state, command, imu)
        eta = self._predictor.update(state).acc[:, 2]
        self._t = state.t
        good = np.isfinite(push)
        self._sums[good] *= np.exp(-dt / self.params.memory)
        y, e = push[good], eta[good]
        self._sums[good] += np.stack([np.ones_like(y), e, y, e * e, e * y], axis=1)
        return self._estimate()

    def refined(self) -> InteractionModel:
        """Return the model with its gain applied."""
        return scale_downwash(self._predictor.model, self._estimate().gain)

    def _follow(self, names: Names) -> None:
        """Reorder the sums by name; those of new vehicles are zero."""
        if names == self._names:
            return
        self._names, self._sums = names, rows_by_name(self._sums, self._names, names)

    def _estimate(self) -> OnlineEstimate:
        weight = np.maximum(self._sums[:, WEIGHT], 1e-12)
        e, y = self._sums[:, ETA] / weight, self._sums[:, PUSH] / weight
        cross = float((self._sums[:, ETA_PUSH] - weight * e * y).sum())
        square = float((self._sums[:, ETA_ETA] - weight * e * e).sum())
        p = self.params
        known = p.prior + square > ROUNDING * float(self._sums[:, ETA_ETA].sum())
        unbounded = (p.prior + cross) / (p.prior + square) if known else 1.0
        gain = float(np.clip(unbounded, p.gain_min, p.gain_max))
        offset = np.clip(y - gain * e, -p.offset_max, p.offset_max)
        return OnlineEstimate(self._t, gain, self._names, offset, square, unbounded)


class PublishedGain:
    """Gain of the model that was published last."""

    def __init__(self, params: OnlineRefinementParams) -> None:
        self._params = params
        self.reset()

    def reset(self) -> None:
        """Begin without a published model, whose gain is 1."""
        self._t, self._gain = -np.inf, 1.0

    def update(self, estimate: OnlineEstimate) -> bool:
        """Return whether the model is published: changed, and not within `publish_every` of the last one.

        If the clock was set back, the last one is of another time and does not count.
        """
        too_soon = 0.0 <= estimate.t - self._t < self._params.publish_every
        if too_soon or abs(estimate.gain - self._gain) < self._params.change_min:
            return False
        self._t, self._gain = estimate.t, estimate.gain
        return True


def limit_reached(estimate: OnlineEstimate, params: OnlineRefinementParams) -> str:
    """Return name and value of the limit that bounds a gain; empty if none does."""
    if estimate.unbounded_gain > params.gain_max:
        return f"gain_max = {params.gain_max:g}"
    return f"gain_min = {params.gain_min:g}" if estimate.unbounded_gain < params.gain_min else ""
