"""Motion that a swarm commits to after its choice, and what of it is outside the conditions."""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask
from q2q_planner.online.safe.choice.desired_motion import AS_ASKED, DesiredMotion
from q2q_planner.online.safe.choice.motion_choice import OLD, Choices
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, MotionRows
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.vectors import norm
from q2q_planner.online.safe.stopping.broad_phase import Pairs


class Decision(NamedTuple):
    """What a tick has decided besides the motion."""

    acc: Array
    """Acceleration of the motion at its time [m/s^2], (n, 3)."""
    outside: Mask
    """Vehicles of bounded jerk that are too fast, or near an external vehicle, (n,)."""


class _Bounds(NamedTuple):
    """Fields of SafeReplannerParams."""

    hold: float
    """[s]"""
    acc: float
    """[m/s^2]"""
    speed: float
    """[m/s]"""
    jerk_limited: bool
    """Jerk is bounded."""


def decide(
    committed: CommittedMotion,
    desired: DesiredMotion,
    choice: Choices,
    pairs: Pairs,
    params: SafeReplannerParams,
) -> tuple[CommittedMotion, Decision]:
    """Return the motion that the swarm commits to, and what else is decided."""
    bounds = _Bounds(params.hold, params.acc_max, params.speed_max, params.jerk_max > 0.0)
    rows, decision = _decided(committed.rows, desired, choice, pairs, bounds)
    return committed.with_rows(rows), decision


@compiled
def _decided(
    rows: MotionRows, desired: DesiredMotion, choice: Choices, pairs: Pairs, bounds: _Bounds
) -> tuple[MotionRows, Decision]:
    motion = _committed(rows, desired, choice, bounds.hold)
    return motion, _decision(motion, pairs, bounds)


@compiled
def _committed(rows: MotionRows, desired: DesiredMotion, choice: Choices, held: float) -> MotionRows:
    acc, hold, jerk = rows.acc.copy(), rows.hold.copy(), rows.jerk.copy()
    on_reference, pushed = rows.on_reference.copy(), np.empty(rows.hold.size, np.bool_)
    for row in range(hold.size):
        pushed[row] = choice[row] == OLD or desired.kind[row] != AS_ASKED
        if choice[row] != OLD:
            acc[row], hold[row], jerk[row] = desired.acc[row], held, desired.jerk[row]
        on_reference[row] &= not pushed[row]
    return MotionRows(rows.pos, rows.vel, acc, hold, on_reference, pushed, jerk)


@compiled
def _decision(rows: MotionRows, pairs: Pairs, bounds: _Bounds) -> Decision:
    own, acc = rows.hold.size, rows.acc.copy()
    outside = np.zeros(own, np.bool_)
    for row in range(own):
        vel = rows.vel[row]
        speed = norm(vel)
        if bounds.jerk_limited:
            outside[row] = speed > bounds.speed
        elif not rows.hold[row] > 0.0:  # it brakes
            for axis in range(3):
                acc[row, axis] = -bounds.acc * vel[axis] / (speed if speed > 0.0 else 1.0)
    for row in range(pairs.i.size):
        if bounds.jerk_limited and pairs.j[row] >= own:
            outside[pairs.i[row]] = True
    return Decision(acc, outside)
