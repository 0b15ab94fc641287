"""Fits of the residual where nothing pushes: no slope is known, and no residual is no process."""

import numpy as np
import pytest
from scipy.signal import lfilter

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.identification.jet.jet_deviation import affine_deviation
from q2q_model.identification.jet.residual_fit import fit_residual
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.signals.values import Array

STEP, ROWS, FLOOR, TIME_S = 0.01, 3000, 0.3, 0.1


def under(y: Array) -> PushSamples:
    """Return pushes y [m/s^2], (ROWS,), on a vehicle under another."""
    pos, rows = np.zeros((ROWS, 2, 3)), np.ones(ROWS, dtype=np.bool_)
    pos[:, :, 2] = [1.0, 1.5]
    motion = Motion(STEP * np.arange(ROWS), pos, 0.0 * pos, np.tile([0.0, 0.0, 1.0], (ROWS, 2, 1)))
    return PushSamples("flight", motion, 0, y, rows, rows, ~rows)


def stirred(seed: int) -> PushSamples:
    """Return pushes by stirred air alone, an Ornstein-Uhlenbeck process, and a little noise."""
    rng, keep = np.random.default_rng(seed), np.exp(-STEP / TIME_S)
    kicks = FLOOR * np.sqrt(1.0 - keep**2) * rng.standard_normal(ROWS)
    return under(lfilter([1.0], [1.0, -keep], kicks) + 0.1 * rng.standard_normal(ROWS))


def test_a_model_without_downwash_has_a_residual_without_a_known_slope() -> None:
    found = fit_residual(NoInteraction(), [stirred(seed) for seed in range(4)])
    assert found is not None
    spans = dict(found.intervals)
    assert (found.process.slope, spans["slope"]) == (0.0, None)
    assert spans["floor"] is not None
    assert spans["floor"].low < FLOOR < spans["floor"].high


@pytest.mark.filterwarnings("error")
def test_without_any_push_there_is_no_residual() -> None:
    assert fit_residual(NoInteraction(), [under(np.zeros(ROWS)) for _ in range(3)]) is None
    assert affine_deviation(np.ones(5), np.zeros(5)) == (0.0, 0.0)
