"""What an online refinement publishes and writes: nothing without ticks, or for a wrong vehicle."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from resting_signals import level_command, resting_state

from q2q_model.downwash.jet import Jet
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import Fit, ModelFile, RoleScores, load
from q2q_model.ros.online_identification import OnlineIdentification
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_time
from q2q_model.signals.values import SwarmImu
from q2q_model.tunable import ParameterValue
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065, Vehicle
from q2q_sim.ros.stand_in import NullEntity, StandInNode

NAMES = ("cf1", "cf2")
LEVEL = np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))
LAW = find_model("paper_law")


class Warned(NullEntity):
    """Logger that keeps warnings."""

    def __init__(self) -> None:
        """Begin without a line."""
        self.lines: list[str] = []

    def warning(self, line: str, **_: object) -> None:
        """Keep a line."""
        self.lines.append(line)


class Heard(StandInNode):
    """Stand-in node that keeps what it publishes and warns of."""

    published: list[object]

    def __init__(self, name: str, given: Mapping[str, ParameterValue]) -> None:
        """Begin without a warning."""
        super().__init__(name, given)
        self.log = Warned()

    def get_logger(self) -> NullEntity:
        """Return the log of the test."""
        return self.log

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
        resting_state(t, NAMES, pos),
        level_command(t, NAMES, thrust),
        SwarmImu(t, NAMES, force, unmoved),
    )


def refined(vehicle: Vehicle, ticks: int) -> tuple[OnlineIdentification, list[object]]:
    """Return an online refinement after some ticks, and what it published."""
    node = Heard("identify", {})
    return after(ticks, node, LAW, vehicle), node.published


def after(ticks: int, node: Heard, base: ModelFile, vehicle: Vehicle) -> OnlineIdentification:
    """Return an online refinement of a node after some ticks."""
    online = OnlineIdentification(node, base, vehicle)
    take = {kind.__name__: receive for kind, receive in node.readers}
    for k in range(ticks):
        for signal in tick(k + 1):
            take[type(signal).__name__](encode(signal, stamp_from_time(signal.t)))
    return online


def test_a_model_of_the_flown_vehicle_is_published_once_it_is_judged(tmp_path: Path) -> None:
    out = tmp_path / "refined.q2q"
    online, published = refined(CRAZYFLIE_2_0, 1500)
    assert published
    assert online.end(out) == ""
    assert load(out).interaction == online.refined.interaction != LAW.interaction
    assert refined(CRAZYFLIE_2_0, 199)[1] == []


def test_a_refined_model_names_the_flights_of_its_base_and_claims_none_of_its_scores(tmp_path: Path) -> None:
    scores = RoleScores(0.99, 0.98)
    fit = Fit("jet", ("table2_1", "table2_5"), ("table2_5",), scores, scores, scores)
    out = tmp_path / "refined.q2q"
    online = after(400, Heard("identify", {}), replace(LAW, fit=fit), CRAZYFLIE_2_0)
    assert online.end(out) == ""
    gain = strength_of(online.refined) / strength_of(LAW)
    assert gain < 0.99
    assert load(out).fit == Fit(f"jet, times {gain:.3f} in flight", fit.flights)


def strength_of(model: ModelFile) -> float:
    """Return the strength of a jet."""
    assert isinstance(model.interaction, Jet)
    return model.interaction.strength


def test_a_gain_is_told_while_it_stands_at_its_limit_only() -> None:
    held, free = Heard("identify", {"prior": 0.0, "gain_min": 0.6}), Heard("identify", {"prior": 1e3})
    assert strength_of(after(400, held, LAW, CRAZYFLIE_2_0).refined) == 0.6 * strength_of(LAW)
    assert set(held.log.lines) == {
        "gain is held at its limit gain_min = 0.6: the model, --vehicle or a sensor does not fit"
    }
    after(400, free, LAW, CRAZYFLIE_2_0)
    assert free.log.lines == []


def test_nothing_is_published_or_written_for_another_vehicle(tmp_path: Path) -> None:
    online, published = refined(TEXTBOOK_065, 1500)
    assert published == []
    reason = "the median thrust of cf1 in the air is below 0.5 times the weight of textbook_065"
    assert online.end(tmp_path / "refined.q2q").startswith(reason)
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_written_without_a_complete_tick(tmp_path: Path) -> None:
    node = Heard("identify", {})
    online = OnlineIdentification(node, LAW, CRAZYFLIE_2_0)
    assert online.end(tmp_path / "m.q2q") == "no complete tick: state, command, imu not received"
    state = tick(1)[0]
    {kind.__name__: receive for kind, receive in node.readers}["SwarmState"](encode(state, 10**7))
    assert online.end(tmp_path / "m.q2q") == "no complete tick: command, imu not received, state received"
    assert list(tmp_path.iterdir()) == []
