"""Arrival of vehicles: each at its point and at rest.

A vehicle is at rest once it has stayed within still_speed * settle_s of one place for settle_s. One that
drifts faster than still_speed does not rest, nor does one that circles or swings by more than that length,
whatever its period. In the air of a room, vehicles that hold their places move at 0.075 m/s (median): two are
soon below 0.1 m/s together, seven never for 0.5 s. Each is therefore judged by itself, and remains at rest
until it leaves its point or the place of its rest, or is not measured for settle_s. Shorter gaps in motion
capture interrupt no rest, and none is completed within one.
"""

import numpy as np

from q2q_control.flight_procedure.checks.flight_checks import stale_refusal
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_model.signals.values import Array


class Arrival:
    """Places of vehicles, and since when each has not left its own."""

    def __init__(self, params: FlightProcedureParams, landing: LandingParams) -> None:
        self._settle_s, self._stale_s = params.settle_s, landing.stale_s
        self._extent = params.still_speed * params.settle_s
        self.reset()

    def reset(self) -> None:
        """Forget all rests."""
        self._place: Array = np.full(3, np.nan)  # where each vehicle's rest began [m], (n, 3)
        self._since: Array = np.array(np.inf)  # [s], (n,)
        self._rested = np.zeros(1, dtype=np.bool_)  # (n,)
        self.there = False
        """All vehicles are measured at their points, at rest or not."""

    def update(self, observation: Observation, points: Array, near: float, t: float) -> str:
        """Return why a vehicle is not at rest within `near` [m] of its point (n, 3) [m] at time t [s].

        Empty if all are; the rests of vehicles need not begin together.
        """
        pos, age = observation.pos, observation.age
        off = np.linalg.norm(pos - points, axis=1)
        there = (off <= near) & (age <= max(self._settle_s, self._stale_s))
        moved = np.linalg.norm(pos - self._place, axis=1)
        stays = there & (moved <= np.where(self._rested, near, self._extent))
        self._place = np.where(stays[:, None], self._place, pos)
        self._since = np.where(stays, self._since, t)
        long_enough = (t - self._since >= self._settle_s) & (age <= self._stale_s)
        self._rested = there & ((stays & self._rested) | long_enough)
        self.there = bool(there.all())
        if self._rested.all():
            return ""
        return self._reason(observation, off, near, int(np.argmin(self._rested)), t)

    def _reason(self, observation: Observation, off: Array, near: float, row: int, t: float) -> str:
        name, height, far = observation.names[row], float(observation.pos[row, 2]), float(off[row])
        stale = stale_refusal(name, float(observation.age[row]), self._stale_s)
        if stale:
            return stale
        if not far <= near:
            return f"{name} is at {height:z.2f} m, {far:.2f} m from where it should be"
        held = f"within {self._extent:.2g} m of one place for {t - float(self._since[row]):.2f} s"
        return f"{name} still moves: it has stayed {held}, {self._settle_s:g} s are required"


def points_at(observation: Observation, height: float) -> Array:
    """Return the points at a height [m] above or below the vehicles, (n, 3)."""
    return np.column_stack([observation.pos[:, :2], np.full(len(observation.names), height)])


def setpoints_rest(
    observation: Observation, params: FlightProcedureParams, points: Array | None = None
) -> bool:
    """Return whether setpoints are 100 times slower than a vehicle at rest, and at `points` (n, 3) [m]."""
    still = np.linalg.norm(observation.setpoint_vel, axis=1) < 0.01 * params.still_speed
    if points is None:
        return bool(still.all())
    near = np.linalg.norm(observation.setpoint_pos - points, axis=1) < 0.1 * params.goal_tolerance
    return bool(near.all() and still.all())


def heights_text(observation: Observation) -> str:
    """Return the height of every vehicle as text."""
    return ", ".join(
        f"{name} at {height:z.2f} m"
        for name, height in zip(observation.names, observation.pos[:, 2].tolist(), strict=True)
    )
