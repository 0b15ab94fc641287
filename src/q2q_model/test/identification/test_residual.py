"""The predicted residual is optimal for a first-order process, and uses nothing from later than t - h."""

import numpy as np

from q2q_model.identification.push.residual import HORIZON_S, predicted_residual

STEP_S, TAU_S, ROWS = 0.01, 0.08, 40_000
T = STEP_S * np.arange(ROWS)
EVERY = np.ones(ROWS, dtype=bool)


def ornstein_uhlenbeck() -> np.ndarray:
    rng, keep = np.random.default_rng(0), np.exp(-STEP_S / TAU_S)
    noise, found = np.sqrt(1.0 - keep**2) * rng.normal(size=ROWS), np.zeros(ROWS)
    for k in range(1, ROWS):
        found[k] = keep * found[k - 1] + noise[k]
    return found


def test_a_first_order_process_is_predicted_to_its_conditional_variance():
    residual = ornstein_uhlenbeck()
    left = (residual - predicted_residual(T, residual, EVERY))[1000:]
    expected = 1.0 - np.exp(-2.0 * HORIZON_S / TAU_S)  # of a process of variance 1
    np.testing.assert_allclose(
        left.var(), expected, rtol=0.03
    )  # 40 000 rows, 2500 correlation times each way


def test_white_noise_is_not_predicted():
    noise = np.random.default_rng(1).normal(size=ROWS)
    assert (predicted_residual(T, noise, EVERY)[1000:] ** 2).mean() < 1e-3


def test_nothing_later_than_the_horizon_is_used():
    residual = ornstein_uhlenbeck()
    changed = residual.copy()
    changed[500:] += 10.0
    one, other = (predicted_residual(T, values, EVERY) for values in (residual, changed))
    np.testing.assert_array_equal(one[:502], other[:502])
    assert one[502] != other[502]


def test_unknown_rows_predict_nothing_and_teach_nothing():
    residual, usable = ornstein_uhlenbeck(), EVERY.copy()
    usable[100:200] = False
    found = predicted_residual(T, residual, usable)
    np.testing.assert_array_equal(found[102:202], 0.0)
    spoiled = residual.copy()
    spoiled[100:200] = 1e6
    np.testing.assert_array_equal(predicted_residual(T, spoiled, usable), found)


def test_a_gap_in_time_is_not_bridged():
    t = T.copy()
    t[300:] += 1.0
    np.testing.assert_array_equal(predicted_residual(t, ornstein_uhlenbeck(), EVERY)[300:302], 0.0)
