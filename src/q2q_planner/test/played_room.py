"""A room in which a plan of two vehicles is played, frame by frame."""

import numpy as np

from q2q_model.signals.values import Array, MocapFrame, SwarmSetpoint
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.plan_playback.plan_player import PlanPlayer
from q2q_planner.plan_playback.transit import TransitParams

NAMES = ("cf1", "cf2")
PLAN = minimum_snap_plan(
    [
        VehicleWaypoints("cf1", (Waypoint(0.0, (0.0, 0.0, 1.0)), Waypoint(4.0, (1.0, 0.0, 1.5)),
                                 Waypoint(8.0, (0.0, 0.0, 1.0)))),
        VehicleWaypoints("cf2", (Waypoint(0.0, (0.0, 1.0, 1.5)), Waypoint(8.0, (0.0, -1.0, 1.5)))),
    ]
)  # fmt: skip
GROUND = np.array([[0.1, 0.0, 0.0], [0.0, 1.1, 0.0]])
ABOVE = GROUND + np.array([0.0, 0.0, 0.5])
STEP = 0.01


class PlayedRoom:
    """Frames of vehicles that stay where they are put."""

    def __init__(self, pos: Array = GROUND) -> None:
        self.player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True)
        self.pos, self.t = pos, 100.0
        self.setpoints: list[SwarmSetpoint] = []
        self.player.update(frame(self.t, self.pos))  # a transit begins where two frames agree

    def tick(self, seconds: float = STEP) -> SwarmSetpoint:
        """Play on for a time [s]; return the last reference."""
        for _ in range(round(seconds / STEP)):
            self.t += STEP
            self.setpoints.append(self.player.update(frame(self.t, self.pos)))
        return self.setpoints[-1]

    def largest_step(self) -> float:
        """Return how far the reference moved in one tick at most [m]."""
        pos = np.array([one.pos for one in self.setpoints])
        return float(np.linalg.norm(np.diff(pos, axis=0), axis=2).max())


def frame(t: float, pos: Array) -> MocapFrame:
    """Return a frame of level vehicles at positions (2, 3)."""
    return MocapFrame(t, NAMES, pos, np.tile([0.0, 0.0, 0.0, 1.0], (len(pos), 1)))


def first_points() -> Array:
    """Return where the plan begins, (2, 3)."""
    return np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 1.5]])


def set_back(player: PlanPlayer, to: float) -> SwarmSetpoint:
    """Return the reference in which the player follows a clock set back to a time [s]."""
    return [player.update(frame(to + STEP * k, GROUND)) for k in range(11)][-1]
