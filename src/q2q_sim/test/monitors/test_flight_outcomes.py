"""What happened to vehicles is judged where they truly were, whatever policies allow for."""

import numpy as np
import pytest
from judged_hover import HOVER, TICKS, T, flown, moved, output

from q2q_model.flights.flight import of_rows
from q2q_model.signals.values import CommandStatus
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.flight_outcomes import IN_FLIGHT
from q2q_sim.monitors.policies import Circumstances, judge
from q2q_sim.monitors.policies.inputs.trace_from_arrays import trace_from_arrays


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ((0.0, 0.1, 1.0), "cf1 and cf2 collided at 5.6 s, down to 0.10 m apart"),
        ((0.0, 2.7, 1.0), "cf2 left its path at 5.6 s, up to 1.70 m from its setpoint"),
    ],
)
def test_a_displaced_marker_explains_a_failure_and_does_not_undo_it(
    where: tuple[float, float, float], words: str
) -> None:
    flight = flown(moved(5.6, 5.8, 1, where))
    displaced = Circumstances(faults=(Fault("jump", 5.0, 2.0, ("cf2",), -0.5),))
    assert not judge(trace_from_arrays(flight), displaced, IN_FLIGHT)
    said = str(verdict_of(flight, displaced))
    assert said == f"{words} (a marker was displaced: policies allow for it)"
    assert str(verdict_of(flight, Circumstances())) == words
    later = Circumstances(faults=(Fault("jump", 7.0, 2.0, ("cf2",), -0.5),))
    assert str(verdict_of(flight, later)) == words


def test_a_departure_has_the_time_at_which_it_began_and_the_largest_error() -> None:
    """Drifting at 0.5 m/s from 2 s on, 1.5 m off just after 5 s: before the cut, 3.75 m off at the end."""
    away = HOVER.copy()
    away[:, 1, 1] += 0.5 * np.clip(T - 2.0, 0.0, 7.5)
    status = np.zeros((TICKS, 2))
    status[T > 6.995, 1] = CommandStatus.CUT
    departed = "cf2 left its path at 5.0 s, up to 3.75 m from its setpoint"
    cut = "cf2's motors were cut by an emergency stop at 7.0 s"
    assert output(flown(away, status=status)) == f"{departed}; {cut}"


def test_a_collision_has_the_time_of_the_first_contact_and_the_smallest_distance() -> None:
    """cf2 approaches cf1, 1 m away, at 0.2 m/s from 2 s on: 0.14 m apart at 6.3 s, 0.04 m at 6.8 s."""
    near = HOVER.copy()
    near[:, 1, 1] = np.clip(1.0 - 0.2 * (T - 2.0), 0.04, 1.0)
    near[T > 8.0, 1, 1] = 1.0
    assert output(flown(near, near)) == "cf1 and cf2 collided at 6.3 s, down to 0.04 m apart"


def test_a_vehicle_that_never_left_the_floor_did_not_take_off() -> None:
    """Its setpoint exceeds 0.1 m just after 1 s. One that rises later took off, and may fall."""
    path = HOVER.copy()
    path[:, 1, 2] = np.clip(T - 0.9, 0.0, 1.0)
    grounded = HOVER.copy()
    grounded[:, 1, 2] = 0.0
    assert output(flown(grounded, path)) == "cf2 did not take off at 1.0 s"
    grounded[T > 4.0, 1, 2] = 1.0
    assert output(flown(grounded, path)) == "cf2 was still on the floor at 1.0 s"
    grounded[T > 6.0, 1, 2] = 0.0
    assert output(flown(grounded, path)) == "cf2 was still on the floor at 1.0 s; cf2 hit the floor at 6.0 s"


def test_a_part_that_begins_on_the_floor_does_not_show_that_a_vehicle_did_not_take_off() -> None:
    whole = flown(moved(3.0, 20.0, 1, (0.0, 1.0, 0.0)))
    part = of_rows(whole, slice(500, None))
    assert str(verdict_of(part, Circumstances(), whole=whole)) == "cf2 hit the floor at 5.0 s"
