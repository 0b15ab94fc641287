"""Signals within a process: everybody receives everything in order, and the world gets the answer first."""

import numpy as np
import pytest

from q2q_model.signals.local_bus import LocalBus
from q2q_model.signals.values import Interference


def signal(t: float) -> Interference:
    none = np.zeros((0, 3))
    return Interference(t, (), none, none, np.zeros(0, np.uint8))


def test_the_command_is_published_before_what_led_to_it() -> None:
    bus, world = LocalBus(("state", "reference_safe", "command")), []
    for source, made in (("state", "reference_safe"), ("reference_safe", "command")):
        bus.listen(
            source,
            lambda stamp, value, made=made: bus.post(made, stamp, value, lambda: world.append(made)),
        )
    bus.post("state", 7, signal(7e-9), lambda: world.append("state"))
    assert world == ["command", "state", "reference_safe"]


def test_every_listener_hears_every_signal_in_the_order_of_posting() -> None:
    bus, received = LocalBus(("a", "b")), []
    bus.listen("a", lambda stamp, value: bus.post("b", stamp + 10, value, lambda: None))
    bus.listen("a", lambda stamp, _: received.append(("a", stamp)))
    bus.listen("b", lambda stamp, _: received.append(("b", stamp)))
    for stamp in (1, 2):
        bus.post("a", stamp, signal(0.0), lambda: None)
    assert received == [("a", 1), ("b", 11), ("a", 2), ("b", 12)]


def test_a_listener_that_fails_loses_neither_publication_nor_the_next_signal() -> None:
    bus, received, world = LocalBus(("a",)), [], []

    def take(stamp: int, _: object) -> None:
        received.append(stamp)
        if stamp == 1:
            raise ValueError("bad")

    bus.listen("a", take)
    with pytest.raises(ValueError, match="bad"):
        bus.post("a", 1, signal(0.0), lambda: world.append(1))
    bus.post("a", 2, signal(0.0), lambda: world.append(2))
    assert (received, world) == ([1, 2], [1, 2])


def test_a_topic_from_outside_is_read_once_for_all() -> None:
    bus, received = LocalBus(("state",)), []
    assert [
        bus.claim_subscription("mocap"),
        bus.claim_subscription("mocap"),
        bus.claim_subscription("state"),
    ] == [True, False, False]
    assert not bus.carries("mocap")
    for name in ("filter", "trajectory"):
        bus.listen("mocap", lambda stamp, _, name=name: received.append((name, stamp)))
    bus.post("mocap", 3, signal(0.0))
    assert received == [("filter", 3), ("trajectory", 3)]
