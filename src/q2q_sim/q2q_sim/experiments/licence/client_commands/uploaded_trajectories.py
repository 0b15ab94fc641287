"""Uploaded trajectories that are not there when they are started, or change while they are flown.

The firmware starts whatever its memory holds: nothing, the pieces that have arrived, or those of before.
"""

import struct

from q2q_sim.firmware.commander.planner import MOVING
from q2q_sim.firmware.firmware import Firmware

_PLACE = struct.Struct("<BI")
"""Memory and address of a packet that writes."""
TRAJECTORIES = 0
"""Memory of the trajectories."""


def absent_trajectory(number: int, firmware: Firmware) -> str:
    """Return what is absent of a trajectory that has been started and was answered OK; or nothing."""
    if number not in firmware.uploads.defined:
        return f"trajectory {number}, which is not defined"
    plan = firmware.planner.trajectory
    pieces = () if plan is None else plan.pieces
    absent = sum(piece.duration == 0.0 for piece in pieces)  # the duration is written last
    return (
        f"trajectory {number}, of which {absent} of {len(pieces)} pieces are not uploaded" if absent else ""
    )


def overwritten_trajectory(data: bytes, firmware: Firmware) -> str:
    """Return that a packet to the memory has changed the trajectory that is flown; or nothing."""
    planner = firmware.planner
    plan = planner.trajectory
    if plan is None or plan.stored is None:
        return ""
    if planner.state not in MOVING or planner.finished(firmware.seconds):
        return ""
    memory, at = _PLACE.unpack_from(data)
    overlaps = at < plan.stored.stop and at + len(data) - _PLACE.size > plan.stored.start
    changes = "a change of the trajectory that it flies"
    return changes if memory == TRAJECTORIES and overlaps else ""
