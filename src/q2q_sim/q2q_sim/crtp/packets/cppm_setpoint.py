"""Setpoint type 3: packed pulse widths of a model aircraft's radio control.

Source: firmware: modules/src/crtp_commander_generic.c (cppmEmuDecoder). A byte with the number of further
channels in its lower half, then channels of 1000 to 2000 us, uint16: roll, pitch, yaw, thrust, further ones.

    x = (channel - 1500) / 500,  roll = -x angRoll,  pitch = -x angPitch [deg],  yaw rate = -x rateYaw [deg/s]
    thrust = 65535 (channel - 1000) / 1000, at least 0 [PWM]

If the first of the further channels is below 1500, roll and pitch are rates: rateRoll, ratePitch [deg/s].
The scales are the parameters of group cppm.
"""

import struct

from q2q_sim.crtp.packets.fields import byte, read_fields
from q2q_sim.crtp.packets.packet import MalformedError
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.motors.thrust_curve import PWM_TOP
from q2q_sim.firmware.parameters.parameter_values import Parameters

_CHANNELS, _SWITCH = struct.Struct("<4H"), struct.Struct("<H")
MOST_FURTHER = 10
MIDDLE, REACH, LEAST, RANGE = 1500.0, 500.0, 1000.0, 1000.0
"""[us]"""


def cppm_setpoint(data: bytes, parameters: Parameters) -> Setpoint:
    """Return the setpoint of a packet after its type; raise MalformedError if its length is wrong."""
    further = byte(data, 0) & 0x0F
    needed = 1 + _CHANNELS.size + further * _SWITCH.size
    if further > MOST_FURTHER or len(data) != needed:
        raise MalformedError(f"{len(data)} bytes; must be {needed} for {further} of {MOST_FURTHER} channels")
    roll, pitch, yaw, thrust = read_fields(_CHANNELS, data, 1)
    by_angle = further == 0 or read_fields(_SWITCH, data, 1 + _CHANNELS.size)[0] >= MIDDLE
    kind, mode = ("ang", Mode.ABS) if by_angle else ("rate", Mode.VELOCITY)
    x, y = (_stick(roll, parameters, f"{kind}Roll"), _stick(pitch, parameters, f"{kind}Pitch"))
    turn = _stick(yaw, parameters, "rateYaw")
    return Setpoint(
        roll=mode,
        pitch=mode,
        yaw=Mode.VELOCITY,
        attitude_deg=(x, y, 0.0) if by_angle else (0.0, 0.0, 0.0),
        rate_deg=(0.0, 0.0, turn) if by_angle else (x, y, turn),
        thrust_pwm=max(PWM_TOP * (thrust - LEAST) / RANGE, 0.0),
    )


def _stick(channel: float, parameters: Parameters, name: str) -> float:
    return -(channel - MIDDLE) / REACH * float(parameters[f"cppm.{name}"])
