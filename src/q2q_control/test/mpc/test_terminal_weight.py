"""How much the terminal weight of a group changes the first input away from wakes and bounds."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_control.mpc.problem.axis_model import AxisModel, axis_models
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0


def first_gain(model: AxisModel, share: float, steps: int) -> Array:
    """Return the gain of the first input, (1, 3), by the Riccati recursion from a share of the weight."""
    a, b = model.transition, model.input_gain[:, None]
    tracking, effort = model.cost.input_weight
    cost, cross = share * model.cost.terminal, effort * np.array([[0.0, 0.0, 1.0]])
    stage = np.diag(model.cost.state_weight) + np.diag([0.0, 0.0, effort])
    gain = np.zeros((1, 3))
    for _ in range(steps):
        mixed = b.T @ cost @ a - cross
        gain = np.linalg.solve(tracking + effort + b.T @ cost @ b, mixed)
        cost = stage + a.T @ cost @ a - mixed.T @ gain
    return np.asarray(gain)


@pytest.mark.parametrize(
    ("axis", "bandwidth", "low", "high"),
    [(0, 5.0, 3e-3, 6e-3), (1, 5.0, 3e-3, 6e-3), (2, 5.0, 1e-6, 3e-6), (2, 12.3, 0.0, 1e-11)],
)
def test_the_weight_of_a_group_changes_the_first_input_as_documented(
    axis: int, bandwidth: float, low: float, high: float
) -> None:
    params = replace(MpcParams(), bandwidth_z=bandwidth)
    model = axis_models(params, CRAZYFLIE_2_0)[axis]
    whole, group = (
        first_gain(model, 1.0, params.steps),
        first_gain(model, params.terminal_weight, params.steps),
    )
    change = 1.0 - group / whole
    assert change.min() >= low - 1e-13  # rounding of the recursion
    assert change.max() <= high
    np.testing.assert_allclose(whole, first_gain(model, 1.0, 2000), rtol=1e-12)  # of the infinite horizon
