"""Flight of an encounter under the safe replanner, ideally tracked, with late and lost messages."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import Array, SwarmSetpoint, SwarmState
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_planner.experiments.random_encounters import Encounter
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner

AFTERWARDS = 1.0
"""Flight time after the last waypoint [s]."""
HELD_TICKS = 2.0
"""Ticks for which a motion is held."""


def fly_encounter(
    encounter: Encounter, params: SafeReplannerParams, generator: np.random.Generator
) -> list[SwarmSetpoint]:
    """Return the modified setpoints of all vehicles at every tick; `generator` delays and drops messages."""
    ticks = round((encounter.plan.duration + AFTERWARDS) / encounter.tick)
    references = [setpoint_at(encounter.plan, k * encounter.tick) for k in range(ticks)]
    held = replace(params, hold=HELD_TICKS * encounter.tick)
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
