"""Compiled law of the jet, for many pairs at once; q2q_model.downwash.jet has its equations and symbols."""

import math
from typing import NamedTuple

from q2q_model.compiled import BORROWING, HOT, compiled
from q2q_model.downwash.roles import BLEND
from q2q_model.signals.values import Array

STEEPEST = 0.5
"""Largest slope b_xy / b_z that a jet follows [-], 27 degrees; steeper slopes are clipped."""


class JetLaw(NamedTuple):
    """Parameters of a Jet for the compiled loop."""

    strength: float
    gap_ref: float
    power: bool
    virtual_origin: float
    decay_rate: float
    width: float
    spread: float
    upper_ratio: float
    travel_speed: float
    carried: float
    velocity_share: float
    range: float


class JetPairs(NamedTuple):
    """Pairs for the compiled loop."""

    rel_pos: Array
    """r_j(t - tau) - r_i(t) [m], world, (p, 3); place k is one of pair k mod m."""
    source_vel: Array
    """Of source j [m/s], world, (m, 3)."""
    source_axis: Array
    """Body z of source j, world, (m, 3)."""
    vel: Array
    """Of vehicle i [m/s], world, (m, 3)."""


@compiled
def law_of_numbers(numbers: Array) -> JetLaw:
    """Return a law from its numbers (12,): numba looks at every field of a tuple in each call from Python."""
    strength, gap_ref, power, virtual_origin, decay_rate, width = numbers[:6]
    spread, upper_ratio, travel_speed, carried, velocity_share, reach = numbers[6:]
    shape = strength, gap_ref, power != 0.0, virtual_origin, decay_rate
    return JetLaw(*shape, width, spread, upper_ratio, travel_speed, carried, velocity_share, reach)


@compiled(**BORROWING)
def evaluate_pairs(pairs: JetPairs, law: JetLaw, push: Array, eta: Array) -> None:
    """Write the downward `push` (p,) on the lower vehicle, and eta (p, 3) of i [m/s^2], world."""
    for k in range(push.size):
        above = math.tanh(pairs.rel_pos[k, 2] / BLEND)
        push[k] = _push(pairs, k, above, law)
        share = 0.5 * (1.0 + above)
        eta[k, 0], eta[k, 1] = 0.0, 0.0
        eta[k, 2] = (law.upper_ratio * (1.0 - share) - share) * push[k]


@compiled(**HOT)
def _push(pairs: JetPairs, k: int, above: float, law: JetLaw) -> float:
    """Return the downward acceleration [m/s^2] of the lower vehicle at place k; `above`: tanh(dz / BLEND)."""
    x, y, dz = pairs.rel_pos[k, 0], pairs.rel_pos[k, 1], pairs.rel_pos[k, 2]
    gap, meeting = dz * above, 1.0
    if law.carried > 0.0:
        pair = k % pairs.vel.shape[0]
        dx, dy = _drift(dz, pairs.source_vel[pair], pairs.source_axis[pair], law)
        x, y = x + dx, y + dy
        if law.travel_speed > 0.0:
            meeting = max(1.0 + law.carried * pairs.vel[pair, 2] / law.travel_speed, 0.0)
    width = law.width + law.spread * gap
    gaussian = math.exp(-(x * x + y * y) / (2.0 * width * width))
    if law.power:
        fall = (law.virtual_origin + law.gap_ref) / (law.virtual_origin + gap)
        decay = fall * fall
    else:
        decay = math.exp(-law.decay_rate * (gap - law.gap_ref))
    return float(law.strength * decay * gaussian * meeting)


@compiled(**HOT)
def _drift(dz: float, vel: Array, axis: Array, law: JetLaw) -> tuple[float, float]:
    """Return the horizontal displacement of the air since it left its source [m]."""
    upright = max(axis[2], 0.5)  # no zero: a slope of 60 to 90 degrees is clipped below
    sx, sy = axis[0] / upright, axis[1] / upright
    cut = max(math.sqrt(sx * sx + sy * sy) / STEEPEST, 1.0)
    fall, tau = max(dz, 0.0), 0.0
    if law.travel_speed > 0.0:
        tau = min(fall, law.range) / law.travel_speed
    tau *= law.velocity_share
    return law.carried * (vel[0] * tau - fall * sx / cut), law.carried * (vel[1] * tau - fall * sy / cut)
