"""Known terms of an air, and checks of what is learned, for tests."""

import numpy as np

from q2q_sim.air.air_terms import AbsorptionTerm, ResidualTerm
from q2q_sim.air.learning.statistics.fitted import Fitted

ROLL, PITCH = np.array([-1.0, -1.0, 1.0, 1.0]), np.array([-1.0, 1.0, 1.0, -1.0])
"""Signs of the rotors' thrusts in roll and pitch torque."""
RESIDUAL = ResidualTerm(floor_mps2=0.28, slope=0.1, time_s=0.08)
ABSORPTION = AbsorptionTerm(share=0.5, width_m=0.1)
SECONDS = 120.0


def value(found: tuple[Fitted, ...], path: str) -> Fitted:
    """Return the value at a path."""
    return next(one for one in found if one.path == path)


def assert_within(found: tuple[Fitted, ...], path: str, known: float) -> None:
    """Assert that the interval at a path, widened by half, holds a known value and is not trivial.

    One 95 % interval in twenty misses; widened by half it is one of 99.7 %.
    """
    one = value(found, path)
    assert one.low is not None
    assert one.high is not None
    half = 0.75 * (one.high - one.low)
    middle = 0.5 * (one.high + one.low)
    assert abs(middle - known) <= half, one
    assert half < max(0.6 * abs(known), 0.03), one
