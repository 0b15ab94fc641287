"""Setpoints are flown until they jump or stay away."""

import numpy as np
from resting_signals import resting_setpoint

from q2q_control.flight_procedure.flight_view import FlightView
from q2q_control.flight_procedure.state_machine.setpoint_stream import SetpointStream
from q2q_model.signals.values import Array, Names, SwarmSetpoint

PAIR = ("cf1", "cf2")


def at(*x: float) -> Array:
    return np.array([[one, 0.0, 1.0] for one in x])


def flies(stream: SetpointStream, pos: Array) -> bool:
    stream.take(pos)
    return stream.flies


def setpoint(names: Names, pos: Array) -> SwarmSetpoint:
    return resting_setpoint(0.0, names, pos)


def test_a_jump_over_an_absence_is_one() -> None:
    stream = SetpointStream(step_max=0.3, timeout_s=2.0)
    stream.start(0.0)
    for pos in (at(0.0, 1.0), at(0.2, np.nan), at(0.4, np.nan), at(0.6, 1.25), at(0.8, np.nan)):
        assert flies(stream, pos)
    assert not flies(stream, at(1.0, 1.6))
    assert "0.35 m" in stream.take_fault({}, 0.0)


def test_a_fault_of_a_stream_that_was_stopped_is_none_of_the_next() -> None:
    stream = SetpointStream(step_max=0.3, timeout_s=2.0)
    stream.start(0.0)
    assert flies(stream, at(0.0))
    assert not flies(stream, at(1.0))
    stream.stop()
    stream.start(0.0)
    assert stream.take_fault({}, 0.0) == ""
    assert flies(stream, at(1.1))


def test_what_stays_away_for_longer_than_the_timeout_since_the_start_is_a_fault() -> None:
    stream = SetpointStream(step_max=0.3, timeout_s=1.0)
    stream.start(10.0)
    never_sent = {"no setpoint": 0.0, "nothing sent to cf1": np.nan, "nothing sent to cf2": np.inf}
    assert stream.take_fault(never_sent, 11.0) == ""
    assert stream.take_fault(never_sent, 11.25) == "nothing sent to cf2 for 1.25 s"
    assert stream.take_fault({"nothing sent to cf2": 1.5}, 20.0) == "nothing sent to cf2 for 1.50 s"


def test_a_setpoint_of_nobody_is_none_of_each() -> None:
    view = FlightView(PAIR)
    assert np.isnan(view.store_setpoint(setpoint((), np.zeros((0, 3))), 0.0)).all()
    seen = view.store_setpoint(setpoint(("cf2",), at(3.0)), 0.1)
    np.testing.assert_array_equal(seen, [[np.nan] * 3, [3.0, 0.0, 1.0]])
