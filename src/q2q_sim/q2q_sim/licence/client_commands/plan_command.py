"""Commands of the high-level commander, from their packets (q2q_sim.crtp.ports has the formats)."""

import math

from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.crtp.ports.commander_high_level import GO, GO_2, OLD_VERTICAL, VERTICAL
from q2q_sim.firmware.commander.commander import Priority
from q2q_sim.firmware.commander.planner import PlannerResult
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.licence.client_commands.client_command import Asked, CommandKind
from q2q_sim.licence.client_commands.uploaded_trajectories import absent_trajectory

_TAKE_OFF, _LAND, _LEAVE, _GO_TO, _OTHER_PLANS = (1, 7), (2, 8), 3, (4, 12), (9, 10, 11)
_STARTS = {5: 3, 13: 4}
"""Commands that start a trajectory: place of its number among their fields."""
_UNMASKED = (0, 6)
"""Commands without a mask of groups: to set it, to define a trajectory."""
PLAN_NAMES = {
    0: "group mask", 1: "takeoff", 2: "land", 3: "high-level stop", 4: "go_to", 5: "start_trajectory",
    6: "define_trajectory", 7: "takeoff", 8: "land", 9: "takeoff", 10: "land", 11: "spiral", 12: "go_to",
    13: "start_trajectory",
}  # fmt: skip
"""Commands of the high-level commander."""


def planned_command(data: bytes, answers: list[Packet], firmware: Firmware) -> Asked:
    """Return what the packet of a command asks for, after the firmware has answered."""
    number, fields = data[0], data[1:]
    refused = _refusal(answers, firmware)
    if number not in _UNMASKED and not _is_addressed(fields[:1], firmware):
        return Asked(CommandKind.OTHER, f"{PLAN_NAMES.get(number, 'command')} for another group")
    if number == _LEAVE:
        return Asked(CommandKind.OFF, PLAN_NAMES[number])
    if number in (*_TAKE_OFF, *_LAND):
        return _vertical(number, fields, refused)
    if number in _GO_TO:
        return _go_to(number, fields, refused)
    if number in (*_STARTS, *_OTHER_PLANS):
        starts = number in _STARTS and not refused
        absent = absent_trajectory(fields[_STARTS[number]], firmware) if starts else ""
        return Asked(CommandKind.PLAN, PLAN_NAMES[number], refused=refused, impossible=absent)
    return Asked(CommandKind.OTHER, PLAN_NAMES.get(number, "unknown command"))


def _is_addressed(mask: bytes, firmware: Firmware) -> bool:
    """Return whether a command with a mask of groups is for the vehicle."""
    groups = int(firmware.parameters["hlCommander.groupmask"])
    return not any(mask) or bool(mask[0] & groups)


def _vertical(number: int, fields: bytes, refused: str) -> Asked:
    """Return a take-off or landing; the old commands, 1 and 2, have no yaw."""
    if len(fields) < (OLD_VERTICAL if number in (1, 2) else VERTICAL).size:
        return Asked(CommandKind.PLAN, PLAN_NAMES[number], refused=refused)
    yaw, keep = 0.0, True
    if number in (1, 2):
        _, height, duration = OLD_VERTICAL.unpack_from(fields)
    else:
        _, height, yaw, keep, duration = VERTICAL.unpack_from(fields)
    words = f"{PLAN_NAMES[number]} to {height:.2f} m in {duration:.1f} s"
    return Asked(
        CommandKind.PLAN, words, (math.nan, math.nan, height), yaw_rad=0.0 if keep else yaw, refused=refused
    )


def _go_to(number: int, fields: bytes, refused: str) -> Asked:
    layout = GO if number == _GO_TO[0] else GO_2
    if len(fields) < layout.size:
        return Asked(CommandKind.PLAN, PLAN_NAMES[number], refused=refused)
    values = layout.unpack_from(fields)
    relative, (x, y, z, yaw, duration) = bool(values[1]), values[-5:]
    by = "by" if relative else "to"
    words = f"{PLAN_NAMES[number]} {by} ({x:.2f}, {y:.2f}, {z:.2f}) m in {duration:.1f} s"
    return Asked(CommandKind.PLAN, words, None if relative else (x, y, z), yaw_rad=yaw, refused=refused)


def _refusal(answers: list[Packet], firmware: Firmware) -> str:
    """Return why a command of the high-level commander has no effect; empty if it has."""
    result = answers[-1].data[3] if answers and len(answers[-1].data) > 3 else PlannerResult.OK
    if not firmware.supervisor.may_fly:
        return grounded(firmware)
    if result != PlannerResult.OK:
        return f"the vehicle answered {PlannerResult(result).name}"
    if firmware.commander.priority == Priority.CLIENT:
        return "setpoints have priority until notify_setpoint_stop"
    return ""


def grounded(firmware: Firmware) -> str:
    """Return why a vehicle may not fly; empty if it may."""
    if firmware.supervisor.may_fly:
        return ""
    starved = firmware.supervisor.is_starved(firmware.now_ms)
    return "the emergency stop watchdog was not fed for 1 s" if starved else "the vehicle is not armed"
