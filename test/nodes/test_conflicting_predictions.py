"""A node that receives predictions of its own vehicle from another node says so, and its own in silence."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from room_node import RoomNode

from q2q_control.mpc.neighbours.exchanged_paths import PredictedPaths
from q2q_control.ros.prediction_exchange import PredictionExchange
from q2q_control.ros.prediction_message import encode_prediction
from q2q_model.diagnostics.health import Health
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.values import Names, SwarmState

PERIOD = 0.1
MESSAGE = "predictions: another node also flies cf1: stop one (mpc_a, mpc_b write it)"


@dataclass
class Solved:
    """MPC of cf1 that has solved a tick."""

    prediction: PredictedPaths | None = None
    received: list[PredictedPaths] = field(default_factory=list)

    def has_received(self, _: str, __: float) -> bool:
        """Return True: it waits for nobody."""
        return True

    def receive(self, prediction: PredictedPaths) -> None:
        """Keep a prediction."""
        self.received.append(prediction)

    def silent_neighbours(self, _: SwarmState) -> Names:
        """Return none."""
        return ()


@dataclass
class Wiring:
    """Wiring that calls what follows a command, and the check of each second."""

    health: Health = field(default_factory=Health)
    follow: Callable[[int, object], None] = print
    check: Callable[[], object] = print

    def after_publish(self, follow: Callable[[int, object], None]) -> None:
        """Keep what follows a command."""
        self.follow = follow

    def check_each_second(self, check: Callable[[], object]) -> None:
        """Keep the check."""
        self.check = check

    def add_diagnostic_values(self, _: Callable[[], Mapping[str, str]]) -> None:
        """Ask for none."""

    def resume(self) -> None:
        """Hold no tick."""


def paths(t: float, name: str) -> PredictedPaths:
    """Return a prediction of a vehicle at rest."""
    return PredictedPaths(t, (name,), t, 0.05, np.zeros((1, 3, 3), np.float32))


def doubts(wiring: Wiring) -> list[str]:
    """Return what is doubtful in this second."""
    wiring.check()
    return [doubt for doubt in wiring.health.doubts.values() if doubt]


def test_a_second_node_of_the_same_vehicle_is_reported_once_and_doubted_until_it_is_gone() -> None:
    node, mpc, wiring = RoomNode("mpc_a", {}, {}), Solved(), Wiring()
    node.writers["predictions"] = "mpc_b", "mpc_a"
    exchange = PredictionExchange(node, mpc, ("cf1",), PERIOD)
    exchange.wire(wiring, live=True)
    state = synthetic_signal(SwarmState, 0.0, ("cf1", "cf2"))
    found = []
    for k, twice in enumerate((False, True, True, False, True)):
        t = PERIOD * k
        mpc.prediction = paths(t, "cf1")
        exchange.begin(replace(state, t=t))
        wiring.follow(0, None)
        for message in (*node.published["predictions"], *[encode_prediction(paths(t, "cf1"))] * twice):
            node.takers["predictions"](message)
        assert len(node.published["predictions"]) == 1
        node.published["predictions"].clear()
        found.append(doubts(wiring))
    assert found == [[], [MESSAGE], [MESSAGE], [], [MESSAGE]]
    assert node.lines == [MESSAGE]
    assert mpc.received == []


def test_a_neighbour_s_prediction_is_received_and_not_doubted() -> None:
    node, mpc, wiring = RoomNode("mpc_a", {}, {}), Solved(), Wiring()
    node.writers["predictions"] = "mpc_b", "mpc_a"
    PredictionExchange(node, mpc, ("cf1",), PERIOD).wire(wiring, live=True)
    node.takers["predictions"](encode_prediction(paths(0.0, "cf2")))
    assert (doubts(wiring), node.lines) == ([], [])
    assert [one.names for one in mpc.received] == [("cf2",)]
