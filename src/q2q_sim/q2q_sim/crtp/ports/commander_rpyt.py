"""Port 3: RPYT setpoints (roll, pitch, yaw rate, thrust).

Source: firmware: modules/src/crtp_commander_rpyt.c. Three floats and a uint16:

| field | meaning |
|---|---|
| roll | [deg], right side down |
| pitch | [deg], *legacy*: nose up; cflib's send_setpoint turns the sign: its pitch is nose down |
| yaw | rate [deg/s], *inverted*: positive turns right |
| thrust | 0, or 1000 to 60000 [PWM]; locked at 0 until a packet with thrust 0 has arrived |

The flightmode parameters change what the fields mean, as in the firmware: stabModeRoll and stabModePitch
(0: rates [deg/s]), stabModeYaw (1: angle, not inverted), althold (thrust is a climb rate), poshold (pitch and
roll are velocities), posSet (-pitch, roll, thrust / 1000 are a position). A packet overwrites the client's
last setpoint of any port and keeps the fields it does not carry: after a hover packet, poshold velocities are
in the body frame.
"""

import struct
from dataclasses import replace
from typing import NamedTuple

from q2q_model.vehicle.thrust_map import RPYT_PWM_MAX, RPYT_PWM_MIN
from q2q_sim.crtp.packets.fields import read_fields
from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.firmware.commander.commander import Priority
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.parameters.parameter_values import Parameters

_FIELDS = struct.Struct("<fffH")
MIDDLE = 32767.0
"""Thrust of zero climb rate under althold; twice it is 1 m/s."""
ANGLE_PER_SPEED = 30.0
"""Angle for 1 m/s under poshold [deg]."""


class Rpyt(NamedTuple):
    """Fields of an RPYT setpoint, as sent."""

    roll: float
    pitch: float
    yaw: float
    thrust: float


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Apply the setpoint in a packet."""
    if packet.channel != 0:
        return []
    roll, pitch, yaw, thrust = read_fields(_FIELDS, packet.data)
    if firmware.commander.priority == Priority.DISABLE:
        firmware.thrust_locked = True
    if thrust == 0:
        firmware.thrust_locked = False
    rpyt = Rpyt(roll, pitch, yaw, thrust)
    firmware.accept(_setpoint(rpyt, firmware.requested, firmware.parameters, locked=firmware.thrust_locked))
    return []


def _setpoint(rpyt: Rpyt, last: Setpoint, mode: Parameters, *, locked: bool) -> Setpoint:
    pwm = 0.0 if locked or rpyt.thrust < RPYT_PWM_MIN else min(rpyt.thrust, float(RPYT_PWM_MAX))
    made = _with_height(rpyt, replace(last, thrust_pwm=pwm), mode)
    return _with_yaw(rpyt, _with_tilt(rpyt, made, mode), mode)


def _with_height(rpyt: Rpyt, made: Setpoint, mode: Parameters) -> Setpoint:
    if not mode.flag("flightmode.althold"):
        return replace(made, z=Mode.DISABLE)
    climb = (rpyt.thrust - MIDDLE) / MIDDLE
    return replace(made, z=Mode.VELOCITY, vel=(*made.vel[:2], climb), thrust_pwm=0.0)


def _with_tilt(rpyt: Rpyt, made: Setpoint, mode: Parameters) -> Setpoint:
    if mode.flag("flightmode.poshold"):
        return _with_velocity(rpyt, made)
    if mode.flag("flightmode.posSet") and rpyt.thrust != 0:
        return _with_position(rpyt, made)
    by_angle = mode.flag("flightmode.stabModeRoll"), mode.flag("flightmode.stabModePitch")
    roll, roll_rate = (rpyt.roll, 0.0) if by_angle[0] else (0.0, rpyt.roll)
    pitch, pitch_rate = (rpyt.pitch, 0.0) if by_angle[1] else (0.0, rpyt.pitch)
    return replace(
        made,
        x=Mode.DISABLE,
        y=Mode.DISABLE,
        roll=Mode.ABS if by_angle[0] else Mode.VELOCITY,
        pitch=Mode.ABS if by_angle[1] else Mode.VELOCITY,
        vel=(0.0, 0.0, made.vel[2]),
        attitude_deg=(roll, pitch, made.attitude_deg[2]),
        rate_deg=(roll_rate, pitch_rate, made.rate_deg[2]),
    )


def _with_velocity(rpyt: Rpyt, made: Setpoint) -> Setpoint:
    return replace(
        made,
        x=Mode.VELOCITY,
        y=Mode.VELOCITY,
        roll=Mode.DISABLE,
        pitch=Mode.DISABLE,
        vel=(rpyt.pitch / ANGLE_PER_SPEED, rpyt.roll / ANGLE_PER_SPEED, made.vel[2]),
        attitude_deg=(0.0, 0.0, made.attitude_deg[2]),
    )


def _with_position(rpyt: Rpyt, made: Setpoint) -> Setpoint:
    return replace(
        made,
        x=Mode.ABS,
        y=Mode.ABS,
        z=Mode.ABS,
        roll=Mode.DISABLE,
        pitch=Mode.DISABLE,
        yaw=Mode.ABS,
        pos=(-rpyt.pitch, rpyt.roll, rpyt.thrust / 1000.0),
        attitude_deg=(0.0, 0.0, rpyt.yaw),
        thrust_pwm=0.0,
    )


def _with_yaw(rpyt: Rpyt, made: Setpoint, mode: Parameters) -> Setpoint:
    if mode.flag("flightmode.posSet"):
        return made
    roll, pitch, _ = made.attitude_deg
    if mode.flag("flightmode.stabModeYaw"):
        still = (*made.rate_deg[:2], 0.0)
        return replace(made, yaw=Mode.ABS, attitude_deg=(roll, pitch, rpyt.yaw), rate_deg=still)
    return replace(made, yaw=Mode.VELOCITY, rate_deg=(*made.rate_deg[:2], -rpyt.yaw))
