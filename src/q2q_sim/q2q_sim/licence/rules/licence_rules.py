"""Rules of a licence: what a vehicle must not do in a program's flight, and when it first did.

| rule | broken when |
|---|---|
| motors | the motors stop for `stopped_s` more than `drop` above the floor |
| landing | a vehicle reaches the floor faster than `landing` |
| locked | the supervisor locks it in the air, or before it is asked to fly again; not above `drop` |
| room | it leaves the room, or a command or part of a plan leads out, as more than `depth` below the floor |
| collision | two vehicles touch, within `gap` of each other; only a remark if one has lost its link |
| downwash | two fly within an ellipsoid of `beside` and `below` for `exposed_s`; nominal flight only |
| tumble | the supervisor finds a vehicle tumbled |
| setpoints | their age levels a vehicle out at least twice, and for LEVEL_SHARE of its flight |
| spin | it turns faster than `spin` for `spun_s` |
| yaw | the high-level commander, whose unit is rad, is asked for more than a turn, half a turn at once |
| command | it is asked for what no vehicle can follow (client_commands) |
| end | it still flies REST_S after the end of the program, or at the time limit |
| program | the program fails, dies, does not end, or opens more vehicles than there are |
| idle | a vehicle was asked to fly and never did, or was connected and never asked while others flew |

The limits in code font are those of LicenceLimits, LEVEL_SHARE is in command_rules, REST_S in program_flight
(where a flight goes on for so long). MotionCommander of cflib itself stops the motors 0.1 m
above the floor. Between notify_setpoint_stop and the command after it the firmware stops them, too, for a
packet or two: a fall of millimetres. The ellipsoid is that of Hoenig et al., Trajectory Planning for
Quadrotor Swarms, IEEE T-RO 2018.
"""

from collections.abc import Callable

import numpy as np

from q2q_sim.licence.program_process.program_lines import IN_GET_VALUE
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.room.trials import EXEMPT, TrialKind
from q2q_sim.licence.rules.broken_rule import BrokenRule
from q2q_sim.licence.rules.command_rules import (
    command_rule,
    end_rule,
    idle_rule,
    setpoints_rule,
    yaw_rule,
)
from q2q_sim.licence.rules.licence_limits import LicenceLimits
from q2q_sim.licence.rules.motion_rules import (
    landing_rule,
    locked_rule,
    motors_rule,
    room_rule,
    spin_rule,
    tumble_rule,
)
from q2q_sim.licence.rules.pair_rules import nearness

LicenceRule = Callable[[LicenceLog, int, LicenceLimits], BrokenRule | None]

RULES: tuple[LicenceRule, ...] = (
    motors_rule, landing_rule, locked_rule, room_rule, tumble_rule, setpoints_rule, spin_rule, yaw_rule,
    command_rule, end_rule, idle_rule,
)  # fmt: skip
"""Rules of one vehicle."""

UNKNOWN_NAME = ("not in TOC", "not in param TOC", IN_GET_VALUE)
"""Words in errors about a log variable, or a parameter set or read, that the firmware does not have."""
MAY_BE_LACKING = "; the emulated firmware lacks many names of the stock firmware (docs/licence.md, Limits)"
"""Added to such an error."""


def broken_rules(log: LicenceLog, limits: LicenceLimits) -> tuple[BrokenRule, ...]:
    """Return the broken rules of a flight in the order of time."""
    found = [one for one in (_program(log), *nearness(log, limits)) if one is not None]
    for row in range(len(log.uris)):
        if row != log.trial.exempt:
            checked = [rule(log, row, limits) for rule in RULES]
            found += [one for one in checked if one is not None]
    return tuple(sorted(found, key=lambda one: one.t))


def _program(log: LicenceLog) -> BrokenRule | None:
    end, trial = log.end, log.trial
    rows = [row for row in range(len(log.uris)) if row != trial.exempt]
    if end.unknown:
        why = f"{end.unknown} is one more than {len(log.uris)}"
        return BrokenRule("program", end.t, "the program opens more vehicles than there are", why)
    if trial.kind in EXEMPT:
        return None
    if end.overdue:
        return BrokenRule("program", end.t, "the program does not end", end.waits)
    if not end.status:
        return None
    tick = min(int(np.searchsorted(log.t, end.t)), len(log.t) - 1)
    safe = trial.kind != TrialKind.NOMINAL and not log.airborne[tick, rows].any()
    where = f", line {end.line}" if end.line else ""
    why = (end.error or f"exit status {end.status}") + where
    if any(words in end.error for words in UNKNOWN_NAME):
        why += MAY_BE_LACKING
    return None if safe else BrokenRule("program", end.t, "the program fails", why)
