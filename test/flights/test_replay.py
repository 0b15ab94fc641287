"""A recorded flight, played through the real nodes, gives what the blocks give without ROS."""

from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagWriter
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import MocapFrame
from q2q_sim.loop.room import Room
from q2q_sim.node_flights.nodes_on_bag import replay
from q2q_sim.scenarios import library

SCENARIO = str(Path(__file__).parents[1] / "scenarios" / "short_room.yaml")
TICKS = 200


@pytest.fixture(scope="module")
def frames() -> list[MocapFrame]:
    """Return what VICON sees of two vehicles that fall to the ground, one above the other."""
    room = Room(library.load(SCENARIO), seed=1)
    seen = []
    for _ in range(TICKS):
        seen.append(room.capture().frame)
        room.advance(None)
    return seen


@pytest.fixture(scope="module")
def replayed(frames: list[MocapFrame], tmp_path_factory: pytest.TempPathFactory) -> Flight:
    folder = tmp_path_factory.mktemp("replay")
    with BagWriter(folder / "bag") as writer:
        writer.add_topic("/mocap", "q2q_msgs/msg/MocapFrame")
        for frame in frames:
            stamp = round(frame.t * 1e9)
            writer.write_signal("/mocap", stamp, frame)
    return replay(folder / "bag", "measured_law", folder / "nodes")


def test_every_frame_is_answered_with_the_states_and_downwashs_of_the_blocks(
    frames: list[MocapFrame], replayed: Flight
) -> None:
    block = MocapFilter(MocapFilterParams(), ("cf1", "cf2"))
    predictor = InteractionPredictor(find_model("measured_law").interaction)
    states = [block.update(frame) for frame in frames]
    felt = [predictor.update(state) for state in states]
    assert len(replayed.t) == TICKS
    np.testing.assert_array_equal(replayed.pos, [state.pos for state in states])
    np.testing.assert_array_equal(replayed.vel, [state.vel for state in states])
    np.testing.assert_array_equal(replayed.eta, [downwash.acc for downwash in felt])
