"""States and transition rules of the firmware's supervisor.

Source: firmware: modules/src/supervisor_state_machine.c. The rules of a state are tried in order; the first
that fires decides. A rule without conditions always fires.
"""

from dataclasses import dataclass
from enum import IntEnum, IntFlag


class State(IntEnum):
    """States of the supervisor; numbers as in the firmware."""

    NOT_INITIALIZED = 0
    CHECKS_NOT_PASSED = 1
    CHECKS_PASSED = 2
    ARMING = 3
    READY_TO_FLY = 4
    FLYING = 5
    LANDED = 6
    RESET = 7
    LEVEL_OUT = 8
    FREE_FALL = 9
    LOCKED = 10
    CRASHED = 11


class Condition(IntFlag):
    """Conditions of the rules; bits as in the firmware."""

    NONE = 0
    ARMED = 1
    IS_FLYING = 2
    TUMBLED = 4
    SETPOINT_OLD = 8
    """COMMANDER_WDT_WARNING: 0.5 s."""
    SETPOINT_DEAD = 16
    """COMMANDER_WDT_TIMEOUT: 2 s."""
    EMERGENCY_STOP = 32
    CRASHED = 64
    PREFLIGHT_TIMEOUT = 128
    LANDING_TIMEOUT = 256


@dataclass(frozen=True, slots=True)
class Rule:
    """Transition to another state with its conditions."""

    to: State
    if_set: Condition = Condition.NONE
    """Fires when any of these is set,"""
    if_clear: Condition = Condition.NONE
    """or any of these is clear,"""
    if_all_clear: Condition = Condition.NONE
    """or all of these are clear;"""
    unless: Condition = Condition.NONE
    """but not while any of these is set."""

    def fires(self, now: Condition) -> bool:
        """Return whether the rule fires under these conditions."""
        if now & self.unless:
            return False
        if not (self.if_set | self.if_clear | self.if_all_clear):
            return True
        cleared = bool(self.if_all_clear) and not now & self.if_all_clear
        return bool(now & self.if_set) or bool(~now & self.if_clear) or cleared


_STOP = Rule(State.FREE_FALL, if_set=Condition.EMERGENCY_STOP)

RULES: dict[State, tuple[Rule, ...]] = {
    State.NOT_INITIALIZED: (Rule(State.CHECKS_NOT_PASSED),),
    State.CHECKS_NOT_PASSED: (_STOP, Rule(State.CHECKS_PASSED, unless=Condition.TUMBLED)),
    State.CHECKS_PASSED: (
        _STOP,
        Rule(State.CHECKS_NOT_PASSED, if_set=Condition.TUMBLED),
        Rule(State.ARMING, if_set=Condition.ARMED),
    ),
    State.ARMING: (
        _STOP,
        Rule(State.CHECKS_NOT_PASSED, if_set=Condition.TUMBLED, if_clear=Condition.ARMED),
        Rule(State.READY_TO_FLY),  # brushed motors have no speed to wait for
    ),
    State.READY_TO_FLY: (
        _STOP,
        Rule(
            State.CHECKS_NOT_PASSED,
            if_set=Condition.TUMBLED | Condition.PREFLIGHT_TIMEOUT,
            if_clear=Condition.ARMED,
        ),
        Rule(State.FLYING, if_set=Condition.IS_FLYING),
    ),
    State.FLYING: (
        Rule(State.FREE_FALL, if_set=Condition.SETPOINT_DEAD | Condition.EMERGENCY_STOP),
        Rule(State.CRASHED, if_set=Condition.TUMBLED),
        Rule(State.RESET, if_clear=Condition.ARMED),
        Rule(State.LEVEL_OUT, if_set=Condition.SETPOINT_OLD),
        Rule(State.LANDED, if_clear=Condition.IS_FLYING),
    ),
    State.LANDED: (
        Rule(State.RESET, if_set=Condition.LANDING_TIMEOUT, if_clear=Condition.ARMED),
        Rule(State.FLYING, if_set=Condition.IS_FLYING),
    ),
    State.RESET: (Rule(State.CHECKS_NOT_PASSED),),
    State.LEVEL_OUT: (
        Rule(
            State.FREE_FALL,
            if_set=Condition.SETPOINT_DEAD | Condition.TUMBLED | Condition.EMERGENCY_STOP,
        ),
        Rule(State.FLYING, if_clear=Condition.SETPOINT_OLD),
    ),
    State.FREE_FALL: (Rule(State.LOCKED),),
    State.LOCKED: (),
    State.CRASHED: (
        Rule(State.CHECKS_NOT_PASSED, if_all_clear=Condition.CRASHED | Condition.TUMBLED),
        Rule(State.LOCKED, if_set=Condition.EMERGENCY_STOP),
    ),
}

MAY_FLY = frozenset((State.READY_TO_FLY, State.FLYING, State.LEVEL_OUT, State.LANDED))
"""Setpoints are flown."""
MOTORS_MAY_RUN = MAY_FLY | {State.ARMING}
STAYS_ARMED = MOTORS_MAY_RUN
"""Every other state disarms."""


def next_state(state: State, now: Condition) -> State:
    """Return the state that follows under these conditions; the same where no rule fires."""
    for rule in RULES[state]:
        if rule.fires(now):
            return rule.to
    return state
