"""Verdict on the safe replanner's promise in an encounter, from its modified setpoints alone.

The verdict uses only the promise (q2q_planner.online.safe.safe_replanner): between ticks the motion is the
cubic through positions and velocities, sampled `BETWEEN` times per tick.

The promise's conditions follow from the plan alone: every pair starts at rest, out of the grown zone; and
references of vehicles apart stay within `acc_max` and `speed_max`, since other replanners rely on that.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array, SetpointStatus, SwarmSetpoint
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_planner.experiments.random_encounters import Encounter, all_clear
from q2q_planner.offline.minimum_snap.flight_limits import peak_norm
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.setpoint_error import reference_between

BETWEEN = 4
"""Samples per tick."""
CLEAR = 0.02
"""Minimum initial distance to the zone plus both `tracking` at which the conditions hold [m]."""
NEAR = 0.05
"""Distance to the reference within which a vehicle has arrived [m]."""


@dataclass(frozen=True, slots=True)
class EncounterVerdict:
    """Outcome of an encounter."""

    vehicles: int
    apart: bool
    conditions_hold: bool
    zone_time: float
    """Time with a pair in the zone [s]."""
    silent_time: float
    """Part of it with such a pair of which neither vehicle reported a broken promise [s]."""
    broken: bool
    """Some vehicle reported a broken promise."""
    clearance: float
    """Minimum signed distance of any pair to the zone [m]."""
    arrived: bool | None
    """All ended within NEAR of their references; None if these are in each other's zones."""
    shift: float
    """Largest horizontal shift of a vehicle [m]."""


def conditions_hold(encounter: Encounter, params: SafeReplannerParams) -> bool:
    """Return whether the promise must hold, from the plan alone."""
    plan = encounter.plan
    start = setpoint_at(plan, 0.0).pos
    i, j = np.triu_indices(len(plan.names), 1)
    room = Cylinder(params.eps, params.d).signed_distance(start[i] - start[j])
    if room.min() < 2.0 * params.tracking + CLEAR:
        return False
    if not encounter.apart:
        return True
    return all(
        peak_norm(curve, 1).value <= params.speed_max and peak_norm(curve, 2).value <= params.acc_max
        for curve in plan.trajectories
    )


def judge_encounter(
    flown: Sequence[SwarmSetpoint], encounter: Encounter, params: SafeReplannerParams
) -> EncounterVerdict:
    """Return the verdict on an encounter."""
    tick, pos = encounter.tick, _between(flown)  # (ticks, BETWEEN, n, 3)
    i, j = np.triu_indices(pos.shape[2], 1)
    distance = Cylinder(params.eps, params.d).signed_distance(pos[:, :, i] - pos[:, :, j])
    reported = np.array([one.status == SetpointStatus.PROMISE_BROKEN for one in flown])
    inside = distance < 0.0  # (ticks, BETWEEN, pairs)
    silent = inside & ~(reported[:, i] | reported[:, j])[:, None]
    last = setpoint_at(encounter.plan, flown[-1].t)
    moved = [one.pos[:, :2] - setpoint_at(encounter.plan, one.t).pos[:, :2] for one in flown]
    return EncounterVerdict(
        vehicles=pos.shape[2],
        apart=encounter.apart,
        conditions_hold=conditions_hold(encounter, params),
        zone_time=float(inside.any(axis=2).mean(axis=1).sum() * tick),
        silent_time=float(silent.any(axis=2).mean(axis=1).sum() * tick),
        broken=bool(reported.any()),
        clearance=float(distance.min()),
        arrived=bool(np.abs(flown[-1].pos - last.pos).max() < NEAR) if all_clear(last.pos) else None,
        shift=float(np.sqrt((np.array(moved) ** 2).sum(-1)).max()),
    )


def _between(flown: Sequence[SwarmSetpoint]) -> Array:
    """Return positions within each tick [m], (ticks, BETWEEN, n, 3): the cubic to the next one."""
    shares = np.arange(BETWEEN) / BETWEEN
    ticks = pairwise([*flown, flown[-1]])
    return np.array([[reference_between(one, after, share) for share in shares] for one, after in ticks])
