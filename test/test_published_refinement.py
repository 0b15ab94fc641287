"""What an online refinement publishes and writes: nothing without ticks, or for a wrong vehicle."""

from pathlib import Path

import numpy as np

from q2q_model.files.find_model import find_model
from q2q_model.files.model_file import load
from q2q_model.ros.online_identification import OnlineIdentification
from q2q_model.signals.cdr import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_time
from q2q_model.signals.values import SwarmCommand, SwarmImu, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065, Vehicle
from q2q_sim.ros.stand_in import NullEntity, StandInNode

NAMES = ("cf1", "cf2")
ZEROS, STATUS = np.zeros(2), np.zeros(2, dtype=np.uint8)
LEVEL = np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))


class Heard(StandInNode):
    """Stand-in node that keeps what it publishes."""

    published: list[object]

    def create_publisher(self, kind: type, topic: str, qos: object) -> NullEntity:
        """Keep all messages."""
        made = super().create_publisher(kind, topic, qos)
        self.published = []
        made.publish = self.published.append
        return made


def tick(k: int) -> tuple[Signal, ...]:
    """Return a tick of Crazyflies in still air: cf2 sways above cf1, which the model expects to be pushed."""
    t = 0.01 * k
    pos = np.array([[0.0, 0.0, 1.0], [np.sin(t), 0.0, 1.5]])
    force = np.tile([0.0, 0.0, GRAVITY], (2, 1))
    thrust = np.full(2, CRAZYFLIE_2_0.hover_thrust)
    unmoved = np.zeros((2, 3))
    return (
        SwarmState(t, NAMES, pos, unmoved, LEVEL, unmoved, ZEROS, STATUS),
        SwarmCommand(t, NAMES, thrust, ZEROS, ZEROS, ZEROS, STATUS),
        SwarmImu(t, NAMES, force, unmoved),
    )


def refined(vehicle: Vehicle, ticks: int) -> tuple[OnlineIdentification, list[object]]:
    """Return an online refinement after some ticks, and what it published."""
    node = Heard("identify", {})
    online = OnlineIdentification(node, find_model("paper_law"), vehicle)
    take = {kind.__name__: receive for kind, receive in node.readers}
    for k in range(ticks):
        for signal in tick(k + 1):
            take[type(signal).__name__](encode(signal, stamp_from_time(signal.t)))
    return online, node.published


def test_a_model_of_the_flown_vehicle_is_published_once_it_is_judged(tmp_path: Path) -> None:
    out = tmp_path / "refined.q2q"
    online, published = refined(CRAZYFLIE_2_0, 1500)
    assert published
    assert online.end(out) == ""
    assert load(out).interaction == online.refined.interaction != find_model("paper_law").interaction
    assert refined(CRAZYFLIE_2_0, 199)[1] == []


def test_nothing_is_published_or_written_for_another_vehicle(tmp_path: Path) -> None:
    online, published = refined(TEXTBOOK_065, 1500)
    assert published == []
    reason = "the median thrust of cf1 in the air is below 0.5 times the weight of textbook_065"
    assert online.end(tmp_path / "refined.q2q").startswith(reason)
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_written_without_a_complete_tick(tmp_path: Path) -> None:
    node = Heard("identify", {})
    online = OnlineIdentification(node, find_model("paper_law"), CRAZYFLIE_2_0)
    assert online.end(tmp_path / "m.q2q") == "no tick was complete: state, command, imu not received"
    state = tick(1)[0]
    {kind.__name__: receive for kind, receive in node.readers}["SwarmState"](encode(state, 10**7))
    assert online.end(tmp_path / "m.q2q") == "no tick was complete: command, imu not received, state received"
    assert list(tmp_path.iterdir()) == []
