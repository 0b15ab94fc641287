"""Shift of the setpoint of a vehicle that evades others (descent_evasion).

It keeps a distance d_j from the place p_j of each of them, along a direction u_j:

    goal = max(0, d_j - (r - p_j) . u) u          r: setpoint, horizontal
    s'' = w^2 (goal - s) + 2 w (goal' - s')       flown: r + s with its velocity and acceleration

where goal' = max(0, d_j' - r' . u) u: a distance that grows is kept without a lag of up to 2 d' / w, and
nothing that moves away is braked. Both are 0 while the straight way of the vehicle to r keeps d_j from p_j,
as it does past j. The shift of a vehicle that is not measured comes to rest, s'' = -w s': it would be lost
at speed.

A setpoint that jumps to where its vehicle is (rejoining, climb_back, a replanner that restarts its motion)
contains the shift already: s and s' begin at 0 again. Kept, they would send the vehicle twice as far.

| symbol | name | meaning [unit] |
|---|---|---|
| s | pos | horizontal shift of a setpoint [m], (2,) |
| u | direction | horizontal unit vector, (2,) |
| d | reach | distance to keep [m] |
| w | PACE | bandwidth of the critically damped shift [rad/s] |
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array

Place = tuple[float, float]
"""Horizontal [m]."""

PACE = 3.0
"""80 % of the shift within 1 s, the time from level to landing, and for 0.6 m no more than 5.4 m/s^2."""
AT_REST = 1e-3
"""Shift below which an evasion has ended [m]."""
JUMP = 0.1
"""Step of a setpoint, less its velocity, that is a jump [m]: a corner of a plan at 1 m/s in LONGEST_STEP."""


class EvadedVehicle(NamedTuple):
    """Vehicle that is evaded."""

    place: Place
    reach: float
    """Distance to keep from it [m]."""
    growth: float
    """Rate at which that distance grows [m/s]."""


@dataclass(slots=True)
class EvasionShift:
    """Shift of one vehicle's setpoint [m], its velocity [m/s], (2,) each, and the vehicles that it evades."""

    pos: Array = field(default_factory=lambda: np.zeros(2))
    vel: Array = field(default_factory=lambda: np.zeros(2))
    directions: dict[str, Array] = field(default_factory=dict)
    """u for each vehicle that is evaded."""
    returning: set[str] = field(default_factory=set)
    """Those of them that are measured again."""
    sent: Place | None = None
    """Setpoint of the last tick, without the shift."""

    def begin_at(self, sent: Array, step: Array, at: Array) -> bool:
        """Begin at 0 if the setpoint has jumped to where the vehicle is; return whether it has.

        Args:
            sent: setpoint [m], (2,).
            step: by how much its velocity has moved it since the last tick [m], (2,).
            at: where the vehicle is [m], (2,).
        """
        (x, y), (dx, dy), (px, py), (sx, sy) = sent.tolist(), step.tolist(), at.tolist(), self.pos.tolist()
        was_x, was_y = self.sent or (x, y)
        self.sent = x, y
        jumped = math.hypot(x - was_x - dx, y - was_y - dy) > JUMP
        begins = jumped and math.hypot(x - px, y - py) < math.hypot(x + sx - px, y + sy - py)
        if begins:
            self.pos, self.vel = np.zeros(2), np.zeros(2)
        return begins

    def goal(
        self, pos: Array, vel: Array, at: Place, evaded: Mapping[str, EvadedVehicle]
    ) -> tuple[Array, Array]:
        """Return the shift that a setpoint (3,) should have [m] and its velocity [m/s], (2,) each.

        By plain numbers, as where half of a swarm is lost there are thousands of pairs.

        Args:
            pos: setpoint [m].
            vel: its velocity [m/s].
            at: where the vehicle is [m].
            evaded: others, by name.
        """
        (x, y, _), (vx, vy, _) = pos.tolist(), vel.tolist()
        back = at[0] - x, at[1] - y
        sx = sy = sent_x = sent_y = 0.0
        for other, direction in self.directions.items():
            ((px, py), reach, growth), (ux, uy) = evaded[other], direction.tolist()
            if _is_clear((x - px, y - py), back, reach):
                continue
            shortfall = reach - ((x + sx - px) * ux + (y + sy - py) * uy)
            if shortfall > 0.0:
                sx, sy = sx + shortfall * ux, sy + shortfall * uy
                towards = max(growth - ((vx + sent_x) * ux + (vy + sent_y) * uy), 0.0)
                sent_x, sent_y = sent_x + towards * ux, sent_y + towards * uy
        return np.array([sx, sy]), np.array([sent_x, sent_y])

    def follow(self, target: Array, target_vel: Array, dt: float) -> Array:
        """Integrate over dt [s]; return the acceleration [m/s^2], (2,)."""
        acc = PACE**2 * (target - self.pos) + 2.0 * PACE * (target_vel - self.vel)
        self.vel = self.vel + acc * dt
        self.pos = self.pos + self.vel * dt
        return acc

    @property
    def resting_place(self) -> Array:
        """Return the shift towards which it comes to rest by s'' = -w s' [m], (2,)."""
        return self.pos + self.vel / PACE

    @property
    def over(self) -> bool:
        """Return whether the evasion has ended and the setpoint is no longer shifted."""
        return not self.directions and float(np.abs(self.pos).max() + np.abs(self.vel).max()) < AT_REST


def _is_clear(setpoint: Place, back: Place, reach: float) -> bool:
    """Return whether the straight way of a vehicle to its setpoint keeps `reach` [m] from a place.

    Args:
        setpoint: from the place [m].
        back: from the setpoint to the vehicle [m].
        reach: [m].
    """
    (x, y), (bx, by) = setpoint, back
    squared = bx * bx + by * by
    share = min(max(-(x * bx + y * by) / squared, 0.0), 1.0) if squared > 0.0 else 0.0
    return math.hypot(x + share * bx, y + share * by) >= reach
