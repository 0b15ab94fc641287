"""Pose and status of a vehicle, from its logs, as crazyflie_py keeps them for the program."""

import struct
from dataclasses import dataclass
from typing import NamedTuple

from q2q_model.geometry.quaternion32 import decompress_quat
from q2q_sim.crtp.packets.packet import Port, packet_of
from q2q_sim.crtp.ports import log_blocks

POSE, STATUS = 0, 1
"""Log blocks."""
POSE_VARIABLES = ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z", "stateEstimateZ.quat")
STATUS_VARIABLES = ("supervisor.info", "pm.vbatMV", "pm.state", "radio.rssi")
_POSE, _STATUS = struct.Struct("<fffI"), struct.Struct("<HHBB")
_VALUES_AT = 4
"""After the block's number and the time stamp."""
COUNTS = ("num_rx_broadcast", "num_tx_broadcast", "num_rx_unicast", "num_tx_unicast")
"""Packets counted by the server, which are 0 here as with old firmware."""

StatusReport = dict[str, str | float]


class Point(NamedTuple):
    """geometry_msgs/Point [m]."""

    x: float
    y: float
    z: float


class Quaternion(NamedTuple):
    """geometry_msgs/Quaternion, body to world."""

    x: float
    y: float
    z: float
    w: float


@dataclass(frozen=True, slots=True)
class Pose:
    """geometry_msgs/Pose."""

    position: Point
    orientation: Quaternion


def report_in_packet(datagram: bytes) -> Pose | StatusReport | None:
    """Return the pose or status in a packet of the vehicle; None if it has neither."""
    packet = packet_of(datagram)
    if (packet.port, packet.channel) != (Port.LOG, log_blocks.DATA):
        return None
    values = packet.data[_VALUES_AT:]
    if packet.data[0] == POSE:
        x, y, z, bits = _POSE.unpack(values)
        return Pose(Point(x, y, z), Quaternion(*decompress_quat(bits)))
    info, millivolt, power, rssi = _STATUS.unpack(values)
    counts = dict.fromkeys(COUNTS, 0)
    return {"supervisor": info, "battery": millivolt / 1000.0, "pm_state": power, "rssi": rssi, **counts}
