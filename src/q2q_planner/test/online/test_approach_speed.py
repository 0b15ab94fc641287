"""A vehicle of bounded jerk returns as fast as it can stop; who is nearer to its reference yields more."""

import numpy as np
import pytest

from q2q_model.signals.values import Array, SwarmSetpoint
from q2q_planner.online.safe.choice.barrier import SHIFTED, BarrierLaw, BarrierStates, filter_accelerations
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_planner.online.safe.stopping.approach_speed import ApproachLaw, approach_speed
from q2q_planner.online.safe.stopping.broad_phase import Pairs

LAW = ApproachLaw(4.0, 1.5)
TICK = 0.01
PARAMS = SafeReplannerParams(acc_max=2.0, jerk_max=20.0, speed_max=2.5, approach=4.0)


def test_an_approach_at_its_speed_decelerates_by_the_brake_and_near_the_end_by_less() -> None:
    """The deceleration of s' = -w(s) is w' w: brake far away, pole^2 s near."""
    near = LAW.brake / LAW.pole**2
    for s in (1.01 * near, 0.5, 3.0):
        speed, slope = approach_speed(s, LAW)
        assert speed * slope == pytest.approx(LAW.brake, rel=1e-12)
    for s in (0.1 * near, 0.99 * near):
        speed, slope = approach_speed(s, LAW)
        assert (speed, slope) == (LAW.pole * s, LAW.pole)
        assert speed * slope < LAW.brake
    assert approach_speed(near * (1.0 + 1e-9), LAW)[0] == pytest.approx(LAW.pole * near, rel=1e-6)


def test_the_slope_is_the_derivative_of_the_speed() -> None:
    for s in (0.05, 0.2, 2.0):
        rise = approach_speed(s + 1e-6, LAW)[0] - approach_speed(s - 1e-6, LAW)[0]
        assert approach_speed(s, LAW)[1] == pytest.approx(rise / 2e-6, rel=1e-6)


def shifted_by(shift: Array) -> list[SwarmSetpoint]:
    """Return the setpoints of a vehicle whose reference jumps away and rests there."""
    replanner, still = SafeReplanner(PARAMS), np.zeros((1, 3))
    at = np.array([[0.0, 0.0, 1.0]])
    rest = np.zeros(1), np.zeros(1), np.zeros(1, np.uint8)
    return [
        replanner.update(
            SwarmSetpoint(k * TICK, ("cf1",), at + (shift if k else 0.0), still, still, *rest), None
        )
        for k in range(600)
    ]


@pytest.mark.parametrize("shift", [[1.2, 0.0, 0.0], [0.6, -0.8, 0.7]])
def test_a_return_over_1_m_takes_little_longer_than_the_fastest_and_does_not_overshoot(
    shift: list[float],
) -> None:
    """At 2 and -2 m/s^2 without limits of jerk: 2 sqrt(s / 2)."""
    distance = float(np.linalg.norm(shift))
    flown = np.array([one.pos[0] for one in shifted_by(np.array(shift))]) - [0.0, 0.0, 1.0]
    along = flown @ np.array(shift) / distance
    assert np.linalg.norm(flown - along[:, None] * shift / distance, axis=1).max() < 0.02
    assert along.max() < distance + 0.02
    arrived = float(np.argmax(along > distance - 0.05)) * TICK
    assert arrived < 1.45 * 2.0 * np.sqrt(distance / PARAMS.acc_max)
    np.testing.assert_allclose(flown[-1], shift, atol=1e-12)


def test_the_nearer_of_two_to_its_reference_takes_more_of_a_correction() -> None:
    """In the ratio of the shifts, each with SHIFTED; without the rule each takes half."""
    pos = np.array([[0.0, 0.0, 1.0], [0.5, 0.0, 1.0]])
    ref = pos + np.array([[0.0, 0.3, 0.0], [0.0, 0.0, 0.0]])
    states = BarrierStates(pos, np.array([[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]]), ref, np.full(2, -np.inf))
    pairs, wide = Pairs(np.array([0]), np.array([1])), np.zeros((1, 2))
    for shares, ratio in ((True, (0.3 + SHIFTED) / SHIFTED), (False, 1.0)):
        acc = np.zeros((2, 3))
        law = BarrierLaw(2, 0.2, 1.1, 8.0, 16.0, 0.0, 0.05, shares)
        assert filter_accelerations(acc, states, pairs, wide, law).all()
        assert acc[1, 0] > 0.0 > acc[0, 0]
        assert acc[1, 0] / -acc[0, 0] == pytest.approx(ratio, rel=1e-12)
