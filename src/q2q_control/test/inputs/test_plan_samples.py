"""A plan sampled for controllers that look ahead is the plan."""

import numpy as np

from q2q_control.inputs.plan_samples import STEP, sampled_preview
from q2q_model.trajectory.polynomials import Trajectory

CURVE = Trajectory(
    durations=np.array([1.0, 2.0]),
    coefficients=np.array([[[0.0, 1.0, 0.5], [1.0, 0.0, 0.0]], [[1.5, 2.0, -0.5], [1.0, 0.0, 0.25]]])[
        :, [0, 1, 1, 1]
    ],
)


def test_samples_are_the_polynomials_and_their_derivatives_piece_by_piece() -> None:
    preview = sampled_preview(("cf1",), [CURVE], start=10.0)
    row = preview.at(("cf1",), np.array([10.5, 11.0 + 0.4]))[0]
    np.testing.assert_allclose(row[0, [0, 3, 6]], [0.5 + 0.5 * 0.25, 1.0 + 0.5, 1.0], rtol=1e-12)
    np.testing.assert_allclose(row[1, [0, 3, 6]], [1.5 + 0.8 - 0.08, 2.0 - 0.4, -1.0], rtol=1e-12)
    np.testing.assert_allclose(row[1, [1, 4, 7]], [1.0 + 0.25 * 0.16, 0.5 * 0.4, 0.5], rtol=1e-12)


def test_after_its_end_a_shorter_curve_rests_at_its_last_point() -> None:
    longer = Trajectory(np.array([5.0]), np.zeros((1, 4, 2)))
    preview = sampled_preview(("cf1", "cf2"), [CURVE, longer], start=0.0)
    row = preview.at(("cf1",), np.array([4.0 + STEP]))[0, 0]
    np.testing.assert_allclose(row[:3], [1.5 + 4.0 - 2.0, 2.0, 2.0], rtol=1e-12)
    np.testing.assert_array_equal(row[3:], 0.0)
