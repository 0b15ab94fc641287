"""Fallback phases of a vehicle as its newest measurement grows old.

| phase | from an age of | command | CommandStatus |
|---|---|---|---|
| ok | 0 | the controller's | OK, SATURATED |
| degraded | degraded_after_s | the controller's, on a predicted state | DEGRADED |
| hold | no usable state; or no tick for hold_after_s | the last command again | HOLD |
| level | hold_duration (last_commands); no tick for level_after_s | level or braking, hover thrust | LEVEL |
| land | land_after_s | level or braking, below hover thrust: descends | LAND |
| cut | cut_after_s, until a new flight; or an emergency, for good | motors off | CUT |

The age is the time since the newest accepted measurement, by the stamps and ages in the messages
(q2q_control.failsafe.guard), never a count of messages. The firmware's own watchdog levels after 0.5 s
without a packet and cuts after 2 s: the last resort if the controller itself has died.

A descent without measurements takes 2.8 s from 2 m: at (1 - land_share) g down to 0.8 m/s, then braked to
1.1 m/s, at which it touches down (q2q_control.failsafe.tracking_loss.braking_law). Where the ratio k of
actual to commanded thrust is not known (1.03 in real flights, q2q_sim.scenarios.room_profiles), it takes up
to sqrt(2 h / a) from a height h, at a = (1 - land_share k) g: 3.6 s from 2 m.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.nominal_tick import SOUND
from q2q_model.signals.values import Array, CommandStatus, Status, SwarmCommand


def fallback_command(
    last: SwarmCommand, age: float, params: FallbackParams, hover_thrust: float
) -> SwarmCommand:
    """Return the command while the tick after `last` is missing: held, then level.

    Args:
        last: command of the last tick.
        age: time since that tick [s].
        params: ages at which the phases change.
        hover_thrust: thrust of one vehicle at hover [N].
    """
    count = len(last.names)
    if age < params.level_after_s:
        return replace(last, t=last.t + age, status=_all(count, CommandStatus.HOLD))
    zero = np.zeros(count)
    return SwarmCommand(
        t=last.t + age,
        names=last.names,
        thrust=np.full(count, hover_thrust),
        roll=zero,
        pitch=zero,
        yaw_rate=zero,
        status=_all(count, CommandStatus.LEVEL),
    )


def repeated_command(last: SwarmCommand, t: float) -> SwarmCommand:
    """Return the last command, repeated at tick t [s] with status HOLD."""
    held = np.where(last.status <= SOUND, CommandStatus.HOLD, last.status).astype(np.uint8)
    return replace(last, t=t, status=held)


def level_where_not_finite(command: SwarmCommand, hover_thrust: float) -> SwarmCommand:
    """Return the command with level hover, and status LEVEL, where the controller's is not finite.

    Args:
        command: the controller's.
        hover_thrust: thrust of one vehicle at hover [N].
    """
    values = np.stack([command.thrust, command.roll, command.pitch, command.yaw_rate])  # (4, n)
    finite = np.isfinite(values)
    if finite.all():
        return command
    bad = ~finite.all(axis=0)
    level = np.array([[hover_thrust], [0.0], [0.0], [0.0]])
    thrust, roll, pitch, yaw_rate = np.where(bad, level, values)
    status = np.where(bad, CommandStatus.LEVEL, command.status).astype(np.uint8)
    return SwarmCommand(command.t, command.names, thrust, roll, pitch, yaw_rate, status)


def apply_land_and_cut(
    command: SwarmCommand, ages: Array, is_cut: NDArray[np.bool_], params: FallbackParams, hover_thrust: float
) -> SwarmCommand:
    """Return the command with vehicles landing or cut whose measurement is too old.

    Args:
        command: command before this fallback.
        ages: age of each vehicle's measurement [s], (n,).
        is_cut: vehicles whose motors are off permanently, (n,).
        params: ages at which the phases change.
        hover_thrust: thrust of one vehicle at hover [N].
    """
    landing = ~(ages < params.land_after_s)  # NaN too
    if not (landing.any() or is_cut.any()):
        return command
    still = landing | is_cut
    sinking = np.where(landing, params.land_share * hover_thrust, command.thrust)
    status = np.where(landing, CommandStatus.LAND, command.status)
    return SwarmCommand(
        t=command.t,
        names=command.names,
        thrust=np.where(is_cut, 0.0, sinking),
        roll=np.where(still, 0.0, command.roll),
        pitch=np.where(still, 0.0, command.pitch),
        yaw_rate=np.where(still, 0.0, command.yaw_rate),
        status=np.where(is_cut, CommandStatus.CUT, status).astype(np.uint8),
    )


def _all(count: int, status: CommandStatus) -> Status:
    return np.full(count, status, dtype=np.uint8)
