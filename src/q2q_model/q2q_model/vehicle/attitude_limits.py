"""Tilt and yaw rate that controllers exceed only if told to, and their least thrust: bounds of plans, too."""

TILT_MAX = 0.35
"""Largest angle of thrust to vertical [rad]: at the thrust of hover, 3.58 m/s^2 to the side."""

YAW_RATE_MAX = 3.5
"""Largest yaw rate [rad/s]."""

LEAST_THRUST = 0.05
"""Minimum thrust over weight of a controller's command [-]: with none, or less than MIN_THRUST, 1000 of 65535
(2 to 3 % of the weight), a Crazyflie's motors stop, and nothing holds its attitude."""
