"""Faults of poses, vehicle by vehicle, are those that plain numpy finds."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from q2q_model.estimation.attitude.attitude_steps import UNIT_TOLERANCE
from q2q_model.estimation.pose_faults import pose_faults
from q2q_model.signals.values import Array

POS_MAX = 5.0
odd = st.sampled_from([np.nan, np.inf, -np.inf, 0.0, -0.0, 5.0, -5.0, 1e200])
poses = arrays(np.float64, (4, 7), elements=st.one_of(st.floats(-6.0, 6.0), odd))


@given(poses)
def test_faults_are_those_of_plain_numpy(given_poses: Array) -> None:
    pos, quat = given_poses[:, :3], given_poses[:, 3:]
    found = pose_faults(given_poses, POS_MAX)
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.linalg.norm(quat, axis=1)
        off = ~(np.abs(length - 1.0) <= UNIT_TOLERANCE)
    np.testing.assert_array_equal(found.outside, (np.abs(pos) > POS_MAX).any(axis=1))
    np.testing.assert_array_equal(found.missing, ~np.isfinite(pos).all(axis=1))
    np.testing.assert_array_equal(found.not_unit, np.isfinite(quat).all(axis=1) & off)


def test_a_good_pose_has_no_fault_and_each_fault_is_of_one_vehicle() -> None:
    good = [1.0, -2.0, 0.5, 0.0, 0.6, 0.0, 0.8]
    rows = np.array([good] * 5)
    rows[1, 0], rows[2, 6], rows[3, 2], rows[4, 3:] = -5.1, 0.7, np.nan, [1.0, 0.0, 0.0, 0.0]
    found = pose_faults(rows, POS_MAX)
    assert [np.flatnonzero(mask).tolist() for mask in found] == [[1], [2], [4], [3]]
    assert found._fields == ("outside", "not_unit", "upside_down", "missing")
