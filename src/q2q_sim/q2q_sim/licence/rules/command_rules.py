"""Rules of what one vehicle is commanded: setpoints, yaw, command, end, idle."""

import math

import numpy as np

from q2q_model.vehicle.setpoint_watchdog import LEVEL_AFTER_S
from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import FLIGHT
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.room.trials import TrialKind
from q2q_sim.licence.rules.broken_rule import BrokenRule, first_tick
from q2q_sim.licence.rules.licence_limits import LicenceLimits

LEVEL_SHARE = 0.1
"""Share of its flight for which a vehicle is levelled out that breaks the rule [-]."""


def setpoints_rule(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    """Return where the age of setpoints levels a vehicle out."""
    levelled = (log.state[:, row] == State.LEVEL_OUT) & log.airborne[:, row]
    begins = np.flatnonzero(levelled[1:] & ~levelled[:-1]) + 1
    share = levelled.sum() / max(int(log.airborne[:, row].sum()), 1)
    if len(begins) < 2 or share < LEVEL_SHARE:
        return None
    t = float(log.t[begins[0]])
    why = f"{len(begins)} times no setpoint came for {LEVEL_AFTER_S} s, {share:.0%} of its flight"
    return BrokenRule("setpoints", t, f"the firmware levels {log.name(row)} out", why)


def yaw_rule(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    """Return the command that asks for more than a turn."""
    last = 0.0
    for one in log.of(row):
        if one.asked.yaw_rad == 0.0:  # most commands have none
            continue
        step, last = abs(one.asked.yaw_rad - last), one.asked.yaw_rad
        if abs(last) > 2.0 * math.pi and step > limits.yaw_step:
            what = f"{log.name(row)} is asked to turn to {one.asked.yaw_rad:.1f} rad"
            return BrokenRule("yaw", one.t, what, f"{one.words_without_time}, whose yaw is in radians")
    return None


def command_rule(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    """Return the command that no vehicle can follow."""
    for one in log.of(row):
        if one.asked.impossible:
            what = f"{log.name(row)} is asked for {one.asked.impossible}"
            return BrokenRule("command", one.t, what, one.words_without_time)
    return None


def end_rule(log: LicenceLog, row: int, _: LicenceLimits) -> BrokenRule | None:
    """Return the vehicle that still flies at the end."""
    if not (log.airborne[-1, row] and log.running[-1, row]):
        return None
    t, end = float(log.t[-1]), log.end
    when = "at the time limit" if end.overdue else f"{t - end.t:.0f} s after the end of the program"
    what = f"{log.name(row)} still flies {when}"
    last = log.last(row, t)
    return BrokenRule("end", t, what, f"the last command was {last.words}" if last else "")


def idle_rule(log: LicenceLog, row: int, limits: LicenceLimits) -> BrokenRule | None:
    """Return the vehicle that never flew though it was asked to, or was connected while others flew.

    A flight that was ended at the time limit has no rest in which a vehicle could rise or be asked to.
    """
    if log.trial.kind != TrialKind.NOMINAL or log.flew[row]:
        return None
    asked = [one for one in log.of(row) if one.asked.kind in FLIGHT and one.asked.lifts]
    if asked:
        what = f"{log.name(row)} is asked to fly and stays on the floor"
        first = asked[0]
        if log.end.overdue and not first.asked.refused and log.end.t - first.t < limits.rise_s:
            return None
        why = f"{first.asked.refused}, {first.words}" if first.asked.refused else first.words
        return BrokenRule("idle", first.t, what, why)
    if row in log.opened and log.flew.any() and not log.end.overdue:
        t = float(log.t[first_tick(np.asarray(log.airborne.any(axis=1)))])
        return BrokenRule("idle", t, f"{log.name(row)} stays on the floor", "it was never asked to fly")
    return None
