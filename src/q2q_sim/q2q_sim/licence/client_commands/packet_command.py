"""Command of a program in a packet.

The meaning of a setpoint is taken from the firmware that has accepted it; commands of the high-level
commander and of the supervisor are read from their packets (q2q_sim.crtp.ports has the formats).
"""

from dataclasses import replace

from q2q_model.signals.values import Three
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1
from q2q_model.vehicle.thrust_map import MASS_THRUST, RPYT_PWM_MIN
from q2q_sim.crtp.packets.packet import Packet, Port
from q2q_sim.crtp.ports import (
    commander_generic,
    localization,
    memory,
    platform,
    supervisor_port,
)
from q2q_sim.crtp.vehicle import ALL_OFF, POWER_DOWN, POWER_UP, RADIO, RESET
from q2q_sim.firmware.commander.planner import PlanState
from q2q_sim.firmware.commander.setpoint import STOP, Mode
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.licence.client_commands.client_command import Asked, CommandKind
from q2q_sim.licence.client_commands.plan_command import PLAN_NAMES, grounded, planned_command
from q2q_sim.licence.client_commands.plan_extent import plan_extent
from q2q_sim.licence.client_commands.plan_reach import reach_violation
from q2q_sim.licence.client_commands.setpoint_text import asked_position, setpoint_text
from q2q_sim.licence.client_commands.uploaded_trajectories import overwritten_trajectory

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
    (Port.PLATFORM, platform.COMMAND, bytes([platform.ARM])),
)
"""Commands to the supervisor: port, channel and first byte."""
_POWER_NAMES = {
    ALL_OFF: "power-down",
    POWER_DOWN: "power-down",
    POWER_UP: "power-up, a reboot",
    RESET: "reboot",
}
"""Commands to the radio, each of which stops the motors."""
LIFTING = CRAZYFLIE_2_0.hover_thrust * MASS_THRUST
"""Thrust of the weight of the vehicles that fly [PWM] (licence_room): less tests motors on the floor, or is
meant for a lighter vehicle."""
COMPLEMENTARY = 1
"""Value of stabilizer.estimator: attitude and height only (firmware: estimator_complementary.c)."""


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
            asked = planned_command(packet.data, answers, firmware)
        case Port.LINK if packet.data[:1] == bytes([RADIO]):
            asked = _powered(packet)
        case Port.MEMORY if packet.channel == memory.WRITE:
            flown = overwritten_trajectory(packet.data, firmware)
            asked = Asked(CommandKind.OTHER, "upload", impossible=flown) if flown else None
        case _:
            asked = _supervised(packet)
    if asked is None or asked.impossible or not _needs_position(asked, firmware):
        return asked
    impossible = _without_position(firmware) or _out_of_reach(asked, firmware)
    return replace(asked, impossible=impossible, extent=_extent(asked, firmware))


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


def _extent(asked: Asked, firmware: Firmware) -> tuple[Three, Three] | None:
    """Return the extent of the plan that a command has begun; None if it has begun none."""
    plan = firmware.planner.trajectory
    return None if asked.kind != CommandKind.PLAN or asked.refused or plan is None else plan_extent(plan)


def malformed_command(packet: Packet) -> Asked | None:
    """Return what a packet asked for that was not handled, as a number is not finite; None if no command."""
    if packet.port not in {Port.SETPOINT, Port.GENERIC, Port.HIGH_LEVEL}:
        return None
    plan = packet.port == Port.HIGH_LEVEL and packet.data
    words = PLAN_NAMES.get(packet.data[0], "command") if plan else "setpoint"
    kind = CommandKind.PLAN if plan else CommandKind.SETPOINT
    return Asked(kind, words, refused="a number is not finite", impossible="a number that is not finite")


def _powered(packet: Packet) -> Asked | None:
    """Return the command of cflib's PowerSwitch in a packet to the radio; None if it has no effect."""
    number = packet.data[1] if len(packet.data) > 1 else 0
    return Asked(CommandKind.OFF, _POWER_NAMES[number]) if number in _POWER_NAMES else None


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
    elif 0 < thrust < RPYT_PWM_MIN and _setpoint(firmware).kind == CommandKind.OFF:
        why = f"the firmware treats a thrust below {RPYT_PWM_MIN} of 65535 as none"
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
    refused = grounded(firmware)
    lifts = moved or one.thrust_pwm >= LIFTING
    return Asked(CommandKind.SETPOINT, setpoint_text(one), asked_position(one), refused=refused, lifts=lifts)
