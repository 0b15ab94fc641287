"""What the safe replanner states of its own setpoints (q2q_planner.online.safe.safe_replanner).

| violation | statement that it breaks |
|---|---|
| promise | setpoints without PROMISE_BROKEN are out of each other's zone |
| stop_enters_zone | they are also while their vehicles stop from there, within the bounds of the replanner |
| off_path_unreported | a vehicle measured outside the tube of its setpoint is PROMISE_BROKEN |
| acc_held_too_long | an acceleration is flown for `hold`, then the vehicle brakes or has a new one |
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.stamps import SAME_STAMP, TICK_S
from q2q_model.signals.values import Array, Mask, SetpointStatus, SwarmSetpoint
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions, motion_after
from q2q_planner.online.safe.stopping.jerk_limited import jerk_limited_motion_after
from q2q_sim.campaigns.falsification.postconditions.postcondition_outcome import PostconditionOutcome
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks, over_ticks
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.loop.flight_blocks import safe_replanner_params
from q2q_sim.monitors.policies import Violation

STOPS_EVERY = 5
"""Ticks between setpoints from which stops are judged."""
STOP_S = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0)
"""Times after the beginning of a stop [s]: from 2.5 m/s it takes 1.4 s."""
STOP_SLACK = 0.01
"""The replanner goes on with an acceleration for up to `hold` before it stops [m]: 2 m/s^2 within 0.1 s."""
SLACK = 1e-3
"""Rounding and snapping of setpoints [m]."""
STILL = 1e-3
"""Accelerations that count as none, and their distance from the limit [m/s^2]: limited ones may be equal."""


class _Nearest(NamedTuple):
    """Tick of smallest distance from the zone [m]."""

    distance: float
    t: float


def promise(run: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the deepest unreported entry of setpoints into the zone; the margin counts reported ones too."""
    if run.options.replan != "safe":
        return PostconditionOutcome()
    params = safe_replanner_params(run.scenario)
    zone = Cylinder(params.eps, params.d)
    pos, kept = over_ticks(ticks.setpoints, "pos"), _kept(ticks.setpoints)
    silent = _nearest(zone, ticks.setpoints, pos, kept)
    every = _nearest(zone, ticks.setpoints, pos, np.ones_like(kept))
    bad = [Violation("promise", "the replanner", silent.t, silent.distance, 0.0)]
    return PostconditionOutcome(tuple(bad if silent.distance < 0.0 else ()), every.distance / params.eps)


def _kept(setpoints: Sequence[SwarmSetpoint]) -> Mask:
    """Return which setpoints are without PROMISE_BROKEN, (T, n)."""
    return np.asarray(over_ticks(setpoints, "status") != SetpointStatus.PROMISE_BROKEN)


def _nearest(zone: Cylinder, setpoints: Sequence[SwarmSetpoint], pos: Array, kept: Mask) -> _Nearest:
    """Return where two kept vehicles at `pos` (T, n, 3) are deepest in each other's zone."""
    apart = zone.signed_distance(pos[:, None] - pos[:, :, None])  # (T, n, n)
    pairs = kept[:, None] & kept[:, :, None] & ~np.eye(pos.shape[1], dtype=np.bool_)
    least = np.where(pairs, apart, np.inf).min(axis=(1, 2))
    k = int(least.argmin())
    return _Nearest(float(least[k]), setpoints[k].t)


def stop_enters_zone(run: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the deepest entry into the zone of two vehicles that stop from setpoints without a report."""
    if run.options.replan != "safe":
        return PostconditionOutcome()
    params = safe_replanner_params(run.scenario)
    zone = Cylinder(params.eps, params.d)
    law = BrakingLaw(params.eps, params.d, params.acc_max, params.jerk_max)
    judged = ticks.setpoints[::STOPS_EVERY]
    motions, kept = _stopping(judged), _kept(judged)
    least = min(
        _nearest(zone, judged, _stopped(motions, s, law).reshape(*kept.shape, 3), kept) for s in STOP_S
    )
    bad = least.distance < -STOP_SLACK
    found = (
        (Violation("stop_enters_zone", "the replanner", least.t, least.distance, -STOP_SLACK),) if bad else ()
    )
    return PostconditionOutcome(found, (least.distance + STOP_SLACK) / params.eps)


def _stopping(setpoints: Sequence[SwarmSetpoint]) -> Motions:
    """Return the motions of vehicles that begin to stop at their setpoints, tick by tick (T n)."""
    pos = np.concatenate([one.pos for one in setpoints])
    vel = np.concatenate([one.vel for one in setpoints])
    acc = np.concatenate([one.acc for one in setpoints])
    n = len(pos)
    return Motions(pos, vel, acc, hold=np.zeros(n), growth=np.zeros((n, 2)), jerk=np.zeros_like(pos))


def _stopped(motions: Motions, s: float, law: BrakingLaw) -> Array:
    """Return the positions of motions after s [s], [m], (n, 3)."""
    if law.jerk > 0.0:
        return jerk_limited_motion_after(motions, s, law)[0]
    return motion_after(motions, s, law.brake)[0]


def off_path_unreported(run: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the vehicles measured off their setpoints without a report."""
    if run.options.replan != "safe":
        return PostconditionOutcome()
    params = safe_replanner_params(run.scenario)
    measured = over_ticks(ticks.states, "age") <= 0.0
    off = over_ticks(ticks.states, "pos") - over_ticks(ticks.setpoints, "pos")
    outside = _outside(off, params.tracking, params.tracking_z)
    silent = np.where(measured & ticks.newer[:, None] & _kept(ticks.setpoints), outside, 0.0)
    k, row = np.unravel_index(int(silent.argmax()), silent.shape)
    if silent[k, row] <= SLACK:
        return PostconditionOutcome()
    who, t = ticks.names[row], float(ticks.t[k])
    return PostconditionOutcome(
        (Violation("off_path_unreported", who, t, float(silent[k, row]), SLACK),), -1.0
    )


def _outside(off: Array, tracking: float, tracking_z: float) -> Array:
    """Return how far distances `off` (T, n, 3) from the setpoint are outside the tube [m], (T, n).

    It is a ball of `tracking`; where `tracking_z` is not 0, a cylinder as wide, and so high.
    """
    if tracking_z == 0.0:
        return np.asarray(np.linalg.norm(off, axis=2) - tracking)
    beside, above = np.linalg.norm(off[..., :2], axis=2) - tracking, np.abs(off[..., 2]) - tracking_z
    return np.asarray(np.maximum(beside, above))


def acc_held_too_long(run: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the vehicles that move with one acceleration for longer than `hold`.

    Late frames, and those of a clock set back until that is known, get the newest setpoint again: no time
    passes for its motion.
    """
    if run.options.replan != "safe":
        return PostconditionOutcome()
    params = safe_replanner_params(run.scenario)
    ticks_held = round(params.hold / TICK_S)
    pos, acc = over_ticks(ticks.setpoints, "pos"), over_ticks(ticks.setpoints, "acc")
    size = np.linalg.norm(acc, axis=2)
    free = (size > STILL) & (size < params.acc_max - STILL)
    in_order = np.abs(np.diff(ticks.stamp) - TICK_S) < SAME_STAMP  # a clock that jumps makes shorter ticks
    same = (acc[1:] == acc[:-1]).all(axis=2) & in_order[:, None] & free[1:]  # (T - 1, n)
    moves = (pos[1:] != pos[:-1]).any(axis=2)
    shifted = over_ticks(ticks.setpoints, "status")[1:] != SetpointStatus.NOMINAL
    windows = np.lib.stride_tricks.sliding_window_view(same & moves & shifted, ticks_held, axis=0)
    held = np.asarray(windows.all(axis=2))
    return PostconditionOutcome(
        tuple(
            Violation(
                "acc_held_too_long",
                name,
                float(ticks.t[held[:, row].argmax()]),
                float(held[:, row].sum()),
                0.0,
            )
            for row, name in enumerate(ticks.names)
            if held[:, row].any()
        )
    )
