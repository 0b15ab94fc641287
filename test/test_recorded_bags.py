"""The bags of Table 2: small, whole, readable by others, and what their command makes today."""

from pathlib import Path

import numpy as np
import pytest
from mcap_ros2.reader import read_ros2_messages

from q2q_model.bag import BagReader, read_flight
from q2q_model.tools.models import find_model
from q2q_sim import scenarios
from q2q_sim.closed_loop import FlightOptions, fly

BAGS = sorted((Path(__file__).parents[1] / "bags").glob("table2_*"))
TOPICS = {"/mocap", "/state", "/truth_interference", "/imu", "/reference", "/command"}
LARGEST = 15_000_000
"""All bags together [bytes]."""


def ticks_of(bag: Path) -> int:
    return round(scenarios.load(bag.name).duration * 100)


def test_all_six_flights_are_there_and_small() -> None:
    assert [bag.name for bag in BAGS] == [f"table2_{k}" for k in range(1, 7)]
    assert sum(file.stat().st_size for bag in BAGS for file in bag.iterdir()) <= LARGEST


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_every_tick_is_on_every_topic(bag: Path) -> None:
    counts = dict.fromkeys(TOPICS, 0)
    for message in BagReader(bag).raw():
        counts[message.topic] += 1
    assert counts == dict.fromkeys(TOPICS, ticks_of(bag))


def test_an_independent_reader_reads_every_message_of_a_bag() -> None:
    bag = BAGS[0]
    seen = [message.channel.topic for message in read_ros2_messages(bag / f"{bag.name}_0.mcap")]
    assert len(seen) == len(TOPICS) * ticks_of(bag)


def test_a_bag_holds_what_its_scenario_and_seed_give_today() -> None:
    scenario = scenarios.load("table2_3")
    model = find_model(scenario.model).interaction
    flown = fly(scenario, FlightOptions(mode="ignoring", seed=3, model=model))
    kept = read_flight(BAGS[2])
    for name in ("mocap_pos", "pos", "true_eta", "ref_pos", "thrust", "specific_force_body"):
        np.testing.assert_allclose(
            getattr(kept, name), getattr(flown, name), rtol=0.0, atol=1e-9, err_msg=f"{name}: run bags/remake"
        )
