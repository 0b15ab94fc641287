"""Port 7: setpoints of many types, and the notification that they stop.

Source: firmware: modules/src/crtp_commander_generic.c, crtp_commander.c. Channel 0 is a type byte and fields;
angles in degrees, pitch nose up (legacy) for attitudes, yaw rates left for the new types:

| type | fields |
|---|---|
| 0 stop | none: motors off; and so does every type above 11 |
| 3 radio control pulses | see cppm_setpoint |
| 6 full state | position [mm], velocity [mm/s], acceleration [mm/s^2], quaternion (32 bits), rates [mrad/s] |
| 7 position | x, y, z [m], yaw [deg] |
| 8 velocity | vx, vy, vz [m/s], world, yaw rate [deg/s]; 1: yaw rate to the right |
| 9 z distance | roll, pitch [deg], yaw rate [deg/s], z [m]; 2: yaw rate to the right |
| 10 hover | vx, vy [m/s], body, yaw rate [deg/s], z [m]; 5: yaw rate to the right |
| 4 alt hold | roll, pitch [deg], yaw rate [deg/s], climb [m/s] |
| 11 manual | roll, pitch [deg or deg/s], yaw rate [deg/s], thrust [PWM], uint8: the first two are rates |

Full state carries body rates (x, y, z). cflib's send_full_state_setpoint documents its rates in degrees a
second but sends its arguments times 1000, which the firmware reads as mrad/s: pass rad/s.
Channel 1, type 0: notify that setpoints stop; the high-level commander may take over.

Unlike the firmware, which stops until a reboot (ASSERT), a packet that is too short is refused.
"""

import math
import struct
from collections.abc import Callable

from q2q_model.geometry.quaternion32 import decompress_quat
from q2q_sim.crtp.packets.cppm_setpoint import cppm_setpoint
from q2q_sim.crtp.packets.fields import byte, read_fields
from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.firmware.commander.setpoint import STOP, Mode, Setpoint
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.parameters.parameter_values import Parameters

SETPOINT, META = 0, 1
NOTIFY_STOP = 0
PULSES = 3
_FOUR, _MANUAL, _FULL = struct.Struct("<ffff"), struct.Struct("<fffHB"), struct.Struct("<9hI3h")
MILLI = 1e-3


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Apply the setpoint in a packet, or let the high-level commander take over."""
    kind = byte(packet.data, 0)
    if packet.channel == META and kind == NOTIFY_STOP:
        firmware.relax()
    if packet.channel == SETPOINT:
        firmware.accept(_setpoint(kind, packet.data[1:], firmware.parameters))
    return []


def _setpoint(kind: int, data: bytes, parameters: Parameters) -> Setpoint:
    return cppm_setpoint(data, parameters) if kind == PULSES else _READERS.get(kind, _stop)(data)


def _stop(_: bytes) -> Setpoint:
    return STOP


def _full_state(data: bytes) -> Setpoint:
    numbers = read_fields(_FULL, data)
    x, y, z, vx, vy, vz, ax, ay, az = (MILLI * one for one in numbers[:9])
    p, q, r = (math.degrees(MILLI * one) for one in numbers[10:])
    return Setpoint(
        x=Mode.ABS,
        y=Mode.ABS,
        z=Mode.ABS,
        quat=Mode.ABS,
        pos=(x, y, z),
        vel=(vx, vy, vz),
        acc=(ax, ay, az),
        attitude_quat=decompress_quat(int(numbers[9])),
        rate_deg=(p, q, r),
    )


def _position(data: bytes) -> Setpoint:
    x, y, z, yaw = read_fields(_FOUR, data)
    return Setpoint(
        x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(x, y, z), attitude_deg=(0.0, 0.0, yaw)
    )


def _velocity(left: float) -> Callable[[bytes], Setpoint]:
    def made(data: bytes) -> Setpoint:
        vx, vy, vz, rate = read_fields(_FOUR, data)
        move = Mode.VELOCITY
        return Setpoint(x=move, y=move, z=move, yaw=move, vel=(vx, vy, vz), rate_deg=(0.0, 0.0, left * rate))

    return made


def _z_distance(left: float) -> Callable[[bytes], Setpoint]:
    def made(data: bytes) -> Setpoint:
        roll, pitch, rate, z = read_fields(_FOUR, data)
        return _attitude((roll, pitch), left * rate, z=Mode.ABS, pos=(0.0, 0.0, z))

    return made


def _alt_hold(data: bytes) -> Setpoint:
    roll, pitch, rate, climb = read_fields(_FOUR, data)
    return _attitude((roll, pitch), rate, z=Mode.VELOCITY, vel=(0.0, 0.0, climb))


def _hover(left: float) -> Callable[[bytes], Setpoint]:
    def made(data: bytes) -> Setpoint:
        vx, vy, rate, z = read_fields(_FOUR, data)
        return Setpoint(
            x=Mode.VELOCITY,
            y=Mode.VELOCITY,
            z=Mode.ABS,
            yaw=Mode.VELOCITY,
            pos=(0.0, 0.0, z),
            vel=(vx, vy, 0.0),
            rate_deg=(0.0, 0.0, left * rate),
            velocity_body=True,
        )

    return made


def _manual(data: bytes) -> Setpoint:
    roll, pitch, rate, thrust, by_rate = read_fields(_MANUAL, data)
    if by_rate:
        return Setpoint(
            roll=Mode.VELOCITY,
            pitch=Mode.VELOCITY,
            yaw=Mode.VELOCITY,
            rate_deg=(roll, pitch, rate),
            thrust_pwm=thrust,
        )
    return Setpoint(
        roll=Mode.ABS,
        pitch=Mode.ABS,
        yaw=Mode.VELOCITY,
        attitude_deg=(roll, pitch, 0.0),
        rate_deg=(0.0, 0.0, rate),
        thrust_pwm=thrust,
    )


def _attitude(
    tilt: tuple[float, float],
    yaw_rate: float,
    *,
    z: Mode,
    pos: tuple[float, float, float] = (0.0, 0.0, 0.0),
    vel: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Setpoint:
    return Setpoint(
        roll=Mode.ABS,
        pitch=Mode.ABS,
        yaw=Mode.VELOCITY,
        z=z,
        pos=pos,
        vel=vel,
        attitude_deg=(*tilt, 0.0),
        rate_deg=(0.0, 0.0, yaw_rate),
    )


_READERS: dict[int, Callable[[bytes], Setpoint]] = {
    0: _stop,
    1: _velocity(-1.0),
    2: _z_distance(-1.0),
    4: _alt_hold,
    5: _hover(-1.0),
    6: _full_state,
    7: _position,
    8: _velocity(1.0),
    9: _z_distance(1.0),
    10: _hover(1.0),
    11: _manual,
}
"""Reader of each type."""
