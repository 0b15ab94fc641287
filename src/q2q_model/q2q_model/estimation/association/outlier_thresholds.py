"""Thresholds of outliers (the paper, section 2.2), of the mocap filter and the rule on recorded flights."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable

REPEAT_STEP = 0.002
"""Step above which a vehicle counts as moving [m]: above the rounding of logs in millimetres, and more than a
hover moves within a tick."""


@dataclass(frozen=True, slots=True)
class OutlierThresholds:
    """Thresholds of positions and of their steps."""

    pos_max: float = tunable(
        50.0, "largest accepted |x|, |y|, |z|: no flight room is larger", unit="m", low=0.1
    )
    # Crazyflies above each other on real flights: at most 2.6 m/s, and 2.5 m/s^2 above 9.81 in downwash
    speed_max: float = tunable(4.0, "largest accepted speed of a vehicle", unit="m/s", low=0.1, high=100.0)
    # real flights deviate from straight motion by at most 26 mm within 20 ms (after a gap of a log)
    jump_max: float = tunable(0.04, "largest accepted deviation from motion", unit="m", low=1e-4, high=10.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)
