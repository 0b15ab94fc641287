"""Arrival of vehicles: each at its point and at rest.

A vehicle in the air rests once it has been slower than 2.5 still_speed, and within still_speed * settle_s of
one place, for settle_s. One that swings is slow and stays at one place where it turns, but not for 1 s if it
swings about its point and reaches 0.3 m/s. On the ground one rests once it has been within GROUND_EXTENT
of one place for settle_s, at any speed; a landing ends when all rest and its duration has passed.

In the air of a room, vehicles that hold their places move at 0.08 m/s (median): two are soon both below
0.1 m/s for 0.5 s, seven never are. Each is therefore judged by itself, and remains at rest until it leaves
its point, is farther from where its rest began than the point allows, is too fast, or is not measured for
LOST_S. Shorter gaps in motion capture interrupt no rest, and none is completed within one.
"""

from dataclasses import dataclass

import numpy as np

from q2q_control.flight_procedure.checks.flight_checks import stale_refusal
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_model.counted import listed
from q2q_model.signals.values import Array

AIR_SPEED = 2.5
"""Bound on the speed of a vehicle at rest in the air, in units of still_speed.

By default 0.25 m/s: 99.9 % of the speeds of 7 to 100 simulated vehicles that hold their places, 0.6 m apart
in the air `room` of a `real` room, are below 0.22 to 0.24 m/s (K_p 10 and 6, K_d 5 and 4 in z and x, y)."""
GROUND_EXTENT = 0.03
"""Largest distance from where a rest on the ground began [m]: six times a noise of 5 mm (standard deviation
per axis), a poor motion capture; less than 0.06 m/s in the shortest settle_s."""
LOST_S = 0.5
"""Age of its state from which a vehicle is lost [s]: dropouts of motion capture are shorter
(q2q_sim.scenarios.room_profiles)."""


@dataclass(frozen=True, slots=True)
class RestPoints:
    """Points at which vehicles are to rest."""

    points: Array
    """[m], world, (n, 3)."""
    near: float
    """Largest distance from them [m]."""
    extent: float
    """Largest distance from where a rest began [m], until it is complete."""
    speed: float = np.inf
    """Largest speed, also later [m/s]."""


def in_the_air(points: Array, params: FlightProcedureParams) -> RestPoints:
    """Return the points (n, 3) [m] to hover at, as those of rest."""
    extent, speed = params.still_speed * params.settle_s, AIR_SPEED * params.still_speed
    return RestPoints(points, params.goal_tolerance, extent, speed)


def above(stood: Array, params: FlightProcedureParams) -> RestPoints:
    """Return the points of rest of a take-off: above where the vehicles stood (n, 3) [m], at its height."""
    return in_the_air(_over_the_ground(stood, params, params.take_off_height), params)


def on_the_ground(observation: Observation, params: FlightProcedureParams) -> RestPoints:
    """Return the points of rest of a landing: anywhere on the ground."""
    return RestPoints(_over_the_ground(observation.pos, params, 0.0), params.near_ground, GROUND_EXTENT)


class Arrival:
    """Places of vehicles, and since when each has not left its own."""

    def __init__(self, params: FlightProcedureParams, landing: LandingParams) -> None:
        self._settle_s, self._stale_s = params.settle_s, min(landing.stale_s, LOST_S)
        self.reset()

    def reset(self) -> None:
        """Forget all rests."""
        self._place: Array = np.full(3, np.nan)  # where each vehicle's rest began [m], (n, 3)
        self._since: Array = np.array(np.inf)  # [s], (n,)
        self._rested = np.zeros(1, dtype=np.bool_)  # (n,)
        self.there = False
        """All vehicles are measured at their points, at rest or not."""

    def update(self, observation: Observation, rest: RestPoints, t: float) -> str:
        """Return why a vehicle is not at rest at its point at time t [s].

        Empty if all are; their rests need not begin together.
        """
        pos, age = observation.pos, observation.age
        off = np.linalg.norm(pos - rest.points, axis=1)
        there = (off <= rest.near) & (age <= LOST_S)
        slow = np.linalg.norm(observation.vel, axis=1) <= rest.speed
        moved = np.linalg.norm(pos - self._place, axis=1)
        most = np.where(self._rested, max(rest.near, rest.extent), rest.extent)
        stays = there & slow & (moved <= most)
        self._place = np.where(stays[:, None], self._place, pos)
        self._since = np.where(stays, self._since, t)
        long_enough = (t - self._since >= self._settle_s) & (age <= self._stale_s)
        self._rested = there & ((stays & self._rested) | long_enough)
        self.there = bool(there.all())
        return "" if self._rested.all() else self._reason(observation, rest, int(np.argmin(self._rested)), t)

    def _reason(self, observation: Observation, rest: RestPoints, row: int, t: float) -> str:
        name, pos = observation.names[row], observation.pos[row]
        stale = stale_refusal(name, float(observation.age[row]), self._stale_s)
        if stale:
            return stale
        off = float(np.linalg.norm(pos - rest.points[row]))
        if not off <= rest.near:
            return f"{name} is at {float(pos[2]):z.2f} m, {off:.2f} m from its goal"
        slow = f" and below {rest.speed:.2g} m/s" if np.isfinite(rest.speed) else ""
        held = f"within {rest.extent:.2g} m of one place{slow} for {t - float(self._since[row]):.2f} s"
        return f"{name} still moves: it has stayed {held} (minimum {self._settle_s:g} s)"


def _over_the_ground(pos: Array, params: FlightProcedureParams, height: float) -> Array:
    """Return the points at a height [m] over the ground above or below positions (n, 3) [m], (n, 3)."""
    return np.column_stack([pos[:, :2], np.full(len(pos), params.ground_height + height)])


def setpoints_rest(
    observation: Observation, params: FlightProcedureParams, points: Array | None = None
) -> bool:
    """Return whether setpoints are slower than 0.01 still_speed, and at `points` (n, 3) [m]."""
    still = np.linalg.norm(observation.setpoint_vel, axis=1) < 0.01 * params.still_speed
    if points is None:
        return bool(still.all())
    near = np.linalg.norm(observation.setpoint_pos - points, axis=1) < 0.1 * params.goal_tolerance
    return bool(near.all() and still.all())


def heights_text(observation: Observation) -> str:
    """Return the height of every vehicle as text, of many that of the first ones."""
    heights = zip(observation.names, observation.pos[:, 2].tolist(), strict=True)
    return listed([f"{name} at {height:z.2f} m" for name, height in heights])
