"""Port 6: external position and pose, and the old emergency stop.

Source: firmware: modules/src/crtp_localization_service.c. Positions in the world [m], quaternions x y z w:

| channel, type | fields |
|---|---|
| 0 | x, y, z |
| 1, 8 pose | x, y, z, qx, qy, qz, qw |
| 1, 9 packed poses | vehicle, x, y, z [mm] int16, quaternion (32 bits); up to two |
| 2 packed positions | vehicle, x, y, z [mm] int16; up to four |
| 1, 3 emergency stop; 1, 4 its watchdog | |

A packed item is for the vehicle whose radio address ends in its number; in the simulator that number is the
index of the vehicle's port (0, 1, ...).
"""

import struct

from q2q_model.geometry.quaternion32 import decompress_quat
from q2q_sim.crtp.packets.fields import byte, read_fields
from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.firmware.firmware import Firmware

POSITION, GENERIC, PACKED = 0, 1, 2
EMERGENCY_STOP, STOP_WATCHDOG, POSE, POSE_PACKED = 3, 4, 8, 9
_POSITION, _POSE = struct.Struct("<fff"), struct.Struct("<7f")
_PACKED_POSITION, _PACKED_POSE = struct.Struct("<Bhhh"), struct.Struct("<BhhhI")
MILLI = 1e-3


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Apply the position or pose in a packet."""
    if packet.channel == POSITION:
        x, y, z = read_fields(_POSITION, packet.data)
        firmware.locate((x, y, z))
    elif packet.channel == PACKED:
        _packed_positions(firmware, packet.data)
    elif packet.channel == GENERIC:
        _generic(firmware, packet.data)
    return []


def _generic(firmware: Firmware, data: bytes) -> None:
    kind = byte(data, 0)
    if kind == POSE:
        x, y, z, qx, qy, qz, qw = read_fields(_POSE, data, 1)
        firmware.locate((x, y, z), (qx, qy, qz, qw))
    elif kind == POSE_PACKED:
        for at in range(1, len(data) - _PACKED_POSE.size + 1, _PACKED_POSE.size):
            number, x, y, z, bits = read_fields(_PACKED_POSE, data, at)
            if number == firmware.number:
                firmware.locate((MILLI * x, MILLI * y, MILLI * z), decompress_quat(int(bits)))
    elif kind == EMERGENCY_STOP:
        firmware.supervisor.stop()
    elif kind == STOP_WATCHDOG:
        firmware.supervisor.feed(firmware.now_ms)


def _packed_positions(firmware: Firmware, data: bytes) -> None:
    for at in range(0, len(data) - _PACKED_POSITION.size + 1, _PACKED_POSITION.size):
        number, x, y, z = read_fields(_PACKED_POSITION, data, at)
        if number == firmware.number:
            firmware.locate((MILLI * x, MILLI * y, MILLI * z))
