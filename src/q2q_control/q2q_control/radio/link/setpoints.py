"""Commands and setpoints as arguments of cflib, in the Crazyflie's signs and units.

| q2q | cflib | firmware |
|---|---|---|
| phi [rad], right side down | roll [deg], the same | roll |
| theta [rad], nose down | pitch [deg], the same: cflib sends its negative | legacy pitch, nose up |
| r [rad/s], to the left | yawrate [deg/s], negative: sent as it is | RPYT yaw rate, to the right |
| U1 [N] | thrust [PWM], by the table of vehicle and firmware | the same on every motor |
| acc = acc_ref - eta [m/s^2] | acc of a full state | feed-forward of the Mellinger controller |
| body rates [rad/s] | "degrees/s" of send_full_state_setpoint, actually rad/s | mrad/s |

A full state carries 16-bit millimetres and mm/s^2: values are clipped at 32.767. The flight procedure
refuses rooms beyond that.
"""

import math
from dataclasses import dataclass

import numpy as np

from q2q_control.flight_procedure.procedure_params import FULL_STATE_RANGE
from q2q_control.radio.link.rpyt_scale import RpytScale, rpyt_rows
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    Interference,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    predicted_eta,
)


@dataclass(frozen=True, slots=True)
class RpytSetpoint:
    """Arguments of cflib's Commander.send_setpoint."""

    roll_deg: float
    pitch_deg: float
    yaw_rate_deg: float
    """To the right."""
    pwm: int


ZERO_RPYT = RpytSetpoint(0.0, 0.0, 0.0, 0)
"""Zero setpoint, which unlocks the thrust."""


@dataclass(frozen=True, slots=True)
class FullState:
    """Arguments of cflib's Commander.send_full_state_setpoint."""

    pos: tuple[float, ...]
    """[m], world."""
    vel: tuple[float, ...]
    """[m/s], world."""
    acc: tuple[float, ...]
    """[m/s^2], world."""
    quat: tuple[float, ...]
    """x y z w, body to world."""
    ang_vel: tuple[float, ...]
    """[rad/s], body."""


def rpyt_setpoints(command: SwarmCommand, scale: RpytScale) -> list[RpytSetpoint | None]:
    """Return the RPYT setpoint of every vehicle, in the order of the command; None if it is not finite."""
    finite = _finite_rows(np.column_stack([command.thrust, command.roll, command.pitch, command.yaw_rate]))
    rows = rpyt_rows(command, scale).tolist()
    return [_rpyt(row) if sound else None for row, sound in zip(rows, finite, strict=True)]


def cut_vehicles(command: SwarmCommand) -> Names:
    """Return the vehicles with status CUT."""
    return tuple(
        name for name, one in zip(command.names, command.status, strict=True) if one == CommandStatus.CUT
    )


def level_rpyt(thrust: float, scale: RpytScale) -> RpytSetpoint:
    """Return the level setpoint of a thrust [N]."""
    return RpytSetpoint(0.0, 0.0, 0.0, int(scale.rpyt_pwm_of(np.asarray(thrust))))


def full_states(setpoint: SwarmSetpoint, interference: Interference | None) -> list[FullState | None]:
    """Return the full state of every vehicle, of acceleration acc - eta; None if it is not finite."""
    eta = predicted_eta(interference, setpoint.names)
    acc = setpoint.acc - np.where(np.isfinite(eta), eta, 0.0)
    level = np.zeros(len(setpoint.names))
    quat = quat_from_euler(level, level, np.where(np.isfinite(setpoint.yaw), setpoint.yaw, 0.0))
    finite = _finite_rows(np.column_stack([setpoint.pos, setpoint.vel, acc, setpoint.yaw, setpoint.yaw_rate]))
    return [
        FullState(
            pos=_cut(setpoint.pos[k]),
            vel=_cut(setpoint.vel[k]),
            acc=_cut(acc[k]),
            quat=tuple(quat[k].tolist()),
            ang_vel=(0.0, 0.0, *_cut(setpoint.yaw_rate[k : k + 1])),
        )
        if finite[k]
        else None
        for k in range(len(setpoint.names))
    ]


def _rpyt(row: list[float]) -> RpytSetpoint:
    """Return the RPYT setpoint of pitch [deg], roll [deg], yaw rate [deg/s], thrust [PWM]."""
    pitch, roll, yaw_rate, pwm = row
    return RpytSetpoint(roll, pitch, -yaw_rate, int(pwm))


def _finite_rows(rows: Array) -> list[bool]:
    finite: list[bool] = np.asarray(np.isfinite(rows).all(axis=1)).tolist()
    return finite


def _cut(values: Array) -> tuple[float, ...]:
    return tuple(math.copysign(min(abs(one), FULL_STATE_RANGE), one) for one in values.tolist())
