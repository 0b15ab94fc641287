"""Model of one axis: position, velocity, and acceleration that lags behind its command.

    p' = v,   v' = a + w,   a' = (u - a) / T                 exact for u and w constant over a step h:

    p+ = p + h v + (T h - T^2 (1 - e)) a + (h^2/2 - T h + T^2 (1 - e)) u + h^2/2 w
    v+ = v + T (1 - e) a + (h - T (1 - e)) u + h w            with e = exp(-h / T), e = 0 for T = 0
    a+ = e a + (1 - e) u

| symbol | name | meaning [unit] |
|---|---|---|
| p v a | | position [m], velocity [m/s], acceleration by thrust [m/s^2] |
| u | | commanded acceleration [m/s^2] |
| w | | downwash and disturbance [m/s^2] |
| T | lag | [s] |
| h | step | [s] |
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_control.mpc.problem.axis_cost import AxisCost, AxisWeights, axis_cost
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle

AxisModels = tuple["AxisModel", "AxisModel", "AxisModel"]
"""Of x, y, z."""


@dataclass(frozen=True, slots=True)
class AxisModel:
    """Discrete model and cost of one axis."""

    transition: Array
    """A, (3, 3)."""
    input_gain: Array
    """B, (3,)."""
    push_gain: Array
    """Effect on the state of an acceleration w that is constant over the step, (3,)."""
    cost: AxisCost


class LaggedStep(NamedTuple):
    """Coefficients of one step."""

    keep: float
    """e [-]."""
    slow: float
    """Velocity that the old acceleration still adds, over that acceleration [s]."""
    late: float
    """Position likewise [s^2]."""


@compiled
def lagged_step(lag: float, step: float) -> LaggedStep:
    """Return the coefficients of a step [s] with a lag [s]."""
    keep = math.exp(-step / lag) if lag > 0.0 else 0.0
    slow = lag * (1.0 - keep)
    return LaggedStep(keep, slow, lag * step - lag * slow)


def transition(lag: float, step: float) -> tuple[Array, Array]:
    """Return A (3, 3) and B (3,) of one step."""
    e, slow, late = lagged_step(lag, step)
    matrix = np.array([[1.0, step, late], [0.0, 1.0, slow], [0.0, 0.0, e]])
    return matrix, np.array([0.5 * step * step - late, step - slow, 1.0 - e])


def axis_model(lag: float, step: float, weights: AxisWeights) -> AxisModel:
    """Return the model of an axis with a lag [s], for steps [s]."""
    matrix, gain = transition(lag, step)
    return AxisModel(
        transition=matrix,
        input_gain=gain,
        push_gain=np.array([0.5 * step * step, step, 0.0]),
        cost=axis_cost(matrix, gain, weights),
    )


def axis_lags(params: MpcParams, vehicle: Vehicle) -> tuple[float, float, float]:
    """Return the lags of the accelerations along x, y, z behind their commands [s]."""
    side = params.attitude_lag + vehicle.thrust_lag
    return side, side, vehicle.thrust_lag


def axis_models(params: MpcParams, vehicle: Vehicle) -> AxisModels:
    """Return the axis models of a vehicle; those of x and y are the same."""
    lag_xy, _, lag_z = axis_lags(params, vehicle)
    side = axis_model(lag_xy, params.step, AxisWeights(params.bandwidth_xy, params.jerk_weight))
    return side, side, axis_model(lag_z, params.step, AxisWeights(params.bandwidth_z, params.jerk_weight))
