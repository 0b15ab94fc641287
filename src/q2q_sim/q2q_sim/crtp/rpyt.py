"""Read port 3: roll, pitch, yaw rate and thrust, as a stick gives them.

Source: firmware: modules/src/crtp_commander_rpyt.c. Three floats and a uint16:

| field | meaning |
|---|---|
| roll | [deg], right side down |
| pitch | [deg], *legacy*: nose up; cflib's send_setpoint turns the sign: its pitch is nose down |
| yaw | rate [deg/s], *inverted*: positive turns right |
| thrust | 0, or 1000 to 60000 [PWM]; locked at 0 until one packet with thrust 0 has come |

The flightmode parameters change what the fields mean, as in the firmware: stabModeRoll and stabModePitch
(0: rates [deg/s]), stabModeYaw (1: angle, not inverted), althold (thrust is a climb rate), poshold (pitch and
roll are velocities), posSet (-pitch, roll, thrust / 1000 are a position).
"""

import struct
from dataclasses import replace

from q2q_model.thrust_map import PWM_STICK_MAX
from q2q_sim.crtp.fields import read
from q2q_sim.crtp.packet import Packet
from q2q_sim.onboard.commander import Priority
from q2q_sim.onboard.firmware import Firmware
from q2q_sim.onboard.parameters import Parameters
from q2q_sim.onboard.setpoint import Mode, Setpoint

_FIELDS = struct.Struct("<fffH")
PWM_MIN = 1000
"""MIN_THRUST."""
MIDDLE = 32767.0
"""Thrust that neither climbs nor sinks under althold; as far above it 1 m/s."""
STICK_PER_SPEED = 30.0
"""Degrees of stick for 1 m/s under poshold."""


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Fly the setpoint in a packet."""
    if packet.channel != 0:
        return []
    roll, pitch, yaw, thrust = read(_FIELDS, packet.data)
    if firmware.commander.priority == Priority.DISABLE:
        firmware.thrust_locked = True
    if thrust == 0:
        firmware.thrust_locked = False
    firmware.obey(_setpoint((roll, pitch, yaw), thrust, firmware.parameters, locked=firmware.thrust_locked))
    return []


def _setpoint(
    stick: tuple[float, float, float], thrust: float, mode: Parameters, *, locked: bool
) -> Setpoint:
    pwm = 0.0 if locked or thrust < PWM_MIN else min(thrust, float(PWM_STICK_MAX))
    made = _turning(_tilting(stick, thrust, mode), stick[2], mode)
    if mode.flag("flightmode.posSet") and thrust != 0:
        return made
    if mode.flag("flightmode.althold"):
        climb = (thrust - MIDDLE) / MIDDLE
        return replace(made, z=Mode.VELOCITY, vel=(made.vel[0], made.vel[1], climb))
    return replace(made, thrust_pwm=pwm)


def _tilting(stick: tuple[float, float, float], thrust: float, mode: Parameters) -> Setpoint:
    roll, pitch, yaw = stick
    if mode.flag("flightmode.poshold"):
        vel = (pitch / STICK_PER_SPEED, roll / STICK_PER_SPEED, 0.0)
        return Setpoint(x=Mode.VELOCITY, y=Mode.VELOCITY, vel=vel)
    if mode.flag("flightmode.posSet") and thrust != 0:
        where = (-pitch, roll, thrust / 1000.0)
        return Setpoint(
            x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=where, attitude_deg=(0.0, 0.0, yaw)
        )
    by_angle = mode.flag("flightmode.stabModeRoll"), mode.flag("flightmode.stabModePitch")
    return Setpoint(
        roll=Mode.ABS if by_angle[0] else Mode.VELOCITY,
        pitch=Mode.ABS if by_angle[1] else Mode.VELOCITY,
        attitude_deg=(roll if by_angle[0] else 0.0, pitch if by_angle[1] else 0.0, 0.0),
        rate_deg=(0.0 if by_angle[0] else roll, 0.0 if by_angle[1] else pitch, 0.0),
    )


def _turning(setpoint: Setpoint, yaw: float, mode: Parameters) -> Setpoint:
    if mode.flag("flightmode.posSet"):
        return setpoint
    if mode.flag("flightmode.stabModeYaw"):
        roll, pitch, _ = setpoint.attitude_deg
        return replace(setpoint, yaw=Mode.ABS, attitude_deg=(roll, pitch, yaw))
    return replace(setpoint, yaw=Mode.VELOCITY, rate_deg=(*setpoint.rate_deg[:2], -yaw))
