"""The guard where no ticks come, and what it does with late ones."""

from dataclasses import replace

import numpy as np
import pytest
from guarded_flights import (
    CUT,
    DEGRADED,
    HOLD,
    HOVER,
    LAND,
    LEVEL,
    OK,
    PARAMS,
    TICK,
    Level,
    fly,
    guarded,
    pid,
    setpoint_at,
    state_at,
)

from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.input_deadline import InputDeadline
from q2q_control.failsafe.tracking_loss.braking_law import BRAKING_MAX, BRAKING_S
from q2q_model.signals.values import SwarmCommand
from q2q_model.vehicle.constants import GRAVITY


def test_lateness_and_the_filters_age_add_up_with_and_without_ticks() -> None:
    guard = Guard(pid(), PARAMS, HOVER, lateness=lambda _: 0.03)
    for k in range(10):
        output = guard.update(state_at(k * TICK, (0.03, 0.0)), setpoint_at(k * TICK), None)
    assert output.status.tolist() == [DEGRADED, OK]
    old = Guard(pid(), PARAMS, HOVER, lateness=lambda _: 0.01)
    for k in range(10):
        output = old.update(state_at(k * TICK, (0.045, 0.0)), setpoint_at(k * TICK), None)
    assert output.status.tolist() == [DEGRADED, OK]
    calm = Guard(pid(), PARAMS, HOVER, lateness=lambda _: 0.02)
    for k in range(10):
        calm.update(state_at(k * TICK), setpoint_at(k * TICK), None)
    quiet = calm.without_tick(4.97)
    late = calm.without_tick(4.99)
    assert quiet is not None
    assert late is not None
    assert (quiet.status[0], late.status[0]) == (LAND, CUT)


def test_without_ticks_all_are_held_then_level_then_land_then_cut() -> None:
    guard = guarded()
    last = fly(guard, 0, 10)[-1]
    assert guard.without_tick(0.029) is None
    found = {age: guard.without_tick(age) for age in (0.03, 0.10, 1.0, 4.99, 5.0)}
    statuses = {age: command.status.tolist() for age, command in found.items() if command is not None}
    assert statuses == {
        0.03: [HOLD] * 2,
        0.10: [LEVEL] * 2,
        1.0: [LAND] * 2,
        4.99: [LAND] * 2,
        5.0: [CUT] * 2,
    }
    held = found[0.03]
    assert held is not None
    np.testing.assert_array_equal(held.pitch, last.pitch)
    assert held.t == pytest.approx(last.t + 0.03)
    # cut stays, though ticks come again
    assert fly(guard, 600, 601)[0].status.tolist() == [CUT] * 2


def test_without_ticks_a_swarm_that_flew_brakes_to_rest_and_one_that_hovered_stays_level() -> None:
    """Its body's z axis follows the command at once; the reckoning allows for a lag only before it begins."""
    for speed in (0.0, 1.0):
        guard = Guard(Level(), PARAMS, HOVER)
        for k in range(20):
            moving = replace(state_at(k * TICK), vel=np.tile([speed, 0.0, 0.0], (2, 1)))
            guard.update(moving, setpoint_at(k * TICK), None)
        vel, most = speed, 0.0
        for k in range(1, 300):
            output = guard.without_tick(max(k * TICK, PARAMS.hold_after_s))
            assert output is not None
            vel += TICK * GRAVITY * np.tan(output.pitch[0])
            most = max(most, abs(float(output.pitch[0])))
        assert abs(vel) < 0.02 * speed + 1e-12
        assert most == pytest.approx(np.arctan(min(speed / BRAKING_S, BRAKING_MAX) / GRAVITY))


@pytest.mark.parametrize("frames", [(0.19,), (0.19,) * 12, (0.19, 0.16)])
def test_live_old_frames_change_nothing_that_the_wall_clock_commands(frames: tuple[float, ...]) -> None:
    """They get its command, down to the cut; the reckoning goes by the timer, however many frames come."""
    calm, disturbed = guarded(Level()), guarded(Level())
    for k in range(20):
        moving = replace(state_at(k * TICK), vel=np.tile([1.0, 0.0, 0.0], (2, 1)))
        for guard in (calm, disturbed):
            guard.update(moving, setpoint_at(k * TICK), None)
            guard.without_tick(0.0)  # a timer asks
    for k in range(1, 510):
        due, same = calm.without_tick(k * TICK), disturbed.without_tick(k * TICK)
        again = [disturbed.update(replace(moving, t=t), setpoint_at(t), None) for t in frames]
        if due is not None and same is not None:
            assert same.t == due.t
            assert [one.t for one in again] == list(frames)
            assert all(_values(one) == _values(due) for one in (same, *again))
    assert due is not None
    assert due.status.tolist() == [CUT, CUT]


def test_nothing_is_sent_before_the_first_tick_ever() -> None:
    assert guarded().without_tick(10.0) is None
    assert InputDeadline(guarded(), PARAMS).due(state_at(0.0), 10.0) is None


def _values(command: SwarmCommand) -> list[list[float]]:
    return [part.tolist() for part in (command.thrust, command.roll, command.pitch, command.status)]
