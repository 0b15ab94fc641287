"""Cost of one axis: weights of its state and input, and the terminal weight.

The weights place the closed loop: for T = 0 and J = sum (p - p*)^2 + (u - u*)^2 / w^4 its poles are those
of s^2 + sqrt 2 w s + w^2. The terminal weight P is that of the infinite horizon (the discrete Riccati
equation), so that the length of the horizon does not matter to an unbounded axis: it is the
linear-quadratic regulator, whose cost to go falls by the stage cost. Vehicles that are solved together, and
axes that meet a bound, are given a share of P (MpcParams.terminal_weight), for which that is not so. Only
inputs are bounded, so every problem is feasible. There is no proof of stability for them, nor under a wake,
whose gradients change from tick to tick; with all of P the cost to go is exact where the last predicted
inputs are within their bounds (Chmielewski, Manousiouthakis, Syst. Control Lett. 29, 1996; Scokaert,
Rawlings, IEEE Trans. Automat. Contr. 43, 1998).

| symbol | name | meaning [unit] |
|---|---|---|
| p u | | position [m], commanded acceleration [m/s^2] |
| w | bandwidth | [rad/s] |
| T | lag | of the axis (q2q_control.mpc.problem.axis_model) [s] |
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from q2q_model.signals.values import Array


@dataclass(frozen=True, slots=True)
class AxisWeights:
    """Weights of error and effort of one axis."""

    bandwidth: float
    """[rad/s]"""
    jerk: float
    """Weight of u - a over that of u - u* [-]."""


@dataclass(frozen=True, slots=True)
class AxisCost:
    """Cost of one axis."""

    state_weight: Array
    """Q, (3,)."""
    input_weight: Array
    """R of u - u*, S of u - a, (2,)."""
    terminal: Array
    """P, (3, 3)."""


def axis_cost(transition: Array, input_gain: Array, weights: AxisWeights) -> AxisCost:
    """Return the cost of an axis whose steps are A (3, 3) and B (3,)."""
    effort = weights.bandwidth**-4
    jerk = weights.jerk * effort
    state_weight = np.array([1.0, 0.0, 0.0])
    cost = np.diag([*state_weight[:2], state_weight[2] + jerk])
    cross = np.array([[0.0], [0.0], [-jerk]])
    terminal = solve_discrete_are(transition, input_gain[:, None], cost, np.array([[effort + jerk]]), s=cross)
    return AxisCost(state_weight, np.array([effort, jerk]), np.asarray(terminal))
