"""What the mocap filter states of its own output (q2q_model.estimation.mocap_filter).

| violation | statement that it breaks |
|---|---|
| lost_moving | a vehicle with status LOST has velocity zero |
| swap_moved_track | a label swap that ends before a vehicle has coasted moves no TRACKED state |

A swap is not judged while a marker of one of its vehicles is displaced and the other vehicle is missing.
"""

import numpy as np

from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, TrackStatus
from q2q_sim.campaigns.falsification.postconditions.postcondition_outcome import (
    PostconditionOutcome,
    affected_by_kinds,
)
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks, over_ticks
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.flight_blocks import filter_params
from q2q_sim.monitors.policies import Limits, Violation
from q2q_sim.monitors.policies.exemptions.sensor_errors import RECOVERY_S

SETTLED_S = 1.0
"""Time at the start of a flight in which names may still be settled [s]."""


def lost_moving(_: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the lost vehicles that are said to move."""
    speed = np.linalg.norm(over_ticks(ticks.states, "vel"), axis=2)
    gone = over_ticks(ticks.states, "status") == TrackStatus.LOST
    moving = np.where(gone, speed, 0.0)
    k, row = np.unravel_index(int(moving.argmax()), moving.shape)
    if not moving[k, row] > 0.0:
        return PostconditionOutcome()
    return PostconditionOutcome(
        (Violation("lost_moving", ticks.names[row], float(ticks.t[k]), float(moving[k, row]), 0.0),), -1.0
    )


def swap_moved_track(run: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the tracks that a short label swap has moved; undetectable faults widen or end the judgement."""
    faults = run.scenario.faults
    swaps = [fault for fault in faults if fault.kind == "swap"]
    if any(fault.kind == "clock_jump" for fault in faults):
        return PostconditionOutcome()
    if sum(fault.duration + 2.0 * TICK_S for fault in swaps) > filter_params(run.scenario).coast_s:
        return PostconditionOutcome()
    allowed = Limits().state_error_max + sum(abs(fault.size) for fault in faults if fault.kind == "jump")
    off = _errors(ticks)
    found, margin = [], np.inf
    for fault in swaps:
        if fault.start < SETTLED_S or _ambiguous(fault, faults, ticks):
            continue
        now = (ticks.t >= fault.start) & (ticks.t <= fault.start + fault.duration + RECOVERY_S)
        for name in fault.vehicles:
            row = ticks.names.index(name)
            error = np.where(now, off[:, row], 0.0)
            k = int(error.argmax())
            margin = min(margin, float(allowed - error[k]) / allowed)
            if error[k] > allowed:
                found.append(Violation("swap_moved_track", name, float(ticks.t[k]), float(error[k]), allowed))
    return PostconditionOutcome(tuple(found), margin)


def _ambiguous(swap: Fault, faults: tuple[Fault, ...], ticks: RunTicks) -> bool:
    """Return whether a marker of one vehicle of a swap is displaced while the other is missing.

    The only sample of the two then has the name of the missing one, and is where that may have moved. A room
    loses vehicles by itself: the other is missing, too, if it was not measured in the tick before the swap.
    """
    end = swap.start + swap.duration
    now = tuple(one for one in faults if one.start <= end and one.start + one.duration >= swap.start)
    displaced = affected_by_kinds(swap.vehicles, now, ("jump",))
    missed = affected_by_kinds(swap.vehicles, now, ("dropout", "nan"))
    before = ticks.states[max(int(np.searchsorted(ticks.t, swap.start)) - 1, 0)]
    unseen = before.age[[before.names.index(name) for name in swap.vehicles]] > 0.0
    missing = missed | unseen
    return any(one and other for one, other in zip(displaced, reversed(missing), strict=True))


def _errors(ticks: RunTicks) -> Array:
    """Return the errors of TRACKED states at their own stamps [m], (T, n); 0 for other states."""
    true = over_ticks(ticks.truth, "pos")
    stamps = np.array([one.t for one in ticks.states])
    rows = np.clip(np.rint(stamps / TICK_S).astype(np.intp), 0, len(true) - 1)
    away = np.linalg.norm(over_ticks(ticks.states, "pos") - true[rows], axis=2)
    tracked = over_ticks(ticks.states, "status") == TrackStatus.TRACKED
    return np.where(tracked, away, 0.0)
