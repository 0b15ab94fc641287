"""On the ground nothing is a push: neither before a take-off, nor after a landing."""

import numpy as np
import pytest
from resting_signals import level_command, resting_state

from q2q_model.downwash.correction.corrected_predictor import CorrectedPredictor
from q2q_model.downwash.correction.in_flight import LANDED_SHARE, LIFTED_SHARE, InFlight
from q2q_model.downwash.correction.measured_push import MeasuredPush
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.signals.values import Array, SwarmCommand, SwarmImu, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_1, GRAVITY

VEHICLE, NAME, STEP = CRAZYFLIE_2_1, ("cf1",), 0.01
WEIGHT = VEHICLE.hover_thrust
OFFSET = 0.3
"""Push on the vehicle in the air [m/s^2]."""


def tick(t: float, share: float, felt: float) -> tuple[SwarmState, SwarmCommand, SwarmImu]:
    """Return the signals of a level vehicle whose thrust is a share of its weight [-], felt [m/s^2]."""
    force, zero = np.array([[0.0, 0.0, felt]]), np.zeros((1, 3))
    command = level_command(t, NAME, np.array([share * WEIGHT]))
    return resting_state(t, NAME, zero), command, SwarmImu(t, NAME, force, zero)


@pytest.mark.parametrize(
    ("shares", "flown"),
    [
        ((0.0, 0.89, 0.91, 0.51, 0.91), (False, False, True, True, True)),
        ((1.0, 0.49, 0.89, 0.91), (True, False, False, True)),
        ((1.0, np.nan, 0.89), (True, False, False)),
    ],
)
def test_a_vehicle_flies_from_its_lift_to_its_landing(
    shares: tuple[float, ...], flown: tuple[bool, ...]
) -> None:
    assert (LANDED_SHARE, LIFTED_SHARE) == (0.5, 0.9)
    block = InFlight(VEHICLE)
    found = [block.update(NAME, np.array([share * WEIGHT]))[0] for share in shares]
    assert tuple(bool(one) for one in found) == flown


def test_who_flies_follows_its_name_and_a_new_vehicle_stands() -> None:
    block = InFlight(VEHICLE)
    block.update(("a", "b"), np.array([1.0, 0.0]) * WEIGHT)
    found = block.update(("c", "b", "a"), np.full(3, 0.7) * WEIGHT)
    np.testing.assert_array_equal(found, [False, False, True])


def test_no_push_is_measured_until_the_lagging_thrust_lifts() -> None:
    """Thrust reaches 0.9 of the weight after lag times ln 10."""
    block, begins = MeasuredPush(VEHICLE), VEHICLE.thrust_lag * np.log(10.0)
    for t in np.arange(-100, 100) * STEP:
        push = block.update(*tick(t, 0.0 if t < 0.0 else 1.0, GRAVITY))
        assert np.isfinite(push[0]) == (t + STEP > begins), t


def corrections(phases: tuple[tuple[float, float, float], ...]) -> tuple[Array, Array]:
    """Return stamps and corrected pushes of phases of (seconds, thrust over weight, felt [m/s^2])."""
    block, t, found = CorrectedPredictor(InteractionPredictor(MEASURED_LAW), REAL_FLIGHTS, VEHICLE), 0.0, []
    for seconds, share, felt in phases:
        for _ in range(round(seconds / STEP)):
            one = tick(t, share, felt)
            found.append((t, block.update(one[0]).acc[0, 2]))
            block.sense(*one)
            t += STEP
    times, acc = np.array(found).T
    return times, acc


@pytest.mark.parametrize("ground", [0.0, 2.0])
def test_ground_before_a_take_off_is_no_downwash_after_it(ground: float) -> None:
    """The push that is left of 1 m/s^2 while a rotor lags fades within the residual's 0.08 s."""
    times, acc = corrections(((ground, 0.0, GRAVITY), (1.5, 1.0, GRAVITY)))
    np.testing.assert_array_equal(acc[times < ground], 0.0)
    assert np.abs(acc[times > ground + 0.5]).max(initial=0.0) < 0.2


def test_what_was_learned_in_flight_is_forgotten_with_the_landing() -> None:
    phases = ((3.0, 1.0, GRAVITY + OFFSET), (1.0, 0.0, GRAVITY), (1.0, 1.0, GRAVITY))
    times, acc = corrections(phases)
    landed = (times > 3.0 + 2.0 * VEHICLE.thrust_lag) & (times < 4.0)
    np.testing.assert_array_equal(acc[landed], 0.0)
    assert np.abs(acc[times > 4.5]).max() < 0.2
