"""Cause of what a vehicle did: the command, or the silence, before it."""

import numpy as np

from q2q_model.vehicle.setpoint_watchdog import CUT_AFTER_S
from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import FLIGHT, ClientCommand, CommandKind
from q2q_sim.licence.room.licence_log import LicenceLog

JUST_S = 0.5
"""Time within which a command is the cause of what follows it [s]: a fall from the ceiling takes 0.7 s."""
SHUT = frozenset((State.FREE_FALL, State.LOCKED))
ENDS = frozenset((CommandKind.OFF, CommandKind.EMERGENCY))
FED_S = 1.0
"""Time in which the watchdog of the emergency stop, once started, is to be fed [s]."""


def failure_cause(log: LicenceLog, row: int, t: float) -> str:
    """Return why a vehicle did at t [s] what it did, in words."""
    starved = starved_watchdog(log, row, t)
    if starved:
        return starved
    ending = _ending(log, row, t)
    if ending is not None:
        return _closed_by_error(log, ending) or ending.words
    tick = min(round(t / log.tick), len(log.t) - 1)
    if log.age[tick, row] >= CUT_AFTER_S and log.state[tick, row] in SHUT:
        return _silence(log, row, t)
    ignored = _ignored(log, row, t)
    if ignored:
        return ignored
    last = log.last(row, t)
    return f"the last command was {last.words}" if last else "there was no command"


def starved_watchdog(log: LicenceLog, row: int, t: float) -> str:
    """Return that the watchdog of the emergency stop had stopped a vehicle by t [s]; or nothing."""
    shut = np.isin(log.state[: round(t / log.tick), row], list(SHUT))
    if not shut.any():
        return ""
    first = int(np.argmax(shut))
    if not log.running[max(first - 1, 0), row]:  # its motors had stopped before
        return ""
    stopped = float(log.t[first])
    fed = log.last(row, stopped, lambda one: one.asked.kind == CommandKind.WATCHDOG)
    if fed is None or stopped - fed.t < FED_S - log.tick:  # it counts from the tick before
        return ""
    return f"no other came for {FED_S:.0f} s after {fed.words}"


def _closed_by_error(log: LicenceLog, ending: ClientCommand) -> str:
    """Return the error of the program that closed a link; empty if it was closed without."""
    if not (ending.closing and log.end.status):
        return ""
    where = f", line {log.end.line}" if log.end.line else ""
    said = log.end.error or f"exit status {log.end.status}"
    return f"the program failed ({said}{where}), which closed the link at {ending.t:.2f} s"


def _ending(log: LicenceLog, row: int, t: float) -> ClientCommand | None:
    """Return the first command that ends flight after the last that asks for it, and was followed."""
    before = [one for one in log.of(row) if one.t <= t]
    asked = max((k for k, one in enumerate(before) if one.asked.kind in FLIGHT), default=-1)
    ends = (one for one in before[asked + 1 :] if one.asked.kind in ENDS)
    return next((one for one in ends if not _flown_after(log, row, one, t)), None)


def _flown_after(log: LicenceLog, row: int, ending: ClientCommand, t: float) -> bool:
    """Return whether a vehicle flew on for long after a command that ends flight."""
    return bool(log.running[(log.t > ending.t + JUST_S) & (log.t <= t), row].any())


def _silence(log: LicenceLog, row: int, t: float) -> str:
    """Return the words for the firmware's watchdog."""
    last = log.last(row, t, lambda one: one.asked.kind == CommandKind.SETPOINT)
    after = f" after {last.words}" if last else ""
    ignored = _ignored(log, row, t)
    return f"no setpoint came for {CUT_AFTER_S:.0f} s{after}{f'; {ignored}' if ignored else ''}"


def _ignored(log: LicenceLog, row: int, t: float) -> str:
    """Return the last command that asks for flight, or else the last plan, that a vehicle did not follow."""
    last = log.last(row, t, lambda one: one.asked.kind in FLIGHT)
    plan = log.last(row, t, lambda one: one.asked.kind == CommandKind.PLAN)
    refused = (one for one in (last, plan) if one is not None and one.asked.refused)
    return next((f"{one.words}, was not followed: {one.asked.refused}" for one in refused), "")
