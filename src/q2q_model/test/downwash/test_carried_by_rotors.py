"""Pushes are measured while rotors carry a vehicle: not on the ground, motors off, and not in free fall."""

import numpy as np
import pytest
from resting_signals import level_command, resting_state

from q2q_model.downwash.correction.carried_by_rotors import CARRIED_SHARE, is_carried
from q2q_model.downwash.correction.corrected_predictor import CorrectedPredictor
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


def test_rotors_carry_from_three_tenths_of_the_weight_on() -> None:
    assert CARRIED_SHARE == 0.3
    thrust = np.array([0.0, 0.29, 0.31, 1.0, 0.31, 0.29, np.nan]) * WEIGHT
    expected = [False, False, True, True, True, False, False]
    np.testing.assert_array_equal(is_carried(thrust, VEHICLE), expected)


def test_no_push_is_measured_until_the_lagging_thrust_carries() -> None:
    """Thrust reaches 0.3 of the weight after lag times ln(1 / 0.7)."""
    block, begins = MeasuredPush(VEHICLE), VEHICLE.thrust_lag * np.log(1.0 / (1.0 - CARRIED_SHARE))
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


@pytest.mark.parametrize("ground", [0.0, 5.0])
def test_ground_before_a_take_off_is_no_downwash_on_it_and_little_after_it(ground: float) -> None:
    """What the ground carries while a rotor lags, from 0.7 g on, is a mean over the time since."""
    times, acc = corrections(((ground, 0.0, GRAVITY), (3.0, 1.0, GRAVITY)))
    np.testing.assert_array_equal(acc[times < ground], 0.0)
    flown = times > ground + 0.5
    carried = (1.0 - CARRIED_SHARE) * GRAVITY * VEHICLE.thrust_lag
    assert np.all(np.abs(acc[flown]) < carried / (times[flown] - ground))


def test_a_dip_of_the_thrust_in_flight_is_a_pause_and_nothing_is_forgotten() -> None:
    """A vehicle nearly in free fall feels its thrust and its offset."""
    block = CorrectedPredictor(InteractionPredictor(MEASURED_LAW), REAL_FLIGHTS, VEHICLE)
    thrust, keep = 1.0, np.exp(-STEP / VEHICLE.thrust_lag)
    for k in range(600):
        t, share = k * STEP, 0.1 if 300 <= k < 320 else 1.0
        thrust = share + keep * (thrust - share)
        one = tick(t, share, thrust * GRAVITY + OFFSET)
        corrected = block.update(one[0]).acc[0, 2]
        block.sense(*one)
        if k in (299, 315, 319, 330, 599):
            assert block._corrector._offset[0] == pytest.approx(OFFSET, abs=1e-9), k
            assert corrected == pytest.approx(0.0, abs=1e-3), k


def test_a_light_vehicle_is_measured_like_any_other() -> None:
    """It hovers at 0.6 of the nominal weight, so 0.4 of it is its offset, and nothing is downwash."""
    times, acc = corrections(((3.0, 0.6, GRAVITY),))
    assert np.abs(acc[times > 0.5]).max() < 1e-3
    block = MeasuredPush(VEHICLE)
    assert block.update(*tick(0.0, 0.6, GRAVITY))[0] == pytest.approx(0.4 * GRAVITY)


def test_what_was_learned_in_flight_is_kept_over_a_landing() -> None:
    phases = ((3.0, 1.0, GRAVITY + OFFSET), (1.0, 0.0, GRAVITY))
    block = CorrectedPredictor(InteractionPredictor(MEASURED_LAW), REAL_FLIGHTS, VEHICLE)
    kept, t = [], 0.0
    for seconds, share, felt in phases:
        for _ in range(round(seconds / STEP)):
            one = tick(t, share, felt)
            block.update(one[0])
            block.sense(*one)
            kept.append(block._corrector._offset[0])
            t += STEP
    stopped = int((3.0 + 1.3 * VEHICLE.thrust_lag) / STEP)
    assert len(set(kept[stopped + 1 :])) == 1
    assert kept[-1] == pytest.approx(OFFSET, abs=(1.0 - CARRIED_SHARE) * GRAVITY * VEHICLE.thrust_lag)
