"""Chain model of one axis: position, velocity, and acceleration that lags behind its command.

    p' = v,   v' = a + w,   a' = (u - a) / T                 exact for u and w constant over a step h:

    p+ = p + h v + (T h - T^2 (1 - e)) a + (h^2/2 - T h + T^2 (1 - e)) u + h^2/2 w
    v+ = v + T (1 - e) a + (h - T (1 - e)) u + h w            with e = exp(-h / T), e = 0 for T = 0
    a+ = e a + (1 - e) u

The weights place the closed loop: for T = 0 and J = sum (p - p*)^2 + (u - u*)^2 / w^4 its poles are those
of s^2 + sqrt 2 w s + w^2. The terminal weight P is that of the infinite horizon (the discrete Riccati
equation), so that the length of the horizon does not matter to an unbounded chain: it is the linear-quadratic
regulator, whose cost to go falls by the stage cost. Vehicles that are solved together, and chains that meet a
bound, are given a share of P (MpcParams.terminal), for which that is not so. Only inputs are bounded, so
every problem is feasible. There is no proof of stability for them, nor under a wake, whose slopes change from
tick to tick; with all of P the cost to go is exact where the last predicted inputs are within their bounds
(Chmielewski, Manousiouthakis, Syst. Control Lett. 29, 1996; Scokaert, Rawlings, IEEE Trans. Automat. Contr.
43, 1998).

| symbol | name | meaning [unit] |
|---|---|---|
| p v a | | position [m], velocity [m/s], acceleration by thrust [m/s^2] |
| u | | commanded acceleration [m/s^2] |
| w | | downwash and disturbance [m/s^2]; in the weights: bandwidth [rad/s] |
| T | lag | [s] |
| h | step | [s] |
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_are

from q2q_control.mpc.mpc_params import MpcParams
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle

Chains = tuple["Chain", "Chain", "Chain"]
"""Of x, y, z."""


@dataclass(frozen=True, slots=True)
class Chain:
    """Discrete model and weights of one axis."""

    transition: Array
    """A, (3, 3)."""
    input_gain: Array
    """B, (3,)."""
    push_gain: Array
    """Effect on the state of an acceleration w that is constant over the step, (3,)."""
    state_weight: Array
    """Q, (3,)."""
    input_weight: Array
    """R of u - u*, S of u - a, (2,)."""
    terminal: Array
    """P, (3, 3)."""


@dataclass(frozen=True, slots=True)
class ChainWeights:
    """Weights of error and effort of one axis."""

    bandwidth: float
    """[rad/s]"""
    jerk: float
    """Weight of u - a over that of u - u* [-]."""


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


def chain(lag: float, step: float, weights: ChainWeights) -> Chain:
    """Return the chain of an axis with a lag [s], for steps [s]."""
    matrix, gain = transition(lag, step)
    effort = weights.bandwidth**-4
    jerk = weights.jerk * effort
    state_weight = np.array([1.0, 0.0, 0.0])
    cost = np.diag([*state_weight[:2], state_weight[2] + jerk])
    cross = np.array([[0.0], [0.0], [-jerk]])
    terminal = solve_discrete_are(matrix, gain[:, None], cost, np.array([[effort + jerk]]), s=cross)
    return Chain(
        transition=matrix,
        input_gain=gain,
        push_gain=np.array([0.5 * step * step, step, 0.0]),
        state_weight=state_weight,
        input_weight=np.array([effort, jerk]),
        terminal=np.asarray(terminal),
    )


def axis_lags(params: MpcParams, vehicle: Vehicle) -> tuple[float, float, float]:
    """Return the lags of the accelerations along x, y, z behind their commands [s]."""
    side = params.attitude_lag + vehicle.thrust_lag
    return side, side, vehicle.thrust_lag


def axis_chains(params: MpcParams, vehicle: Vehicle) -> Chains:
    """Return the chains of a vehicle; those of x and y are the same."""
    lag_xy, _, lag_z = axis_lags(params, vehicle)
    side = chain(lag_xy, params.step, ChainWeights(params.bandwidth_xy, params.jerk))
    return side, side, chain(lag_z, params.step, ChainWeights(params.bandwidth_z, params.jerk))
