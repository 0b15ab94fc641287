"""Vehicles far from their setpoints are reported once for the same vehicles; lost, unplanned ones are not."""

from dataclasses import replace

import numpy as np
import pytest
from pid_swarms import swarm

from q2q_control.inputs.far_setpoints import FarSetpointMonitor, far_setpoints
from q2q_model.signals.values import Array, SwarmState, TrackStatus

NAMES = ("cf1", "cf2")


def at(*pos: tuple[float, float, float], status: Array | None = None) -> SwarmState:
    """Return the states of vehicles at positions [m]."""
    state = swarm(NAMES)[0]
    return replace(state, pos=np.array(pos), status=state.status if status is None else status)


def test_who_is_a_metre_away_or_more_is_far_in_any_direction() -> None:
    setpoint = swarm(NAMES)[1]
    assert far_setpoints(at((0.0, 0.0, 0.999), (0.6, -0.8, 0.0)), setpoint, NAMES) == {
        "cf2": pytest.approx(1.0)
    }
    lost = np.array([TrackStatus.TRACKED, TrackStatus.LOST], dtype=np.uint8)
    assert far_setpoints(at((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), status=lost), setpoint, NAMES) == {}
    other = replace(setpoint, names=("cf2", "cf7"))
    assert far_setpoints(at((3.0, 0.0, 0.0), (0.0, 2.0, 0.0)), other, NAMES) == {"cf2": pytest.approx(2.0)}


def test_who_the_failsafe_brought_down_is_reported_until_it_is_back_and_asked_for_no_plan() -> None:
    monitor, setpoint = FarSetpointMonitor(), swarm(NAMES)[1]
    lost = np.array([TrackStatus.LOST, TrackStatus.TRACKED], dtype=np.uint8)
    landing = at((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), status=lost)
    landed, near = at((0.0, 0.0, 1.5), (0.0, 0.0, 0.0)), at((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert monitor.update(landing, setpoint, NAMES, ("cf1",)) == ("", False)
    message = "far from their setpoints, brought down by the failsafe: cf1 1.5 m"
    assert [monitor.update(landed, setpoint, NAMES) for _ in range(2)] == [(message, True), (message, False)]
    both = at((0.0, 0.0, 1.5), (0.0, 2.0, 0.0))
    asked = "far from their setpoints: cf2 2.0 m: check that the plan begins where they fly"
    assert monitor.update(both, setpoint, NAMES) == (f"{asked}; {message}", True)
    assert monitor.update(near, setpoint, NAMES) == ("", False)
    assert monitor.update(landed, setpoint, NAMES)[0].endswith(
        "cf1 1.5 m: check that the plan begins where they fly"
    )


def test_vehicles_of_another_controller_are_not_looked_at() -> None:
    setpoint, away = swarm(NAMES)[1], at((0.0, 0.0, 2.0), (0.0, 3.0, 0.0))
    assert far_setpoints(away, setpoint, ("cf2",)) == {"cf2": pytest.approx(3.0)}
    assert FarSetpointMonitor().update(away, setpoint, ("cf7",)) == ("", False)


def test_the_same_vehicles_are_new_once_until_they_are_back() -> None:
    monitor, setpoint = FarSetpointMonitor(), swarm(NAMES)[1]
    near, far = at((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), at((0.0, 0.0, 2.34), (0.0, 0.0, 0.0))
    message = "far from their setpoints: cf1 2.3 m: check that the plan begins where they fly"
    assert [monitor.update(one, setpoint, NAMES) for one in (near, far, far)] == [
        ("", False),
        (message, True),
        (message, False),
    ]
    assert monitor.update(at((0.0, 0.0, 2.0), (5.0, 0.0, 0.0)), setpoint, NAMES)[1]
    assert not monitor.update(far, setpoint, NAMES)[1]
    assert [monitor.update(one, setpoint, NAMES)[1] for one in (near, far)] == [False, True]
