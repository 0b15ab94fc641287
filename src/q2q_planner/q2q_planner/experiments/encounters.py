"""Random encounters under the safe replanner, with late and lost messages, that test its promise.

An encounter is a plan without avoidance and the communication of its vehicles: `together`, one replanner for
all; or `apart`, one replanner each, which receives one message of every other vehicle per tick, up to `delay`
late (so messages may overtake each other) and lost with probability `loss`. The verdict uses only the promise
(`safe_replanner`): between ticks the motion is the cubic through positions and velocities, sampled `BETWEEN`
times per tick.

The promise's conditions follow from the plan alone: every pair starts at rest, out of the grown zone; and
references of vehicles apart stay within `acc_max` and `speed_max`, since other replanners rely on that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import Array, SetpointStatus, SwarmSetpoint, SwarmState
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_planner.offline.minimum_snap.flight_limits import peak_norm
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import Point, VehicleWaypoints, Waypoint
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams

TICKS = (0.01, 0.02, 0.05)
"""Ticks of replanners at 100, 50 or 20 Hz [s]; a motion is held for two ticks."""
BETWEEN = 4
"""Samples per tick."""
AFTERWARDS = 1.0
"""Flight time after the last waypoint [s]."""
LATEST = 0.3
"""Largest delay of a message [s]."""
MOST_LOST = 0.1
"""Largest share of lost messages."""
CLEAR = 0.02
"""Minimum initial distance to the zone plus both `tracking` at which the conditions hold [m]."""
NEAR = 0.05
"""Distance to the reference within which a vehicle has arrived [m]."""

Shape = Literal["lines", "curves", "ring"]
MOSTLY_CLEAR = 0.8
"""Share of encounters whose starts and ends are drawn until they are out of each other's zones."""
DRAWS = 100
"""Most draws of starts and ends."""
APART = 0.4
"""Horizontal distance at which two vehicles are out of each other's zones [m]."""

SHAPES: tuple[Shape, ...] = ("lines", "curves", "ring")
"""Random straight lines; through a random point without stopping; to the opposite side of a ring."""


@dataclass(frozen=True, slots=True, eq=False)
class Encounter:
    """Vehicles that meet, and how they receive each other's states."""

    plan: SwarmPlan
    tick: float
    """[s]"""
    apart: bool
    delay: Array
    """Largest delay of messages from j to i [s], (n, n); unused together."""
    loss: float
    """Share of lost messages."""


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


def random_encounter(
    generator: np.random.Generator, fewest: int = 2, most: int = 10, clear_by: float = APART
) -> Encounter:
    """Return an encounter of `fewest` to `most` vehicles at up to about 2 m/s; half of them apart.

    Most start and end at least `clear_by` [m] apart horizontally.
    """
    n = int(generator.integers(fewest, most + 1))
    shape = SHAPES[generator.integers(len(SHAPES))]
    end, side = generator.uniform(3.0, 5.0), generator.uniform(1.5, 2.0 + 0.2 * n)
    points = _points(generator, shape, n, side)
    clear = generator.random() < MOSTLY_CLEAR
    for _ in range(DRAWS if clear else 0):
        if _all_clear(points[:, 0], clear_by) and _all_clear(points[:, -1], clear_by):
            break
        points = _points(generator, shape, n, side)
    times = np.linspace(0.0, end, points.shape[1])
    plan = minimum_snap_plan(
        [
            VehicleWaypoints(f"cf{row}", tuple(_waypoint(t, pos) for t, pos in zip(times, own, strict=True)))
            for row, own in enumerate(points)
        ],
        "free",
    )
    delay, tick = generator.uniform(0.0, LATEST, (n, n)), float(generator.choice(TICKS))
    loss = float(generator.uniform(0.0, MOST_LOST))
    return Encounter(plan, tick, bool(generator.integers(2)), delay, loss)


def _points(generator: np.random.Generator, shape: Shape, n: int, side: float) -> Array:
    """Return waypoints [m], (n, 2 or 3, 3)."""
    box = np.array([side / 2, side / 2, 0.6])
    if shape == "ring":
        angle = generator.uniform(0.0, 2.0 * np.pi) + 2.0 * np.pi * np.arange(n) / n
        height = generator.choice([0.0, 0.3]) * generator.normal(size=n) + 1.2
        out = np.stack([0.5 * side * np.cos(angle), 0.5 * side * np.sin(angle), height], axis=-1)
        return np.stack([out, out * [-1.0, -1.0, 1.0]], axis=1)
    stops = 2 if shape == "lines" else 3
    return np.asarray(generator.uniform(-1.0, 1.0, (n, stops, 3)) * box + [0.0, 0.0, 1.2])


def _all_clear(pos: Array, clear_by: float = APART) -> bool:
    i, j = np.triu_indices(len(pos), 1)
    return bool(np.hypot(*(pos[i] - pos[j])[:, :2].T).min() > clear_by)


def _waypoint(t: float, pos: Array) -> Waypoint:
    point: Point = (float(pos[0]), float(pos[1]), float(pos[2]))
    return Waypoint(float(t), point)


def fly_encounter(
    encounter: Encounter, params: SafeReplannerParams, generator: np.random.Generator
) -> list[SwarmSetpoint]:
    """Return the modified setpoints of all vehicles at every tick; `generator` delays and drops messages."""
    ticks = round((encounter.plan.duration + AFTERWARDS) / encounter.tick)
    references = [setpoint_at(encounter.plan, k * encounter.tick) for k in range(ticks)]
    held = replace(params, hold=2.0 * encounter.tick)
    if not encounter.apart:
        replanner = SafeReplanner(held)
        return [replanner.update(reference, None) for reference in references]
    return _fly_apart(references, encounter, held, _newest_received(encounter, ticks, generator))


def _newest_received(encounter: Encounter, ticks: int, generator: np.random.Generator) -> Array:
    """Return the tick of the newest message of j received by i, (ticks, n, n); all receive tick 0."""
    n = len(encounter.plan.names)
    newest = np.zeros((ticks, n, n), dtype=np.intp)
    sent = np.arange(1, ticks)
    for i in range(n):
        for j in range(n):
            late = generator.uniform(0.0, encounter.delay[i, j], ticks - 1)
            comes = sent + np.ceil(late / encounter.tick).astype(np.intp)
            there = (generator.random(ticks - 1) >= encounter.loss) & (comes < ticks)
            np.maximum.at(newest[:, i, j], comes[there], sent[there])
    return np.maximum.accumulate(newest, axis=0)


def _fly_apart(
    references: Sequence[SwarmSetpoint], encounter: Encounter, params: SafeReplannerParams, newest: Array
) -> list[SwarmSetpoint]:
    n = len(encounter.plan.names)
    replanners = [SafeReplanner(params) for _ in range(n)]
    flown: list[SwarmSetpoint] = []
    for tick, reference in enumerate(references):
        known = flown or [reference]  # a message arrives one tick later at the earliest
        rows = []
        for i, replanner in enumerate(replanners):
            received = np.minimum(newest[tick, i], len(known) - 1)
            received[i] = len(known) - 1
            rows.append(
                replanner.update(
                    of_vehicles(reference, np.array([i])), _received(reference.t, known, received)
                )
            )
        flown.append(_joined(reference, rows))
    return flown


def _received(t: float, flown: Sequence[SwarmSetpoint], tick: Array) -> SwarmState:
    """Return the state in which vehicle j has its position of tick[j]."""
    n = len(tick)
    return SwarmState(
        t=t,
        names=flown[0].names,
        pos=np.stack([flown[k].pos[j] for j, k in enumerate(tick)]),
        vel=np.stack([flown[k].vel[j] for j, k in enumerate(tick)]),
        quat=np.tile([0.0, 0.0, 0.0, 1.0], (n, 1)),
        ang_vel_body=np.zeros((n, 3)),
        age=np.array([t - flown[k].t for k in tick]),
        status=np.zeros(n, dtype=np.uint8),
    )


def _joined(whole: SwarmSetpoint, rows: Sequence[SwarmSetpoint]) -> SwarmSetpoint:
    return replace(
        whole,
        pos=np.concatenate([row.pos for row in rows]),
        vel=np.concatenate([row.vel for row in rows]),
        acc=np.concatenate([row.acc for row in rows]),
        status=np.concatenate([row.status for row in rows]),
    )


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
    tick = encounter.tick
    pos = _between(flown, tick)  # (ticks, BETWEEN, n, 3)
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
        arrived=bool(np.abs(flown[-1].pos - last.pos).max() < NEAR) if _all_clear(last.pos) else None,
        shift=float(np.sqrt((np.array(moved) ** 2).sum(-1)).max()),
    )


def _between(flown: Sequence[SwarmSetpoint], tick: float) -> Array:
    """Return positions within each tick [m], (ticks, BETWEEN, n, 3): the cubic to the next one."""
    pos, vel = np.array([one.pos for one in flown]), np.array([one.vel for one in flown])
    after, rate = np.concatenate([pos[1:], pos[-1:]]), np.concatenate([vel[1:], vel[-1:]])
    found = []
    for share in np.arange(BETWEEN) / BETWEEN:
        rest = 1.0 - share
        ends = (1.0 + 2.0 * share) * rest**2 * pos + share**2 * (3.0 - 2.0 * share) * after
        found.append(ends + tick * share * rest * (rest * vel - share * rate))
    return np.stack(found, axis=1)
