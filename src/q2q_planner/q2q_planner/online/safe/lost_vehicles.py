"""Vehicles that are not where their motion is: it is reset to where they are measured.

A vehicle without measurements brakes and sinks (q2q_control.failsafe), while its modified trajectory goes on.
Measured again, it would be pulled to a setpoint metres away, past others, faster than any motion that was
proven. Its motion is therefore reset to its measured position and velocity, and leads back from there. It
sinks no faster than it can stop above the floor, z = 0: sent below that, one would stand there and lean.

So does that of a vehicle that was measured all the time and is far from its modified trajectory, as one that
evades another which falls (q2q_control.failsafe.evasion): others would be led past its setpoint, through it.
One on its reference stays there, as that may jump.

At the first tick of a replanner, which may have been started again in flight, and at the first one after a
gap (LONGEST_GAP), every tracked vehicle that is off its reference starts where it is: it may be on the way
around another, whom its reference leads through.
"""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, Mask, Names, SwarmState, TrackStatus, rows_by_name
from q2q_planner.online.last_known_states import KnownStates
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion, MotionRows
from q2q_planner.online.safe.motion.motion_propagation import up_to
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.vectors import distance

COAST_S = MocapFilterParams().coast_s
"""Age of a measurement beyond which a controller does not fly a vehicle [s]."""
FRESH_S = TICK_S
"""Age of a measurement that is of this tick or the last one [s]."""
LEFT_BEHIND = 0.5
"""Distance of a measured vehicle from its motion beyond which the proof says nothing about it [m]."""


class LostVehicles:
    """Vehicles of a swarm that were lost at the last tick, and when each was measured."""

    def __init__(self) -> None:
        self._names: Names = ()
        self._lost: Mask = np.zeros(0, np.bool_)
        self._measured_at = np.zeros(0)  # or its first tick, of one that was never measured [s]

    def set_back(self, by: float) -> None:
        """Date measurements by a clock that was set back [s]."""
        self._measured_at = self._measured_at - by

    def found(self, known: KnownStates, t: float) -> Mask:
        """Return the vehicles that were lost and are measured now, at t [s], (n,)."""
        before = self._lost
        if known.names != self._names:
            before = rows_by_name(before, self._names, known.names)
            self._measured_at = rows_by_name(self._measured_at, self._names, known.names, t)
        self._names, self._lost = known.names, np.empty_like(before)
        self._measured_at = np.maximum(self._measured_at, t - known.age)
        return _found(known.age, before, self._lost)

    def forgotten(self, t: float, oldest: float) -> Mask:
        """Return which vehicles of the last `found` were not measured for longer than `oldest` [s], (n,)."""
        return np.asarray(t - self._measured_at > oldest)


@compiled
def _found(age: Array, before: Mask, lost: Mask) -> Mask:
    """Return who was lost before and is measured now, (n,); write who is lost now, (n,)."""
    fresh = age <= FRESH_S
    # never measured is not lost: a vehicle begins on its reference
    lost[:] = (age > COAST_S) & np.isfinite(age) | before & ~fresh
    return before & fresh


def tracked_now(state: SwarmState, names: Names) -> Mask:
    """Return which of the named vehicles are tracked, (n,): none by a filter's first frame, which may lie."""
    status = rows_by_name(state.status, state.names, names, TrackStatus.LOST)
    return np.asarray(status == TrackStatus.TRACKED)


def far_from_motion(committed: CommittedMotion, known: KnownStates) -> Mask:
    """Return which vehicles off the reference are measured too far from their motion, (n,)."""
    return _left_behind(committed.rows.pos, committed.rows.on_reference, known.pos, known.age)


@compiled
def _left_behind(motion: Array, on_reference: Mask, pos: Array, age: Array) -> Mask:
    left = np.empty(age.size, np.bool_)
    for row in range(age.size):
        far = distance(motion, pos, row) > LEFT_BEHIND
        left[row] = far and age[row] <= FRESH_S and not on_reference[row]
    return left


def restart_motion(
    committed: CommittedMotion, known: KnownStates, found: Mask, params: SafeReplannerParams
) -> CommittedMotion:
    """Return the motion with `found` vehicles, (n,), where they are measured, at most at speed_max."""
    if not found.any():
        return committed
    col, still, rows = found[:, None], np.zeros((len(found), 3)), committed.rows
    restarted = MotionRows(
        pos=np.where(col, known.pos, rows.pos),
        vel=np.where(col, _bounded(known, params), rows.vel),
        acc=np.where(col, still, rows.acc),
        hold=np.where(found, 0.0, rows.hold),
        on_reference=rows.on_reference & ~found,
        pushed=rows.pushed & ~found,
        jerk=np.where(col, still, rows.jerk),
    )
    return committed.with_rows(restarted)


def _bounded(known: KnownStates, params: SafeReplannerParams) -> Array:
    vel = up_to(known.vel, params.speed_max)
    fastest = np.sqrt(2.0 * params.acc_max * np.maximum(known.pos[:, 2], 0.0))
    vel[:, 2] = np.maximum(vel[:, 2], -fastest)
    return vel
