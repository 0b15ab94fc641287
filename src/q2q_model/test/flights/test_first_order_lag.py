"""A first-order lag of samples at any times."""

import numpy as np

from q2q_model.flights.first_order_lag import first_order_lag


def test_the_lag_of_frames_that_come_at_uneven_times_is_that_of_their_own_steps() -> None:
    """A third of the frames is lost; the command steps at 1 s, and each frame shows the step's answer."""
    t = 0.01 * np.arange(300)[np.random.default_rng(6).random(300) > 0.3]
    step = np.where(t < 1.0, 0.0, 1.0)[:, None]
    before = t[t < 1.0][-1]
    expected = np.where(t < 1.0, 0.0, 1.0 - np.exp(-(t - before) / 0.1))
    np.testing.assert_allclose(first_order_lag(step, t, 0.1)[:, 0], expected, atol=1e-12)
    np.testing.assert_array_equal(first_order_lag(step, t, 0.0), step)
