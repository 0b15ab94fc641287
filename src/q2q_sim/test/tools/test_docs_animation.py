import numpy as np

from q2q_model.geometry.rotations import quat_from_euler
from q2q_sim.tools.docs.animation import ARM, _outline

POS = np.array([0.3, -0.2, 1.5])


def test_a_level_vehicle_is_drawn_symmetric_about_its_position_with_rotors_above():
    y, z = _outline(POS, quat_from_euler(0.0, 0.0, 0.0))
    np.testing.assert_allclose(np.array(y) + y[::-1], 2.0 * POS[1])
    np.testing.assert_allclose(z, z[::-1])
    assert min(z) == POS[2]
    assert max(z) == POS[2] + 0.3 * ARM


def test_positive_roll_raises_the_left_end_which_is_at_larger_y():
    y, z = _outline(POS, quat_from_euler(0.2, 0.0, 0.0))
    ends = sorted([(y[4], z[4]), (y[5], z[5])])
    np.testing.assert_allclose(ends[1][1] - ends[0][1], 2.0 * ARM * np.sin(0.2))
    assert ends[0][0] < POS[1] < ends[1][0]
