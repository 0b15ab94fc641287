"""Smallest downwash zone whose avoidance reduces the height errors of a swarm by a given share.

A learned downwash eta has no edge, and its strength alone does not determine its effect, which also depends
on the time spent in it and on the altitude loop. So the threshold is chosen by its effect. For the level sets
{ |eta| >= threshold } (`q2q_model.downwash.level_set`) the swarm is planned around the set, and the height
errors of the loop (13) in the downwash (14) are predicted along that plan and along the one without avoidance
(`altitude_response`). Weaker thresholds give larger zones, higher snap cost and smaller errors; bisection of
log(threshold) finds the strongest threshold at which, for every vehicle,

    rms(z) with avoidance <= (1 - cut) rms(z) without,    or below HARMLESS.

Other shapes (cylinders, spheroids) were compared on section 4.1: all lie on one curve of cost against error,
so the level set, which has a single parameter, is as good as any.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.level_set import LevelSet, level_set, peak_downwash
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.altitude_loop import PAPER_LOOP, AltitudeLoop
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.joint_plan import AvoidancePlan, avoid_zones
from q2q_planner.offline.avoidance.waypoint_checks import InfeasibleError
from q2q_planner.offline.minimum_snap.minimum_snap import Reading, minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.offline.zones.altitude_response import altitude_rms

HARMLESS = 1e-3
"""Height error that needs no reduction [m]: below VICON's 2 mm dynamic error."""
STEP = 0.02
"""Step of the prediction [s]: 1/350 of the learned loop's period."""
STRONGEST, FAINTEST = 0.5, 0.005
"""Range of thresholds, as shares of the downwash's peak."""
HALVINGS = 7
"""The threshold is found within (STRONGEST / FAINTEST)^(1 / 2^7): 4 %."""


@dataclass(frozen=True, slots=True)
class LearnedDownwash:
    """Learned downwash model and altitude loop."""

    model: InteractionModel
    loop: AltitudeLoop = PAPER_LOOP
    cut: float = 0.88
    """Relative reduction of the height error, 0 to 1, both excluded; a flight must reach 0.85, which a
    learned downwash predicts within 0.01."""

    def __post_init__(self) -> None:
        """Raise ValueError if the share is out of bounds."""
        if not 0.0 < self.cut < 1.0:
            raise ValueError(f"cut = {self.cut}; must be above 0 and below 1")


@dataclass(frozen=True, slots=True, eq=False)
class DownwashPlan:
    """Plan around a downwash zone."""

    found: AvoidancePlan
    zone: LevelSet
    before: Array
    """Predicted rms of the height error without avoidance [m], (n,)."""
    after: Array
    """With it [m], (n,)."""

    @property
    def cut(self) -> float:
        """Return the least relative reduction of a vehicle's height error; 1 if all errors are HARMLESS."""
        affected = self.after > HARMLESS
        return float((1.0 - self.after[affected] / self.before[affected]).min(initial=1.0))

    @property
    def effect(self) -> str:
        """Return the predicted effect on the height errors, in words: a share if one is above HARMLESS."""
        if (self.after > HARMLESS).any():
            return f"avoids {100.0 * self.cut:.1f} % of the predicted height error"
        left, free = 1e3 * self.after.max(), 1e3 * self.before.max()
        return f"leaves a predicted height error of at most {left:.2g} mm ({free:.2g} mm without avoidance)"


def avoid_downwash(
    swarm: Sequence[VehicleWaypoints],
    downwash: LearnedDownwash,
    reading: Reading = "stop_and_go",
    params: AvoidanceParams | None = None,
    warm: SwarmPlan | None = None,
) -> DownwashPlan:
    """Return the cheapest plan that reduces every vehicle's height error by the given share.

    Around each zone the search starts from `warm`, or as `avoid_zones` says without one.

    Raises:
        InfeasibleError: no plan was found around any zone tried, or none reduces the error by so much.
        ValueError: the model has no downwash, or the waypoints cannot be flown.
    """
    before = _predicted(minimum_snap_plan(swarm, reading), downwash)
    strong, faint = np.log(np.array([STRONGEST, FAINTEST]) * peak_downwash(downwash.model))
    tried: list[DownwashPlan] = []
    refusals: list[InfeasibleError] = []
    for _ in range(HALVINGS):
        middle = 0.5 * (strong + faint)
        zone = level_set(downwash.model, float(np.exp(middle)))
        try:
            found = avoid_zones(swarm, zone, reading, params, warm)
        except InfeasibleError as refusal:
            refusals.append(refusal)
            faint = middle  # too large
            continue
        tried.append(DownwashPlan(found, zone, before, _predicted(found.plan, downwash)))
        if tried[-1].cut >= downwash.cut:
            faint = middle
        else:
            strong = middle
    if not tried:
        raise refusals[-1]
    enough = [one for one in tried if one.cut >= downwash.cut]
    if not enough:
        most = f"at most {100.0 * max(one.cut for one in tried):.1f} % is avoided"
        asked = f"{100.0 * downwash.cut:g} % of the predicted height error"
        raise InfeasibleError(f"no plan avoids {asked}: {most}; allow more time, or move waypoints apart")
    return min(enough, key=lambda one: one.found.cost)


def _predicted(plan: SwarmPlan, downwash: LearnedDownwash) -> Array:
    """Return the rms of each vehicle's height error along a plan [m], (n,)."""
    t = np.arange(0.0, plan.duration, STEP)
    return altitude_rms(plan.positions(t), STEP, downwash.model, downwash.loop)
