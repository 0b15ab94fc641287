"""Error of the modified trajectories against their references.

The potential field integrates the error e = r~ - r of the modified trajectory r~ against the reference r, so
that e = 0 is the reference bit for bit. Between two ticks, which may be far apart, the reference is the cubic
through positions and velocities of both.
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.signals.values import Array, Mask, Names, SetpointStatus, SwarmSetpoint, rows_by_name

SHIFT_TOLERANCE = 1e-3
"""Shift above which a vehicle's status is SHIFTED [m]: below VICON's dynamic error of 2 mm."""

SETTLE_TOLERANCE = 1e-6
"""Error below which, without repulsion, it is set to zero [m, m/s], so that the reference returns exactly."""


@dataclass(frozen=True, slots=True)
class SetpointError:
    """Error e and its derivative, one row per vehicle."""

    names: Names
    pos: Array
    """r~ - r [m], (n, 3)."""
    vel: Array
    """Its derivative [m/s], (n, 3)."""


def no_error(names: Names) -> SetpointError:
    """Return the error of a swarm on its reference."""
    return SetpointError(names, np.zeros((len(names), 3)), np.zeros((len(names), 3)))


def match_error_rows(error: SetpointError, names: Names) -> SetpointError:
    """Return the error with the rows of `names`; a new vehicle starts on its reference."""
    if error.names == names:
        return error
    pos, vel = (rows_by_name(part, error.names, names) for part in (error.pos, error.vel))
    return SetpointError(names, pos, vel)


def settle(error: SetpointError, pushed: Mask) -> SetpointError:
    """Return the error, set to zero where it is small and not pushed (n,)."""
    largest = np.maximum(np.abs(error.pos), np.abs(error.vel)).max(axis=1)
    rest = ((largest < SETTLE_TOLERANCE) & ~pushed)[:, None]
    if not rest.any():
        return error
    return SetpointError(error.names, np.where(rest, 0.0, error.pos), np.where(rest, 0.0, error.vel))


def shift_reference(setpoint: SwarmSetpoint, error: SetpointError, acc: Array) -> SwarmSetpoint:
    """Return the reference shifted by the error and its acceleration `acc` [m/s^2], (n, 3).

    If both are exactly zero for all vehicles it is the reference object itself.
    """
    if not (error.pos.any() or error.vel.any() or acc.any()):
        return setpoint
    moved = np.linalg.norm(error.pos, axis=1) > SHIFT_TOLERANCE
    status = np.where(moved, np.uint8(SetpointStatus.SHIFTED), setpoint.status)
    return replace(
        setpoint,
        pos=setpoint.pos + error.pos,
        vel=setpoint.vel + error.vel,
        acc=setpoint.acc + acc,
        status=status.astype(np.uint8),
    )


def reference_between(before: SwarmSetpoint, after: SwarmSetpoint, share: float) -> Array:
    """Return the reference position [m], (n, 3), at a share (0 to 1) of the time between two ticks."""
    span = after.t - before.t
    rest = 1.0 - share
    return np.asarray(
        (1.0 + 2.0 * share) * rest**2 * before.pos
        + share**2 * (3.0 - 2.0 * share) * after.pos
        + span * share * rest * (rest * before.vel - share * after.vel)
    )
