"""Past positions of the vehicles around a controller."""

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_control.inputs.alignment import align
from q2q_control.mpc.neighbours.constant_velocity import at_constant_velocity
from q2q_control.mpc.prediction.vehicle_tracks import Future, VehicleTracks, thrust_axes
from q2q_model.signals.values import Array, Names
from q2q_model.vehicle.constants import GRAVITY

TIMES = 0.05 * np.arange(4)


def add_tick(around: VehicleTracks, t: float, names: Names, pos: Array) -> Array:
    """Return the positions along the tracks of a tick, (K, n, 3), of vehicles at rest at pos [m], (n, 3)."""
    n = len(names)
    state = resting_state(t, names, pos)
    setpoint = resting_setpoint(t, names, pos)
    future = Future(t + TIMES, np.repeat(pos[:, None], TIMES.size, axis=1), np.zeros((n, TIMES.size - 1, 3)))
    others = at_constant_velocity(state, names, future.times)
    return around.tracks(align(state, setpoint, None), future, others).pos


def test_a_vehicle_that_appears_or_leaves_lets_the_others_keep_their_pasts() -> None:
    around, way = VehicleTracks(span=0.5, loading=0.0), np.array([0.1, 0.0, 0.0])
    first, second, third = np.array([0.0, 0.0, 1.0]), np.array([0.0, 3.0, 1.0]), np.array([5.0, 0.0, 2.0])
    for k in range(3):
        add_tick(around, 0.1 * k, ("cf1", "cf2"), np.array([first + k * way, second - k * way]))
    seen = add_tick(around, 0.3, ("cf3", "cf2", "cf1"), np.array([third, second - 3 * way, first + 3 * way]))
    for k in range(4):
        np.testing.assert_allclose(seen[k], [third, second - k * way, first + k * way], atol=1e-12)
    left = add_tick(around, 0.4, ("cf1",), np.array([first + 4 * way]))
    np.testing.assert_allclose(left[:5, 0], [first + k * way for k in range(5)], atol=1e-12)


@pytest.mark.parametrize(("loading", "weight"), [(0.0, 0.5), (0.4, 0.3)])
def test_a_neighbour_whose_plan_falls_freely_is_level(loading: float, weight: float) -> None:
    """It ended in a ZeroDivisionError: a thrust of zero has no direction."""
    axis, weights = thrust_axes(np.array([[[0.0, 0.0, -GRAVITY]]]), np.array([0.5]), loading)
    assert axis.tolist() == [[[0.0, 0.0, 1.0]]]
    assert weights[0, 0] == pytest.approx(weight)  # 0.5 (1 - loading)
