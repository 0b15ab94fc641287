"""Setpoint in words: the axes that it controls."""

import math

from q2q_model.signals.values import Three
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint


def asked_position(one: Setpoint) -> Three | None:
    """Return the position that is asked for [m], world, NaN on axes that are not; None if none is."""
    if Mode.ABS not in (one.x, one.y, one.z):
        return None
    modes = (one.x, one.y, one.z)
    x, y, z = (v if mode == Mode.ABS else math.nan for v, mode in zip(one.pos, modes, strict=True))
    return x, y, z


def setpoint_text(one: Setpoint) -> str:
    """Return the controlled axes of a setpoint in words; its yaw and yaw rate unless they are 0."""
    parts = []
    for axis, mode, pos, vel in zip("xyz", (one.x, one.y, one.z), one.pos, one.vel, strict=True):
        if mode == Mode.ABS:
            parts.append(f"{axis} {pos:.2f} m")
        elif mode == Mode.VELOCITY:
            parts.append(f"v{axis} {vel:.2f} m/s")
    if one.z == Mode.DISABLE:
        parts.append(f"thrust {one.thrust_pwm:.0f}")
    if Mode.DISABLE not in (one.roll, one.pitch):
        parts.append(f"roll {one.attitude_deg[0]:.1f} and pitch {one.attitude_deg[1]:.1f} deg")
    return f"setpoint {', '.join([*parts, *_yaw(one)])}"


def _yaw(one: Setpoint) -> list[str]:
    """Return the yaw and the yaw rate (of a full state: that next to its attitude), unless they are 0."""
    yaw, rate = one.attitude_deg[2], one.rate_deg[2]
    if one.yaw == Mode.ABS and yaw != 0.0:
        return [f"yaw {yaw:.0f} deg"]
    is_turned = one.yaw == Mode.VELOCITY or one.quat == Mode.ABS
    return [f"yaw rate {rate:.0f} deg/s"] if is_turned and rate != 0.0 else []
