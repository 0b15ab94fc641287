"""What hides from dead reckoning: ticks at which no guard can know a motion without measurements.

| fault | a motion is not known |
|---|---|
| jump, swap | if it was last measured during one, or less than RECOVERY_S after its end |
| clock_jump, radio_loss | if one acted since its last measurement, or less than RECOVERY_S before it |
| late, stale | if it was last measured with the velocity of an earlier frame |
| weak_rotor | from the change of a rotor on, unless measured for LEARNT_S since then |
| none, but the controller ignores the downwash | from a push of PUSH after its last measurement on |
| none | once blown since its last measurement; in another air than the scenario's, once tilted, too |

Blown is a vehicle whose velocity gusts have changed by BLOWN; a gust counts by what it differs from the push
that the observer of dead reckoning had learned when the vehicle was last measured (learned_push), until the
command takes effect. Tilted is one below another, by its wake.
Jumps of the clock may add up: each counts as longer by the sum of their sizes on both ends.
"""

import math

import numpy as np
from scipy.signal import lfilter

from q2q_control.failsafe.tracking_loss.dead_reckoning import LAG_S, OBSERVER
from q2q_model.flights.masks_over_time import last_row
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, Mask, Rows
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks, over_ticks
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.faults.affected_vehicles import affected_vehicles
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.scenario_air import ambient_of_scenario
from q2q_sim.monitors.policies.exemptions.sensor_errors import RECOVERY_S
from q2q_sim.monitors.policies.exemptions.unpredicted_downwash import PUSH

OF_SENSORS = ("jump", "swap")
"""Faults that mislead the last measurement."""
OF_MOTION = ("clock_jump", "radio_loss")
"""Faults that mislead dead reckoning from it, too: times or commands are not those reckoned with."""
BLOWN = 0.15
"""Velocity by gusts from which a motion is not known [m/s]: half of what the reckoned one may be wrong by."""
IN_WAKE = 0.25
"""Horizontal distance from one above within which its wake tilts a vehicle [m]: that of its edge, 0.06, and
what its axis may be carried away by."""
LEARNT_S = 1.5
"""Time in which 95 % of a trim is learned [s]: three of the observer's time constants, horizontally."""


def last_measured(ticks: RunTicks) -> Rows:
    """Return the tick of the last measurement of each vehicle, by a frame that does not repeat, (T, n)."""
    repeated = np.diff(ticks.stamp, prepend=math.nan) == 0.0
    measured = (over_ticks(ticks.states, "age") <= 0.0) & ~repeated[:, None]
    return np.maximum(last_row(measured), 0)


def misleading_measurement(ticks: RunTicks, faults: tuple[Fault, ...]) -> Mask:
    """Return where position and velocity by the last measurement may be wrong, (T, n)."""
    t, seen = ticks.t[:, None], ticks.t[last_measured(ticks)]
    jumps = sum(abs(fault.size) for fault in faults if fault.kind == "clock_jump")
    mask = np.zeros(seen.shape, dtype=np.bool_)
    for fault in faults:
        if fault.kind in OF_SENSORS + OF_MOTION:
            until = seen if fault.kind in OF_SENSORS else t
            shift = jumps if fault.kind == "clock_jump" else 0.0
            begin, end = fault.start - shift - TICK_S, fault.start + fault.duration + shift
            mask |= affected_vehicles(fault, ticks.names) & (until >= begin) & (seen <= end + RECOVERY_S)
    return mask


def after_late_frame(ticks: RunTicks, faults: tuple[Fault, ...]) -> Mask:
    """Return where the last frame came late, or again, with the velocity of then, (T, n)."""
    seen = ticks.t[last_measured(ticks)]
    mask = np.zeros(seen.shape, dtype=np.bool_)
    for fault in faults:
        if fault.kind in ("late", "stale"):
            end = fault.start + fault.duration + fault.size
            mask |= (seen >= fault.start - TICK_S) & (seen <= end)
    return mask


def after_rotor_change(ticks: RunTicks, faults: tuple[Fault, ...]) -> Mask:
    """Return where a rotor weakened or recovered after, or shortly before, the last measurement, (T, n)."""
    t, seen = ticks.t[:, None], ticks.t[last_measured(ticks)]
    mask = np.zeros(seen.shape, dtype=np.bool_)
    for fault in faults:
        if fault.kind == "weak_rotor":
            for change in (fault.start, fault.start + fault.duration):
                mask |= affected_vehicles(fault, ticks.names) & (t >= change) & (seen < change + LEARNT_S)
    return mask


def in_ignored_downwash(ticks: RunTicks, *, aware: bool) -> Mask:
    """Return where a downwash that the controller ignores has pushed since the last measurement, (T, n)."""
    if aware:
        return np.zeros((len(ticks.t), len(ticks.names)), dtype=np.bool_)
    pushed = np.linalg.norm(over_ticks(ticks.pushes, "acc"), axis=2) > PUSH
    return np.asarray(last_row(pushed) > last_measured(ticks))


def hidden_by_air(run: Run, ticks: RunTicks) -> Mask:
    """Return where gusts hide a motion, (T, n).

    In another air than the scenario's the torque of a wake hides it, too.
    """
    last, t = last_measured(ticks), np.arange(len(ticks.t))[:, None]
    effect = np.minimum(t + round(LAG_S / TICK_S), t[-1])
    push = _unpredicted_push(run, ticks)
    gained = TICK_S * np.cumsum(push, axis=0)
    seen, learned = (np.take_along_axis(one, last[..., None], axis=0) for one in (gained, learned_push(push)))
    unknown = gained[effect[:, 0]] - seen - TICK_S * learned * (effect - last)[..., None]
    blown = np.asarray(np.linalg.norm(unknown, axis=2) > BLOWN)
    if not run.scenario.air:
        return blown
    tilted = last_row(_below_another(over_ticks(ticks.truth, "pos"))) >= last
    return np.asarray(blown | tilted)


def _unpredicted_push(run: Run, ticks: RunTicks) -> Array:
    """Return what pushes the vehicles and is not predicted, horizontal [m/s^2], (T, n, 2).

    In another air it is all that is recorded as its push, in the scenario's own its gusts, which are not
    recorded: they are drawn again.
    """
    if run.scenario.air:
        return over_ticks(ticks.pushes, "acc")[..., :2]
    ambient = ambient_of_scenario(run.scenario, run.seed)
    return np.stack([ambient.drive()[:, :2] for _ in ticks.t])


def learned_push(push: Array) -> Array:
    """Return what an observer of two poles at OBSERVER knows of a push (T, n, 2), horizontal [m/s^2]."""
    pole = math.exp(-OBSERVER[0] * TICK_S)
    return np.asarray(lfilter([(1.0 - pole) ** 2], [1.0, -2.0 * pole, pole**2], push, axis=0))


def _below_another(pos: Array) -> Mask:
    """Return which vehicles at pos (T, n, 3) are below another, within IN_WAKE of its axis, (T, n)."""
    away = pos[:, None] - pos[:, :, None]  # (T, n, m, 3): m from n
    near = np.hypot(away[..., 0], away[..., 1]) < IN_WAKE
    return np.asarray((near & (away[..., 2] > 0.0)).any(axis=2))
