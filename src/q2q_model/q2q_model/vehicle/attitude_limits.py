"""Largest tilt and yaw rate that controllers command unless set otherwise, and that plans may need."""

TILT_MAX = 0.35
"""Largest angle of thrust to vertical [rad]: at the thrust of hover, 3.58 m/s^2 to the side."""

YAW_RATE_MAX = 3.5
"""Largest yaw rate [rad/s]."""
