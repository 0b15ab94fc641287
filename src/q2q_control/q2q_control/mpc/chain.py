"""Describe one axis of one vehicle as a chain: position, velocity, and acceleration behind its command.

    p' = v,   v' = a + w,   a' = (u - a) / T                 exact for u and w constant over a step h:

    p+ = p + h v + (T h - T^2 (1 - e)) a + (h^2/2 - T h + T^2 (1 - e)) u + h^2/2 w
    v+ = v + T (1 - e) a + (h - T (1 - e)) u + h w            with e = exp(-h / T), e = 0 for T = 0
    a+ = e a + (1 - e) u

The weights put the closed loop where it is wanted: for T = 0 and J = sum (p - p*)^2 + (u - u*)^2 / w^4 its
poles are those of s^2 + sqrt 2 w s + w^2. The weight beyond the horizon is the one that goes on for ever
(the discrete Riccati equation), so that the horizon's end does not matter to an unbounded loop.

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

import numpy as np
from scipy.linalg import solve_discrete_are

from q2q_model.signals.values import Array


@dataclass(frozen=True, slots=True)
class Chain:
    """Discrete model and weights of one axis."""

    transition: Array
    """A, (3, 3)."""
    input_gain: Array
    """B, (3,)."""
    push_gain: Array
    """What an acceleration w constant over the step does to the state, (3,)."""
    state_weight: Array
    """Q, (3,)."""
    input_weight: Array
    """R of u - u*, S of u - a, (2,)."""
    terminal: Array
    """P beyond the horizon, (3, 3)."""


@dataclass(frozen=True, slots=True)
class ChainWeights:
    """Weights of error and effort of one axis."""

    bandwidth: float
    """[rad/s]"""
    jerk: float
    """Weight of u - a over that of u - u* [-]."""


def transition(lag: float, step: float) -> tuple[Array, Array]:
    """Return A (3, 3) and B (3,) of one step."""
    e = math.exp(-step / lag) if lag > 0.0 else 0.0
    slow = lag * (1.0 - e)  # what an old acceleration still adds to the velocity [s]
    late = lag * step - lag * slow
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
