"""Commands of the high-level commander, from their packets (q2q_sim.crtp.ports has the formats)."""

import math

from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.crtp.ports.commander_high_level import GO, GO_2, OLD_VERTICAL, VERTICAL, HighLevel
from q2q_sim.firmware.commander.commander import Priority
from q2q_sim.firmware.commander.planner import PlannerResult
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.licence.client_commands.client_command import Asked, CommandKind
from q2q_sim.licence.client_commands.uploaded_trajectories import absent_trajectory

_OLD_VERTICALS = (HighLevel.OLD_TAKE_OFF, HighLevel.OLD_LAND)
_VERTICALS = (*_OLD_VERTICALS, HighLevel.TAKE_OFF, HighLevel.LAND)
_GO_TO = (HighLevel.GO_TO, HighLevel.GO_TO_2)
_OTHER_PLANS = (HighLevel.TAKE_OFF_AT_SPEED, HighLevel.LAND_AT_SPEED, HighLevel.SPIRAL)
_STARTS: dict[int, int] = {HighLevel.START: 3, HighLevel.START_2: 4}
"""Commands that start a trajectory: place of its number among their fields."""
_UNMASKED = (HighLevel.SET_MASK, HighLevel.DEFINE)
"""Commands without a mask of groups: to set it, to define a trajectory."""
PLAN_NAMES: dict[int, str] = {
    HighLevel.SET_MASK: "group mask",
    HighLevel.OLD_TAKE_OFF: "takeoff",
    HighLevel.OLD_LAND: "land",
    HighLevel.STOP: "high-level stop",
    HighLevel.GO_TO: "go_to",
    HighLevel.START: "start_trajectory",
    HighLevel.DEFINE: "define_trajectory",
    HighLevel.TAKE_OFF: "takeoff",
    HighLevel.LAND: "land",
    HighLevel.TAKE_OFF_AT_SPEED: "takeoff",
    HighLevel.LAND_AT_SPEED: "land",
    HighLevel.SPIRAL: "spiral",
    HighLevel.GO_TO_2: "go_to",
    HighLevel.START_2: "start_trajectory",
}
"""Commands of the high-level commander."""


def planned_command(data: bytes, answers: list[Packet], firmware: Firmware) -> Asked:
    """Return what the packet of a command asks for, after the firmware has answered."""
    number, fields = data[0], data[1:]
    result = answers[-1].data[3] if answers and len(answers[-1].data) > 3 else PlannerResult.OK
    refused = _refusal(result, firmware)
    if number not in _UNMASKED and not _is_addressed(fields[:1], firmware):
        return Asked(CommandKind.OTHER, f"{PLAN_NAMES.get(number, 'command')} for another group")
    if number == HighLevel.STOP:
        return Asked(CommandKind.OFF, PLAN_NAMES[number])
    if number in _VERTICALS:
        return _vertical(number, fields, refused)
    if number in _GO_TO:
        return _go_to(number, fields, refused)
    if number in (*_STARTS, *_OTHER_PLANS):
        starts = number in _STARTS and firmware.supervisor.may_fly
        absent = absent_trajectory(fields[_STARTS[number]], result, firmware) if starts else ""
        return Asked(CommandKind.PLAN, PLAN_NAMES[number], refused=refused, impossible=absent)
    return Asked(CommandKind.OTHER, PLAN_NAMES.get(number, "unknown command"))


def _is_addressed(mask: bytes, firmware: Firmware) -> bool:
    """Return whether a command with a mask of groups is for the vehicle."""
    groups = int(firmware.parameters["hlCommander.groupmask"])
    return not any(mask) or bool(mask[0] & groups)


def _vertical(number: int, fields: bytes, refused: str) -> Asked:
    """Return a take-off or landing; the old commands have no yaw."""
    if len(fields) < (OLD_VERTICAL if number in _OLD_VERTICALS else VERTICAL).size:
        return Asked(CommandKind.PLAN, PLAN_NAMES[number], refused=refused)
    yaw, keep = 0.0, True
    if number in _OLD_VERTICALS:
        _, height, duration = OLD_VERTICAL.unpack_from(fields)
    else:
        _, height, yaw, keep, duration = VERTICAL.unpack_from(fields)
    words = f"{PLAN_NAMES[number]} to {height:.2f} m in {duration:.1f} s"
    return Asked(
        CommandKind.PLAN, words, (math.nan, math.nan, height), yaw_rad=0.0 if keep else yaw, refused=refused
    )


def _go_to(number: int, fields: bytes, refused: str) -> Asked:
    layout = GO if number == HighLevel.GO_TO else GO_2
    if len(fields) < layout.size:
        return Asked(CommandKind.PLAN, PLAN_NAMES[number], refused=refused)
    values = layout.unpack_from(fields)
    relative, (x, y, z, yaw, duration) = bool(values[1]), values[-5:]
    by = "by" if relative else "to"
    words = f"{PLAN_NAMES[number]} {by} ({x:.2f}, {y:.2f}, {z:.2f}) m in {duration:.1f} s"
    return Asked(CommandKind.PLAN, words, None if relative else (x, y, z), yaw_rad=yaw, refused=refused)


def _refusal(result: int, firmware: Firmware) -> str:
    """Return why a command of the high-level commander has no effect; empty if it has."""
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
