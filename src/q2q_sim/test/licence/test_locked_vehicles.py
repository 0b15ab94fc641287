"""A vehicle that its supervisor locks while it flies, or before it is to fly again, fails the flight."""

import math
from dataclasses import replace

import numpy as np
import pytest
from licence_logs import LIMITS, command, hover

from q2q_sim.firmware.supervisor.rules import State
from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.rules.licence_rules import broken_rules
from q2q_sim.licence.rules.motion_rules import locked_rule

FED = command(0.5, CommandKind.WATCHDOG, "feeding")
RISES, LANDED = 150, 950
"""Ticks at which the vehicle is at 0.255 m, and on the floor."""


def locked(tick: int, *more: object, until: int = 1000) -> LicenceLog:
    """Return a sound flight whose vehicle is locked from a tick on, at the height that it has."""
    log = hover()
    state, running = log.state.copy(), log.running.copy()
    state[tick:until], running[tick:until] = State.LOCKED, False
    return replace(log, state=state, running=running, commands=(*log.commands, FED, *more))


def test_a_vehicle_that_is_locked_just_above_the_floor_fails_with_the_reason() -> None:
    tick = int(np.argmax(hover().pos[:, 0, 2] > 0.1))
    fed = command(0.01 * (tick + 1) - 1.0, CommandKind.WATCHDOG, "feeding")
    found = locked_rule(locked(tick, fed), 0, LIMITS)
    assert found is not None
    assert (found.rule, found.t) == ("locked", pytest.approx(0.01 * (tick + 1)))
    assert found.what == "the supervisor locks cf1 at a height of 0.10 m"
    assert found.why == f"no other came for 1 s after {fed.words}"


def test_a_higher_one_is_left_to_the_rule_of_motors() -> None:
    assert hover().pos[RISES, 0, 2] > LIMITS.drop
    found = broken_rules(locked(RISES), LIMITS)
    assert [one.rule for one in found] == ["motors"]


def test_a_vehicle_that_is_locked_on_the_floor_fails_if_it_is_asked_to_fly_before_a_reboot() -> None:
    takes_off = command(9.8, CommandKind.PLAN, "takeoff")
    found = locked_rule(locked(LANDED, takes_off), 0, LIMITS)
    assert found is not None
    assert found.what == (
        "the supervisor locks cf1 at a height of 0.00 m, and it does not follow takeoff at 9.80 s, line 7"
    )
    assert locked_rule(locked(LANDED), 0, LIMITS) is None
    assert locked_rule(locked(LANDED, takes_off, until=975), 0, LIMITS) is None
    lands = command(9.8, CommandKind.PLAN, "land", pos=(math.nan, math.nan, 0.0))
    assert locked_rule(locked(LANDED, lands), 0, LIMITS) is None
    weak = command(9.8, CommandKind.SETPOINT, "setpoint", lifts=False)
    assert locked_rule(locked(LANDED, weak), 0, LIMITS) is None


def test_an_emergency_stop_of_the_program_is_no_fault() -> None:
    stop = command(9.5, CommandKind.EMERGENCY, "emergency stop")
    takes_off = command(9.8, CommandKind.PLAN, "takeoff")
    assert locked_rule(locked(LANDED, stop, takes_off), 0, LIMITS) is None
