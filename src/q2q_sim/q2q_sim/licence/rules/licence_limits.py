"""Limits of the rules of a licence."""

import math
from dataclasses import dataclass

from q2q_model.vehicle.constants import CONTACT


@dataclass(frozen=True, slots=True)
class LicenceLimits:
    """Limits of the rules."""

    half_room: tuple[float, float] = (3.0, 3.0)
    """Distance of the walls from the origin along x and y [m]."""
    ceiling: float = 2.5
    """[m]"""
    depth: float = 0.15
    """Depth below the floor that may be asked for [m]: it presses a landing onto it."""
    drop: float = 0.25
    """Height above which motors must not stop [m]; cflib's full_state_setpoint_demo stops them at 0.2 m."""
    stopped_s: float = 0.05
    """Shortest stop of the motors [s]."""
    landing: float = 2.25
    """[m/s]: a fall from `drop`."""
    gap: float = CONTACT
    """Smallest distance of two vehicles [m]."""
    beside: float = 0.24
    below: float = 0.6
    """Axes of the ellipsoid of the downwash [m]."""
    exposed_s: float = 0.3
    spin: float = math.radians(500.0)
    """[rad/s]"""
    spun_s: float = 0.2
    """Shortest spin [s]: an asked step of 360 deg/s overshoots to 500 for less."""
    rise_s: float = 5.0
    """Time in which a vehicle that is asked to fly has left the floor [s]: a take-off to 1 m in 20 s."""
    yaw_step: float = math.radians(185.0)
    """Largest step of an asked yaw beyond one turn [rad]: a program may count half turns in radians."""
