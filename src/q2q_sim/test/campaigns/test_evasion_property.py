"""Evasion of a lost vehicle is judged by the first change of the acceleration commanded near it."""

import math
from functools import cache

import numpy as np
import pytest
from resting_signals import level_command, resting_setpoint, resting_state

from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import (
    TrackStatus,
)
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.campaigns.falsification.counterexample import with_faults
from q2q_sim.campaigns.falsification.postconditions.evasion_property import (
    CLEAR,
    LEAST_ACC,
    NEAR,
    evasion,
)
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run
from q2q_sim.faults.faults import Fault

LOST, END = 350, 400
"""Ticks in which cf2 is lost, and after the flight."""


@cache
def two_vehicles() -> Run:
    """Return a run of cf1 and cf2 by the PID without faults."""
    runs = (run for run in map(draw_run, range(100)) if run.options.controller == "pid")
    return with_faults(next(run for run in runs if run.scenario.names == ("cf1", "cf2")), ())


def encounter(distance: float, away: float, aside: float = 0.0, height: float = 2.0) -> RunTicks:
    """Return a flight in which cf2 is lost at a `height`, and cf1 is `distance` further along x 1 m high.

    The accelerations that cf1 is commanded from then on lead `away` along x and `aside` along y [m/s^2].
    """
    names, flat = ("cf1", "cf2"), np.zeros(2)
    pos = np.array([[distance, 0.0, 1.0], [0.0, 0.0, height]])
    states, setpoints, commands = [], [], []
    for k in range(END):
        gone = k >= LOST
        status = np.array([TrackStatus.TRACKED, TrackStatus.LOST if gone else TrackStatus.TRACKED], np.uint8)
        age = np.array([0.0, max(k - LOST + 35, 0) * TICK_S])
        states.append(resting_state(k * TICK_S, names, pos, age=age, status=status))
        setpoints.append(resting_setpoint(k * TICK_S, names, pos))
        roll = np.array([-math.atan(aside / GRAVITY) if gone else 0.0, 0.0])
        pitch = np.array([math.atan(away / GRAVITY) if gone else 0.0, 0.0])
        commands.append(level_command(k * TICK_S, names, flat, roll=roll, pitch=pitch))
    t = np.array([k * TICK_S for k in range(END)])
    return RunTicks(t, t, names, tuple(states), tuple(states), tuple(setpoints), tuple(commands), ())


@pytest.mark.parametrize(
    ("distance", "away", "aside", "value", "margin"),
    [
        (0.2, 2.0, 0.0, None, 1.0),  # away
        (0.2, 0.0, -2.0, None, 1.0),  # across
        (0.2, -2.0, 0.0, -2.0, -3.0),  # towards
        (0.2, -0.3, -2.0, None, 0.4),  # across, and a little towards
        (0.2, 0.2, 0.0, 0.2, 0.2 / NEAR - 1.0),  # too little
        (0.5 * CLEAR, -2.0, 0.0, None, 1.0),  # no direction is known
        (0.5, -2.0, 0.0, -2.0, -3.0),  # towards from further away
        (0.5, 0.0, 0.0, None, 0.5 / NEAR - 1.0),  # too far to have to evade
        (2.0 * NEAR, 0.1, 0.0, None, 1.0),
    ],
)
def test_the_first_change_of_acceleration_is_an_evasion(
    distance: float, away: float, aside: float, value: float | None, margin: float
) -> None:
    found = evasion(two_vehicles(), encounter(distance, away, aside))
    assert [one.who for one in found.violations] == ([] if value is None else ["cf1"])
    assert all(one.value == pytest.approx(value) and one.limit == LEAST_ACC for one in found.violations)
    assert found.margin == pytest.approx(margin)


@pytest.mark.parametrize(("height", "judged"), [(0.6, True), (0.4, False)])
def test_one_that_is_lost_little_below_is_evaded_too(height: float, judged: bool) -> None:
    found = evasion(two_vehicles(), encounter(0.2, -2.0, height=height))
    assert [(one.who, one.value) for one in found.violations] == judged * [("cf1", pytest.approx(-2.0))]


MEASURED = (LOST - 35) * TICK_S
"""When cf2 is measured for the last time [s]."""


@pytest.mark.parametrize(
    ("fault", "judged"),
    [
        (Fault("jump", MEASURED - 2.0, 0.9, ("cf2",), 0.3), True),
        (Fault("jump", MEASURED - 2.0, 1.5, ("cf2",), 0.3), False),
        (Fault("jump", MEASURED + 0.1, 2.0, ("cf2",), 0.3), True),
        (Fault("jump", MEASURED + 0.1, 2.0, ("cf1",), 0.3), False),  # still measured
        (Fault("radio_loss", MEASURED + 0.1, 0.1, ("cf2",), 1.0), False),
        (Fault("dropout", MEASURED, 1.0, ("cf2",)), True),
        (Fault("stale", LOST * TICK_S - 0.2, 0.195), False),  # the state of cf1 steps in the next tick
        (Fault("stale", MEASURED + 0.1, 0.1), True),
    ],
)
def test_evasion_is_judged_unless_a_fault_hides_where_either_vehicle_is(fault: Fault, judged: bool) -> None:
    found = evasion(with_faults(two_vehicles(), (fault,)), encounter(0.2, -2.0))
    assert bool(found.violations) == judged
