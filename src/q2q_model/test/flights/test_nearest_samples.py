"""The row nearest to a time is that of the least distance, the first of several, wherever the time lies."""

import numpy as np

from q2q_model.flights.interpolated_gaps import nearest_samples


def test_the_nearest_row_has_the_least_distance_and_is_the_earlier_of_two_as_near() -> None:
    rng = np.random.default_rng(0)
    for size in (1, 2, 3, 50):
        t = np.unique(rng.integers(0, 400, size)) * 0.25  # binary fractions: halfway is exact
        at = np.concatenate([rng.uniform(-10.0, 110.0, 200), 0.5 * (t[1:] + t[:-1]), t])
        least = np.abs(at[:, None] - t).argmin(axis=1)  # the first of several
        assert np.array_equal(nearest_samples(t, at), least)
