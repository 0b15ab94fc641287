"""Places to start from are inside a rectangular room, and as far apart horizontally as vehicles must be."""

import pytest

from q2q_sim.licence.rules.licence_limits import LicenceLimits
from q2q_sim.licence.rules.starting_places import check_starts

LIMITS = LicenceLimits(half_room=(3.0, 1.5))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("inside", "outside"), [((2.9, 1.4), (3.1, 1.4)), ((2.9, 1.4), (2.9, 1.6))])
def test_a_place_beyond_any_wall_is_refused(
    inside: tuple[float, float], outside: tuple[float, float], sign: float
) -> None:
    check_starts({"cf1": (sign * inside[0], sign * inside[1], 0.0)}, LIMITS)
    with pytest.raises(ValueError, match="the room is 6 by 3 m around the origin"):
        check_starts({"cf1": (sign * outside[0], sign * outside[1], 0.0)}, LIMITS)


def test_two_places_that_touch_are_refused_whatever_their_yaw() -> None:
    """The third number is a yaw [rad]."""
    near, far = (2.084, -1.112, 3.0), (2.09, -1.12, 3.0)  # 0.14 and 0.15 m from the first
    check_starts({"cf1": (2.0, -1.0, -3.0), "cf2": far}, LIMITS)
    with pytest.raises(ValueError, match=r"cf1 and cf2 are 0\.14 m apart \(minimum 0\.14 m\)"):
        check_starts({"cf1": (2.001, -1.0, -3.0), "cf2": near}, LIMITS)
