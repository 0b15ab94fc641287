"""Motions of bounded jerk: a jerk held for a time, then the fastest stop of every axis.

An axis of velocity v and acceleration a stops fastest, within |r''| <= A and |r'''| <= J, by the jerks
-J, 0, J (mirrored where v + a |a| / (2 J), the velocity left once the acceleration is zero, is negative):

    p   = min(max(A, -a), sqrt(J v + a^2 / 2))
    t_1 = (a + p) / J,    t_2 = (J v + a^2 / 2 - p^2) / (J p),    t_3 = p / J

The rest of a fastest stop is itself a fastest stop, so a motion continues from any of its states. Of two that
start with the same acceleration, velocities never part further, as those of `braking` never do.

| symbol | name | meaning [unit] |
|---|---|---|
| A, J | law.brake, law.jerk | largest acceleration [m/s^2] and jerk [m/s^3] of an axis |
| p | peak | largest deceleration of a stop [m/s^2] |
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import BORROWING, HOT, compiled
from q2q_model.signals.values import Array
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions

ROUNDING = 1e-9
"""Of a speed that is computed in several ways, as a share of it [-]."""

Axis = tuple[float, float, float]
"""Position [m], velocity [m/s] and acceleration [m/s^2] of one axis."""


class AxisMotion(NamedTuple):
    """One axis of a motion: a held jerk, then the fastest stop."""

    start: Axis
    jerk: float
    """Held [m/s^3]."""
    hold: float
    """[s]"""
    held: Axis
    """As the stop begins."""
    sign: float
    """Of the velocity that is stopped."""
    first: float
    """t_1 of the stop [s]."""
    even: float
    """t_2 [s]"""
    last: float
    """t_3 [s]"""


class StoppingMotions(NamedTuple):
    """Motions and the phases of their stops, which many proofs share."""

    motions: Motions
    phases: Array
    """Sign of the velocity that is stopped [-], and t_1, t_2, t_3 [s], of each axis, (n, 3 axes, 4)."""


ThreeAxisMotion = tuple[AxisMotion, AxisMotion, AxisMotion]
"""x, y and z of a motion."""


@compiled
def _held(start: Axis, jerk: float, s: float) -> Axis:
    """Return an axis after a jerk [m/s^3] held for s [s]."""
    pos, vel, acc = start
    there = pos + s * (vel + s * (0.5 * acc + s * jerk / 6.0))
    return there, vel + s * (acc + 0.5 * s * jerk), acc + s * jerk


@compiled
def _stop_phases(vel: float, acc: float, law: BrakingLaw) -> tuple[float, float, float, float]:
    """Return the sign of the velocity to be stopped, and the durations t_1, t_2, t_3 of the stop [s]."""
    sign = 1.0 if vel + 0.5 * acc * abs(acc) / law.jerk >= 0.0 else -1.0
    v, a = sign * vel, sign * acc
    square = max(law.jerk * v + 0.5 * a * a, 0.0)
    peak = min(max(law.brake, -a), np.sqrt(square))
    if peak == 0.0:  # the last part of a stop: the acceleration alone is left
        return sign, max(0.0, a / law.jerk), 0.0, 0.0
    even = max(0.0, (square - peak * peak) / (law.jerk * peak))
    return sign, max(0.0, (a + peak) / law.jerk), even, peak / law.jerk


@compiled(**HOT)
def _stopped(motion: AxisMotion, s: float, law: BrakingLaw) -> Axis:
    """Return an axis s [s] after the beginning of its stop."""
    state, push = motion.held, motion.sign * law.jerk
    for jerk, span in ((-push, motion.first), (0.0, motion.even), (push, motion.last)):
        step = min(s, span)
        state = _held(state, jerk, step)
        s -= step
        if s <= 0.0:
            return state
    return state[0], 0.0, 0.0


@compiled
def with_stops(motions: Motions, law: BrakingLaw) -> StoppingMotions:
    """Return motions with the phases of their stops; a law that does not bound jerk has none, (0, 3, 4)."""
    phases = np.empty((motions.hold.size if law.jerk > 0.0 else 0, 3, 4))
    for row in range(len(phases)):
        for axis in range(3):
            start = motions.pos[row, axis], motions.vel[row, axis], motions.acc[row, axis]
            _, vel, acc = _held(start, motions.jerk[row, axis], motions.hold[row])
            for k, phase in enumerate(_stop_phases(vel, acc, law)):
                phases[row, axis, k] = phase
    return StoppingMotions(motions, phases)


@compiled(**HOT)
def _axis_motion(stopping: StoppingMotions, row: int, axis: int) -> AxisMotion:
    """Return one axis of a motion."""
    motions, phases = stopping
    start = motions.pos[row, axis], motions.vel[row, axis], motions.acc[row, axis]
    held = _held(start, motions.jerk[row, axis], motions.hold[row])
    sign, first = phases[row, axis, 0], phases[row, axis, 1]
    even, last = phases[row, axis, 2], phases[row, axis, 3]
    return AxisMotion(start, motions.jerk[row, axis], motions.hold[row], held, sign, first, even, last)


@compiled(**HOT)
def axis_at(motion: AxisMotion, s: float, law: BrakingLaw) -> Axis:
    """Return one axis of a motion at time s [s] since its start."""
    if s > motion.hold:
        return _stopped(motion, s - motion.hold, law)
    return _held(motion.start, motion.jerk, s)


@compiled(**HOT)
def stopped_height(start: Axis, jerk: float, hold: float, law: BrakingLaw) -> float:
    """Return where an axis rests [m] that holds a jerk [m/s^3] for `hold` [s] and then stops."""
    held = _held(start, jerk, hold)
    sign, first, even, last = _stop_phases(held[1], held[2], law)
    motion = AxisMotion(start, jerk, hold, held, sign, first, even, last)
    return _stopped(motion, first + even + last, law)[0]


@compiled(**HOT)
def axes_of(stopping: StoppingMotions, row: int) -> ThreeAxisMotion:
    """Return x, y and z of the motion of a row."""
    return _axis_motion(stopping, row, 0), _axis_motion(stopping, row, 1), _axis_motion(stopping, row, 2)


@compiled(**HOT)
def rest_of(axes: ThreeAxisMotion) -> float:
    """Return the time since its start at which a motion rests [s]."""
    longest = 0.0
    for motion in axes:
        longest = max(longest, motion.first + motion.even + motion.last)
    return float(axes[0].hold + longest)


@compiled(**BORROWING)
def rest_time(stopping: StoppingMotions, row: int) -> float:
    """Return the time since its start at which the motion of a row rests [s]."""
    return rest_of(axes_of(stopping, row))


@compiled(**BORROWING)
def acceleration_bound(motions: Motions, row: int, law: BrakingLaw) -> float:
    """Return a bound of |r''| of the motion of a row [m/s^2]."""
    square = 0.0
    for axis in range(3):
        acc = motions.acc[row, axis]
        then = acc + motions.jerk[row, axis] * motions.hold[row]
        square += max(law.brake, abs(acc), abs(then)) ** 2
    return float(np.sqrt(square))


@compiled
def rest_delay(rate: float, law: BrakingLaw) -> float:
    """Return by how much later [s] a vehicle may rest whose velocity is known within `rate` [m/s]."""
    return float(rate / law.brake + 2.0 * np.sqrt(rate / law.jerk))


@compiled
def stop_reach(stopping: StoppingMotions, law: BrakingLaw, longest: float) -> Array:
    """Return a bound of how far each row moves until rest, with growth until `longest` [s] [m], (rows,)."""
    motions = stopping.motions
    reach = np.empty(motions.hold.size)
    late = longest + rest_delay(motions.growth[:, 1].max(), law)
    for row in range(motions.hold.size):
        most, growth = acceleration_bound(motions, row, law), motions.growth[row]
        x, y, z = motions.vel[row, 0], motions.vel[row, 1], motions.vel[row, 2]
        speed = np.sqrt(x * x + y * y + z * z) + most * (motions.hold[row] + most / law.jerk)
        reach[row] = speed * rest_time(stopping, row) + growth[0] + 2.0 * growth[1] * late
    return reach


@compiled(**HOT)
def speed_bound(vel: Array, acc: Array, jerk: Array, row: int, held: tuple[float, float]) -> float:
    """Return a bound of the speed of a row's motion [m/s]: the largest of each axis, whenever it is reached.

    `vel`, `acc` and the held `jerk` are (n, 3) [m/s, m/s^2, m/s^3]. `held` is the time for which the jerk is
    held [s], and the largest jerk of the stop [m/s^3]. The bound of the rest of a motion is no larger.
    """
    square = 0.0
    for axis in range(3):
        square += _axis_speed(vel[row, axis], acc[row, axis], jerk[row, axis], held) ** 2
    return float(np.sqrt(square))


@compiled(**HOT)
def _axis_speed(vel: float, acc: float, jerk: float, held: tuple[float, float]) -> float:
    """Return the largest speed of an axis until it rests [m/s]."""
    hold, most = held
    if acc == 0.0 and jerk == 0.0:
        return abs(vel)
    _, then, left = _held((0.0, vel, acc), jerk, hold)
    top = max(abs(then), abs(then + 0.5 * left * abs(left) / most))
    if acc * left < 0.0:  # it turns while jerk is held
        top = max(top, abs(vel - 0.5 * acc * acc / jerk))
    return max(abs(vel), (1.0 + ROUNDING) * top)


@compiled
def jerk_limited_motion_after(motions: Motions, s: float, law: BrakingLaw) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration (n, 3) of n motions at time s [s]."""
    pos, vel, acc = np.empty_like(motions.pos), np.empty_like(motions.pos), np.empty_like(motions.pos)
    stopping = with_stops(motions, law)
    for row in range(motions.hold.size):
        for axis in range(3):
            state = axis_at(_axis_motion(stopping, row, axis), s, law)
            pos[row, axis], vel[row, axis], acc[row, axis] = state
    return pos, vel, acc


@compiled
def jerk_towards(desired: Array, acc: Array, lag: float, most: float) -> Array:
    """Return the jerk that brings `acc` to `desired` with a lag [s], (n, 3) each [m/s^3, m/s^2].

    That of each axis is bounded by `most` [m/s^3].
    """
    jerk = (desired - acc) / lag
    for row in range(len(jerk)):
        for axis in range(3):
            if abs(jerk[row, axis]) > most:
                jerk[row, axis] = np.copysign(most, jerk[row, axis])
    return jerk
