"""Uploaded trajectories that are not there when they are started, or change while they are flown.

The firmware starts whatever its memory holds: nothing, the pieces that have arrived, or those of before. It
reads beyond the memory, where the emulated one refuses to (q2q_sim.crtp.ports.commander_high_level).
"""

import struct

from q2q_sim.crtp.ports.commander_high_level import COMPRESSED, PIECE_BYTES
from q2q_sim.crtp.ports.memory import TRAJECTORY_MEMORY
from q2q_sim.firmware.commander.planner import MOVING, PlannerResult
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.parameters.uploads import TRAJECTORY_BYTES, Uploaded

_PLACE = struct.Struct("<BI")
"""Memory and address of a packet that writes."""


def absent_trajectory(number: int, result: int, firmware: Firmware) -> str:
    """Return what is absent of a trajectory whose start a vehicle has answered with a result; or nothing."""
    one = firmware.uploads.defined.get(number)
    if one is None:
        return f"trajectory {number}, which is not defined"
    if result != PlannerResult.OK:
        return f"trajectory {number}, {_refused(one)}"
    plan = firmware.planner.trajectory
    if plan is None or plan.stored is None:
        return ""
    count, place = len(plan.pieces), plan.stored.place
    size = len(place) // count  # a compressed one with a piece of 0 s has no other
    ends = (firmware.uploads.written[at] for at in place[size - 1 :: size])  # the duration is written last
    absent = sum(
        piece.duration == 0.0 and not written for piece, written in zip(plan.pieces, ends, strict=False)
    )
    return f"trajectory {number}, with {absent} of {count} pieces not uploaded" if absent else ""


def _refused(one: Uploaded) -> str:
    """Return why a vehicle refuses to start a trajectory that is defined."""
    if one.kind == COMPRESSED:
        return "compressed, which leaves the memory or is to be reversed or stretched"
    end = one.offset + one.pieces * PIECE_BYTES
    return f"whose {one.pieces} pieces end at byte {end} of a memory of {TRAJECTORY_BYTES}"


def overwritten_trajectory(data: bytes, firmware: Firmware) -> str:
    """Return that a packet to the memory has changed the trajectory that is flown; or nothing."""
    planner = firmware.planner
    plan = planner.trajectory
    if plan is None or plan.stored is None:
        return ""
    if planner.state not in MOVING or planner.finished(firmware.seconds):
        return ""
    memory, at = _PLACE.unpack_from(data)
    place = plan.stored.place
    overlaps = at < place.stop and at + len(data) - _PLACE.size > place.start
    changed = firmware.uploads.memory[place.start : place.stop] != plan.stored.content
    told = memory == TRAJECTORY_MEMORY and overlaps and changed
    return "a change of the trajectory it is flying" if told else ""
