"""Compiled loop over pairs for the equations of `q2q_model.downwash.jet`.

Units and symbols are defined there; `numbers` are a Jet's fields in the order of the constants below.
"""

import math

from q2q_model.compiled import compiled
from q2q_model.downwash.roles import BLEND
from q2q_model.signals.values import Array

STEEPEST = 0.5
"""Largest slope b_xy / b_z that a jet follows [-], 27 degrees; steeper slopes are clipped."""

_STRENGTH, _GAP_REF, _POWER, _ORIGIN, _RATE, _WIDTH = range(6)
_SPREAD, _UPPER, _SPEED, _CARRIED, _RANGE = range(6, 11)

Motion = tuple[Array, Array, Array]
"""Velocity and body z of the sources, velocity of the exposed vehicles, (p, 3) each."""


def _drift(dz: float, vel: Array, axis: Array, numbers: Array) -> tuple[float, float]:
    """Return the horizontal displacement of the air since it left its source [m]."""
    upright = max(axis[2], 0.5)
    sx, sy = axis[0] / upright, axis[1] / upright
    cut = max(math.sqrt(sx * sx + sy * sy) / STEEPEST, 1.0)
    fall, tau = max(dz, 0.0), 0.0
    if numbers[_SPEED] > 0.0:
        tau = min(fall, numbers[_RANGE]) / numbers[_SPEED]
    carried = numbers[_CARRIED]
    return carried * (vel[0] * tau - fall * sx / cut), carried * (vel[1] * tau - fall * sy / cut)


def _push_of(rel_pos: Array, vel: Array, axis: Array, climb: float, numbers: Array) -> float:
    """Return the downward acceleration [m/s^2] of a lower vehicle that climbs at `climb` [m/s]."""
    x, y, dz = rel_pos[0], rel_pos[1], rel_pos[2]
    gap, meeting = dz * math.tanh(dz / BLEND), 1.0
    if numbers[_CARRIED] > 0.0:
        dx, dy = drift(dz, vel, axis, numbers)
        x, y = x + dx, y + dy
        if numbers[_SPEED] > 0.0:
            meeting = max(1.0 + numbers[_CARRIED] * climb / numbers[_SPEED], 0.0)
    width = numbers[_WIDTH] + numbers[_SPREAD] * gap
    gaussian = math.exp(-(x * x + y * y) / (2.0 * width * width))
    if numbers[_POWER] > 0.0:
        fall = (numbers[_ORIGIN] + numbers[_GAP_REF]) / (numbers[_ORIGIN] + gap)
        decay = fall * fall
    else:
        decay = math.exp(-numbers[_RATE] * (gap - numbers[_GAP_REF]))
    return float(numbers[_STRENGTH] * decay * gaussian * meeting)


def _jet_pairs(rel_pos: Array, motion: Motion, numbers: Array, push: Array, eta: Array) -> None:
    source_vel, source_axis, vel = motion
    for k in range(rel_pos.shape[0]):
        push[k] = push_of(rel_pos[k], source_vel[k], source_axis[k], vel[k, 2], numbers)
        share = 0.5 * (1.0 + math.tanh(rel_pos[k, 2] / BLEND))
        eta[k, 0], eta[k, 1] = 0.0, 0.0
        eta[k, 2] = (numbers[_UPPER] * (1.0 - share) - share) * push[k]


drift, push_of = compiled(_drift), compiled(_push_of)
jet_pairs = compiled(_jet_pairs)
"""Write the push (p,) and eta (p, 3) [m/s^2] of pairs: (rel_pos (p, 3), motion, numbers (11,), push, eta)."""
