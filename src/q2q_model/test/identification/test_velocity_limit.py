"""Rows at a velocity limit: beside them, too, differences are not the acceleration that was given."""

import numpy as np

from q2q_model.identification.gains.velocity_limit import AROUND, at_velocity_limit

DT = 0.01


def test_differences_away_from_the_limit_are_the_acceleration_that_was_given() -> None:
    """A velocity of 0.03 m/s a row, to and fro, whose limit of 0.25 m/s lies between two rows."""
    rows = np.arange(400)
    vel = np.clip(0.03 * (np.abs(rows % 80 - 40) - 20), -0.25, 0.25)
    acc = np.gradient(vel, DT)
    limited = at_velocity_limit(vel[:, None])[:, 0]
    np.testing.assert_allclose(np.abs(acc[~limited]), 3.0, rtol=1e-9)
    cut = np.abs(vel) == 0.25
    assert (np.abs(acc[~cut]) < 2.9).any()  # those beside the limit are wrong
    near = np.abs(rows[:, None] - rows[cut]).min(axis=1)
    np.testing.assert_array_equal(limited, near <= AROUND)
