"""The compiled sums over jets are those of any model, whose pairs are evaluated apart."""

from dataclasses import replace

import numpy as np
import pytest
from any_model import AnyModel
from resting_signals import resting_state

from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW, Jet
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.signals.values import SwarmState, TrackStatus

NAMES = tuple(f"cf{k}" for k in range(6))
DT = 0.01
KNOWN_DEVIATION = replace(PAPER_LAW, relative_std=0.1, std_floor=0.2)


def flight() -> list[SwarmState]:
    """Return ticks of a loose stack that wanders and tilts, with gaps, guesses and vehicles not seen yet."""
    rng, ticks = np.random.default_rng(3), []
    pos = rng.normal(size=(6, 3)) * 0.05 + 0.3 * np.arange(6)[:, None] * [0.0, 0.0, 1.0]
    for k in range(80):
        vel = rng.normal(size=(6, 3)) * 0.5
        pos = pos + DT * vel
        quat = np.append(rng.normal(size=(6, 3)) * 0.1, np.ones((6, 1)), axis=1)
        state = resting_state(DT * k, NAMES, pos.copy(), vel=vel)
        state = replace(state, quat=quat / np.linalg.norm(quat, axis=1)[:, None])
        state.status[k % 6] = TrackStatus.COASTING
        state.age[5] = np.inf if k < 30 else 0.0
        if 20 <= k < 40:
            state.pos[2] = np.nan
        if 50 <= k < 55:
            state.quat[1] = np.nan
        ticks.append(state)
    return ticks


@pytest.mark.parametrize("law", [PAPER_LAW, KNOWN_DEVIATION, MEASURED_LAW, MOVING_LAW])
def test_the_sums_over_jets_are_those_of_any_model_bit_for_bit(law: Jet) -> None:
    jets, others = InteractionPredictor(law), InteractionPredictor(AnyModel(law))
    pushed = 0
    for state in flight():
        found, expected = jets.update(state), others.update(state)
        for one, other in ((found.acc, expected.acc), (found.std, expected.std)):
            np.testing.assert_array_equal(one, other)
        assert found.status.tolist() == expected.status.tolist()
        pushed += int(np.count_nonzero(found.acc))
    assert pushed > 80
