"""A lockstep tick waits for the predictions of the last one, and for a silent neighbour once."""

import numpy as np
from resting_signals import resting_state

from q2q_control.mpc.neighbours.awaited_predictions import AwaitedPredictions
from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import SwarmState, TrackStatus

TICK = 0.01


def state(t: float, lost: str = "") -> SwarmState:
    names = ("cf1", "cf2", "cf3")
    zero = np.zeros((3, 3))
    status = np.array([TrackStatus.LOST if name == lost else TrackStatus.TRACKED for name in names], np.uint8)
    return resting_state(t, names, zero, status=status)


class Received:
    """Newest stamp of every neighbour's prediction."""

    def __init__(self) -> None:
        self.newest: dict[str, float] = {}

    def has(self, name: str, t: float) -> bool:
        """Return whether a prediction made at t [s] or later has arrived."""
        return self.newest.get(name, -1.0) > t - SAME_STAMP


def test_the_first_tick_waits_for_nobody_and_the_second_for_all_neighbours() -> None:
    received = Received()
    awaited = AwaitedPredictions(("cf1",), TICK, received.has)
    assert awaited.complete()
    awaited.begin(state(0.00))
    received.newest["cf2"] = 0.0
    assert not awaited.complete()
    received.newest["cf3"] = 0.0
    assert awaited.complete()


def test_a_silent_neighbour_is_awaited_once_and_again_after_its_next_prediction() -> None:
    received = Received()
    awaited = AwaitedPredictions(("cf1",), TICK, received.has)
    awaited.begin(state(0.00))
    received.newest["cf2"] = 0.0
    assert not awaited.complete()
    awaited.begin(state(0.01))  # the simulator's patience is over
    received.newest["cf2"] = 0.01
    assert awaited.complete()
    received.newest["cf3"] = 0.01
    awaited.begin(state(0.02))
    received.newest["cf2"] = 0.02
    assert not awaited.complete()


def test_a_vehicle_without_state_has_no_prediction_to_wait_for() -> None:
    received = Received()
    awaited = AwaitedPredictions(("cf1",), TICK, received.has)
    awaited.begin(state(0.00, lost="cf3"))
    received.newest["cf2"] = 0.0
    assert awaited.complete()


def test_between_their_slots_neighbours_are_not_awaited() -> None:
    received = Received()
    awaited = AwaitedPredictions(("cf1",), 3.0 * TICK, received.has)
    awaited.begin(state(0.30))  # cf1's slot begins; those of cf2 and cf3 began at 0.28 and 0.29
    received.newest |= {"cf2": 0.28, "cf3": 0.29}
    assert awaited.complete()
    awaited.begin(state(0.31))
    assert not awaited.complete()
    received.newest["cf2"] = 0.31
    assert awaited.complete()


def test_after_a_reset_nobody_is_awaited() -> None:
    awaited = AwaitedPredictions(("cf1",), TICK, Received().has)
    awaited.begin(state(0.00))
    assert not awaited.complete()
    awaited.reset()
    assert awaited.complete()
