"""Commands of a program as the vehicles receive them, in words.

The meaning of a setpoint is taken from the firmware that has accepted it; commands of the high-level
commander and of the supervisor are read from their packets (q2q_sim.crtp.ports has the formats).
"""

import math
import struct
from dataclasses import dataclass, replace
from enum import StrEnum

from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1
from q2q_model.vehicle.thrust_map import MASS_THRUST
from q2q_sim.crtp.packets.packet import Packet, Port
from q2q_sim.crtp.ports import (
    commander_generic,
    commander_rpyt,
    localization,
    memory,
    platform,
    supervisor_port,
)
from q2q_sim.experiments.licence.client_commands.plan_reach import reach_violation
from q2q_sim.experiments.licence.client_commands.setpoint_text import asked_position, setpoint_text
from q2q_sim.experiments.licence.client_commands.uploaded_trajectories import (
    absent_trajectory,
    overwritten_trajectory,
)
from q2q_sim.firmware.commander.commander import Priority
from q2q_sim.firmware.commander.planner import PlannerAnswer, PlanState
from q2q_sim.firmware.commander.setpoint import STOP, Mode, Three
from q2q_sim.firmware.firmware import Firmware

_VERTICAL, _GO, _GO_2 = struct.Struct("<Bff?f"), struct.Struct("<BB5f"), struct.Struct("<BBB5f")
_OLD = struct.Struct("<Bff")
_TAKE_OFF, _LAND, _LEAVE, _GO_TO, _OTHER_PLANS = (1, 7), (2, 8), 3, (4, 12), (9, 10, 11)
_STARTS = {5: 3, 13: 4}
"""Commands that start a trajectory: place of its number among their fields."""
_UNMASKED = (0, 6)
"""Commands without a mask of groups: to set it, to define a trajectory."""
_STOPS = (
    (Port.SUPERVISOR, supervisor_port.COMMAND, bytes([supervisor_port.STOP])),
    (Port.LOCALIZATION, localization.GENERIC, bytes([localization.EMERGENCY_STOP])),
)
_FEEDS = (
    (Port.SUPERVISOR, supervisor_port.COMMAND, bytes([supervisor_port.FEED])),
    (Port.LOCALIZATION, localization.GENERIC, bytes([localization.STOP_WATCHDOG])),
)
_ARMS = (
    (Port.SUPERVISOR, supervisor_port.COMMAND, bytes([supervisor_port.ARM])),
    (Port.PLATFORM, platform.COMMAND, bytes([supervisor_port.ARM])),
)
"""Commands to the supervisor: port, channel and first byte."""
NAMES = {
    0: "group mask", 1: "takeoff", 2: "land", 3: "high-level stop", 4: "go_to", 5: "start_trajectory",
    6: "define_trajectory", 7: "takeoff", 8: "land", 9: "takeoff", 10: "land", 11: "spiral", 12: "go_to",
    13: "start_trajectory",
}  # fmt: skip
"""Commands of the high-level commander."""
LIFTING = CRAZYFLIE_2_0.hover_thrust * MASS_THRUST
"""Thrust of the weight of the vehicles that fly [PWM] (licence_room): less tests motors on the floor, or is
meant for a lighter vehicle."""
COMPLEMENTARY = 1
"""Value of stabilizer.estimator: attitude and height only (firmware: estimator_complementary.c)."""


class CommandKind(StrEnum):
    """Kinds of commands."""

    SETPOINT = "setpoint"
    """Makes a vehicle fly."""
    OFF = "off"
    """Stops the motors."""
    PLAN = "plan"
    """Take-off, go-to, landing or trajectory of the high-level commander."""
    RELAX = "relax"
    """Setpoints stop; the high-level commander may take over."""
    EMERGENCY = "emergency"
    WATCHDOG = "watchdog"
    """Starts or feeds the watchdog of the emergency stop."""
    OTHER = "other"
    """Arming, group mask, definition of a trajectory."""


FLIGHT = frozenset((CommandKind.SETPOINT, CommandKind.PLAN))
"""Commands that ask for flight."""


@dataclass(frozen=True, slots=True)
class Asked:
    """Content of a command."""

    kind: CommandKind
    words: str
    pos: Three | None = None
    """Position asked for [m], world; NaN on axes that are not."""
    yaw_rad: float = 0.0
    """Yaw that the high-level commander is asked for [rad]."""
    refused: str = ""
    """Why the vehicle does not follow; empty if it does."""
    impossible: str = ""
    """What no vehicle can follow; empty if it can."""
    lifts: bool = True
    """False for a setpoint of less thrust than the vehicle's weight."""


@dataclass(frozen=True, slots=True)
class ClientCommand:
    """Command that a vehicle has received."""

    t: float
    """[s]"""
    vehicle: int
    asked: Asked
    line: int
    """Line of the program that sent it; 0 if a library's thread did."""
    closing: bool = False
    """Sent by close_link."""

    @property
    def words(self) -> str:
        """Return the command with its place in the program and the time."""
        if self.closing:
            return f"the closing of the link at {self.t:.2f} s, which sends zero thrust"
        return f"{self.asked.words} at {self.t:.2f} s{self._place}"

    @property
    def words_without_time(self) -> str:
        """Return the command with its place in the program."""
        return f"{self.asked.words}{self._place}"

    @property
    def _place(self) -> str:
        return f", line {self.line}" if self.line else ""


def client_command(packet: Packet, answers: list[Packet], firmware: Firmware) -> Asked | None:
    """Return what a packet asked for, after the firmware has handled it; None if it is no command."""
    match packet.port:
        case Port.SETPOINT:
            asked: Asked | None = _thrust(packet, firmware) or _setpoint(firmware)
        case Port.GENERIC if packet.channel == commander_generic.META:
            asked = Asked(CommandKind.RELAX, "notify_setpoint_stop")
        case Port.GENERIC:
            asked = _setpoint(firmware)
        case Port.HIGH_LEVEL if packet.data:
            asked = _planned(packet.data, answers, firmware)
        case Port.MEMORY if packet.channel == memory.WRITE:
            flown = overwritten_trajectory(packet.data, firmware)
            asked = Asked(CommandKind.OTHER, "upload", impossible=flown) if flown else None
        case _:
            asked = _supervised(packet)
    if asked is None or asked.impossible or not _needs_position(asked, firmware):
        return asked
    return replace(asked, impossible=_without_position(firmware) or _out_of_reach(asked, firmware))


def _needs_position(asked: Asked, firmware: Firmware) -> bool:
    """Return whether a command makes a vehicle hold or leave a place."""
    moved = (firmware.requested.x, firmware.requested.y) != (Mode.DISABLE,) * 2
    return asked.kind == CommandKind.PLAN or (asked.kind == CommandKind.SETPOINT and moved)


def _without_position(firmware: Firmware) -> str:
    """Return that a vehicle has chosen an estimator without horizontal position; or nothing."""
    chosen = firmware.parameters["stabilizer.estimator"]
    return "a position that its complementary estimator does not know" if chosen == COMPLEMENTARY else ""


def _out_of_reach(asked: Asked, firmware: Firmware) -> str:
    """Return what is out of reach of the plan that a command has begun; or nothing.

    A landing in 0 s is not flown: it stops the motors, which the rules of motors and landing judge.
    """
    planner = firmware.planner
    plan = planner.trajectory
    if asked.kind != CommandKind.PLAN or asked.refused or plan is None:
        return ""
    if planner.state == PlanState.LANDING and planner.finished(firmware.seconds):
        return ""
    lightest = CRAZYFLIE_2_1  # of the brushed ones: the program may be meant for it
    return reach_violation(plan, planner.here.pos, lightest)


def malformed_command(packet: Packet) -> Asked | None:
    """Return what a packet asked for that was not handled, as a number is not finite; None if no command."""
    if packet.port not in {Port.SETPOINT, Port.GENERIC, Port.HIGH_LEVEL}:
        return None
    plan = packet.port == Port.HIGH_LEVEL and packet.data
    words = NAMES.get(packet.data[0], "command") if plan else "setpoint"
    kind = CommandKind.PLAN if plan else CommandKind.SETPOINT
    return Asked(kind, words, refused="a number is not finite", impossible="a number that is not finite")


def _supervised(packet: Packet) -> Asked | None:
    """Return the command to the supervisor in a packet; None if it is another one."""
    to_supervisor = packet.port, packet.channel, packet.data[:1]
    for kind, words, packets in (
        (CommandKind.EMERGENCY, "emergency stop", _STOPS),
        (CommandKind.WATCHDOG, "feeding of the emergency stop watchdog", _FEEDS),
        (CommandKind.OTHER, f"{'' if any(packet.data[1:2]) else 'dis'}arming request", _ARMS),
    ):
        if to_supervisor in packets:
            return Asked(kind, words)
    return None


def _thrust(packet: Packet, firmware: Firmware) -> Asked | None:
    """Return a setpoint whose thrust the firmware takes for none; None if it is another one."""
    thrust = int.from_bytes(packet.data[-2:], "little")
    if firmware.thrust_locked:
        why = "no setpoint of thrust 0 has unlocked the thrust"
    elif 0 < thrust < commander_rpyt.PWM_MIN and _setpoint(firmware).kind == CommandKind.OFF:
        why = f"the firmware takes a thrust below {commander_rpyt.PWM_MIN} of 65535 for none"
    else:
        return None
    return Asked(CommandKind.SETPOINT, f"setpoint of thrust {thrust}", refused=why)


def _setpoint(firmware: Firmware) -> Asked:
    one = firmware.requested
    moved = (one.x, one.y, one.z) != (Mode.DISABLE,) * 3
    if one == STOP:
        return Asked(CommandKind.OFF, "stop setpoint")
    if not moved and one.thrust_pwm == 0.0:
        return Asked(CommandKind.OFF, "setpoint of thrust 0")
    refused = _grounded(firmware)
    lifts = moved or one.thrust_pwm >= LIFTING
    return Asked(CommandKind.SETPOINT, setpoint_text(one), asked_position(one), refused=refused, lifts=lifts)


def _planned(data: bytes, answers: list[Packet], firmware: Firmware) -> Asked:
    number, fields = data[0], data[1:]
    refused = _refusal(answers, firmware)
    if number not in _UNMASKED and not _is_addressed(fields[:1], firmware):
        return Asked(CommandKind.OTHER, f"{NAMES.get(number, 'command')} for another group")
    if number == _LEAVE:
        return Asked(CommandKind.OFF, NAMES[number])
    if number in (*_TAKE_OFF, *_LAND):
        return _vertical(number, fields, refused)
    if number in _GO_TO:
        return _go_to(number, fields, refused)
    if number in (*_STARTS, *_OTHER_PLANS):
        starts = number in _STARTS and not refused
        absent = absent_trajectory(fields[_STARTS[number]], firmware) if starts else ""
        return Asked(CommandKind.PLAN, NAMES[number], refused=refused, impossible=absent)
    return Asked(CommandKind.OTHER, NAMES.get(number, "unknown command"))


def _is_addressed(mask: bytes, firmware: Firmware) -> bool:
    """Return whether a command with a mask of groups is for the vehicle."""
    groups = int(firmware.parameters["hlCommander.groupmask"])
    return not any(mask) or bool(mask[0] & groups)


def _vertical(number: int, fields: bytes, refused: str) -> Asked:
    """Return a take-off or landing; the old commands, 1 and 2, have no yaw."""
    if len(fields) < (_OLD if number in (1, 2) else _VERTICAL).size:
        return Asked(CommandKind.PLAN, NAMES[number], refused=refused)
    yaw, keep = 0.0, True
    if number in (1, 2):
        _, height, duration = _OLD.unpack_from(fields)
    else:
        _, height, yaw, keep, duration = _VERTICAL.unpack_from(fields)
    words = f"{NAMES[number]} to {height:.2f} m in {duration:.1f} s"
    return Asked(CommandKind.PLAN, words, (math.nan, math.nan, height), 0.0 if keep else yaw, refused=refused)


def _go_to(number: int, fields: bytes, refused: str) -> Asked:
    layout = _GO if number == _GO_TO[0] else _GO_2
    if len(fields) < layout.size:
        return Asked(CommandKind.PLAN, NAMES[number], refused=refused)
    values = layout.unpack_from(fields)
    relative, (x, y, z, yaw, duration) = bool(values[1]), values[-5:]
    by = "by" if relative else "to"
    words = f"{NAMES[number]} {by} ({x:.2f}, {y:.2f}, {z:.2f}) m in {duration:.1f} s"
    return Asked(CommandKind.PLAN, words, None if relative else (x, y, z), yaw, refused=refused)


def _refusal(answers: list[Packet], firmware: Firmware) -> str:
    """Return why a command of the high-level commander has no effect; empty if it has."""
    result = answers[-1].data[3] if answers and len(answers[-1].data) > 3 else PlannerAnswer.OK
    if not firmware.supervisor.may_fly:
        return _grounded(firmware)
    if result != PlannerAnswer.OK:
        return f"the vehicle answered {PlannerAnswer(result).name}"
    if firmware.commander.priority == Priority.CLIENT:
        return "setpoints have priority until notify_setpoint_stop"
    return ""


def _grounded(firmware: Firmware) -> str:
    """Return why a vehicle may not fly; empty if it may."""
    if firmware.supervisor.may_fly:
        return ""
    starved = firmware.supervisor.is_starved(firmware.now_ms)
    return "the emergency stop watchdog was not fed for 1 s" if starved else "the vehicle is not armed"
