"""Body z of a vehicle in the predictor's kernel: level where any part of the orientation is unknown."""

import numpy as np
import pytest

from q2q_model.downwash.predictor_kernel import write_body_z
from q2q_model.geometry.rotations import UP, rotate


def body_z(quat: tuple[float, ...]) -> np.ndarray:
    axis = np.full(3, np.nan)
    write_body_z(np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *quat, 0.0]), axis)
    return axis


@pytest.mark.parametrize("unknown", range(4))
@pytest.mark.parametrize("quat", [(1.0, 0.0, 0.0, 0.0), (0.1, -0.7, 0.1, 0.7)])
def test_it_is_level_where_one_number_of_the_orientation_is_unknown(
    quat: tuple[float, ...], unknown: int
) -> None:
    """With w alone unknown, an inverted vehicle was taken for inverted."""
    spoilt = tuple(np.nan if k == unknown else part for k, part in enumerate(quat))
    assert body_z(spoilt).tolist() == [0.0, 0.0, 1.0]


def test_it_is_the_rotated_axis_where_the_orientation_is_known() -> None:
    quat = np.array([0.1, -0.7, 0.1, 0.7])
    quat /= np.linalg.norm(quat)
    np.testing.assert_allclose(body_z(tuple(quat)), rotate(quat, UP), atol=1e-15)
