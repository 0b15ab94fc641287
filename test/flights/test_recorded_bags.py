"""The bags of Table 2: small, whole, readable by others, and what their command makes today."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap_ros2.reader import read_ros2_messages
from numpy.typing import NDArray

from q2q_model.bag import BagReader, read_facts, read_flight
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.flights.flight import Flight
from q2q_model.flights.outliers import find_outliers
from q2q_model.model_files.find_model import find_model
from q2q_model.recordings.filtered_states import mocap_frame
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import TrackStatus
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.room import Room
from q2q_sim.node_flights.flight_request import FlightRequest, facts_of
from q2q_sim.scenarios import library
from q2q_sim.sensors.vicon import Injected, Vicon

BAGS = sorted((Path(__file__).parents[2] / "bags").glob("table2_*"))
TOPICS = {"/mocap", "/state", "/truth_interference", "/imu", "/reference", "/command"}
Mask = NDArray[np.bool_]
LARGEST = 15_000_000
"""All bags together [bytes]."""


def ticks_of(bag: Path) -> int:
    return round(library.load(bag.name).duration * 100)


def test_all_six_flights_are_there_and_small() -> None:
    assert [bag.name for bag in BAGS] == [f"table2_{k}" for k in range(1, 7)]
    assert sum(file.stat().st_size for bag in BAGS for file in bag.iterdir()) <= LARGEST


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_every_tick_is_on_every_topic(bag: Path) -> None:
    counts = dict.fromkeys(TOPICS, 0)
    for message in BagReader(bag).raw():
        counts[message.topic] += 1
    assert counts == dict.fromkeys(TOPICS, ticks_of(bag))


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_a_bag_says_what_its_command_flew(bag: Path) -> None:
    request = FlightRequest(bag.name, mode="ignoring", seed=int(bag.name[-1]))
    flown = facts_of(library.load(bag.name), request)
    assert flown.faults == "[]"
    assert replace(read_facts(bag), faults="[]") == flown  # the bags are older than this entry


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_an_independent_reader_reads_every_message_of_a_bag(bag: Path) -> None:
    seen = [message.channel.topic for message in read_ros2_messages(bag / f"{bag.name}_0.mcap")]
    assert len(seen) == len(TOPICS) * ticks_of(bag)


@pytest.fixture(scope="module")
def flown() -> Flight:
    """Return flight 3, flown again."""
    scenario = library.load("table2_3")
    model = find_model(scenario.model).interaction
    return fly(scenario, FlightOptions(mode="ignoring", seed=3, model=model))


def test_a_bag_holds_what_its_scenario_and_seed_give_today(flown: Flight) -> None:
    kept = read_flight(BAGS[2])
    for name in ("mocap_pos", "pos", "true_eta", "ref_pos", "thrust", "specific_force_body"):
        np.testing.assert_allclose(
            getattr(kept, name), getattr(flown, name), rtol=0.0, atol=1e-9, err_msg=f"{name}: run bags/remake"
        )


def injected(bag: Path) -> Mask:
    """Return which samples of a bag the simulated cameras put elsewhere, by their own word, (T, n)."""
    scenario, seed = library.load(bag.name), int(bag.name[-1])
    truth = Room(scenario, seed).capture().truth  # where vehicles are does not decide what is injected
    cameras = Vicon(scenario.vicon, len(scenario.names), TICK_S, seed)
    flags = []
    for _ in range(ticks_of(bag)):
        cameras.observe(truth)
        flags.append(cameras.injected)
    wrong = Injected.OUTLIER | Injected.SWAP | Injected.STALE | Injected.NAN
    return np.asarray(np.array(flags) & np.uint8(wrong) != 0)


def refused_online(flight: Flight) -> Mask:
    """Return where the filter of flight leaves a sample that is there, (T, n).

    What it takes is of age 0: trusted, or, the first sample of all, not yet.
    """
    online = MocapFilter(MocapFilterParams(), flight.names)
    refused = np.zeros(flight.mocap_pos.shape[:2], dtype=np.bool_)
    for tick in range(flight.t.size):
        rows = np.flatnonzero(np.isfinite(flight.mocap_pos[tick]).all(axis=1))
        signal = online.update(mocap_frame(flight, tick))
        left = (signal.status[rows] != TrackStatus.TRACKED) & (signal.age[rows] > 0.0)
        refused[tick, rows] = left
    return refused


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_every_injected_outlier_is_found_and_no_good_sample_touched(bag: Path) -> None:
    """91 outliers among 42 508 samples of the six flights; by the batch rule and by the filter of flight."""
    flight = read_flight(bag)
    seen = np.isfinite(flight.mocap_pos).all(axis=-1)
    wrong = injected(bag) & seen
    assert wrong.sum() >= 10
    for found in (find_outliers(flight.t, flight.mocap_pos) & seen, refused_online(flight)):
        np.testing.assert_array_equal(found, wrong)


def test_what_was_injected_is_what_lies_off_the_truth(flown: Flight) -> None:
    kept = read_flight(BAGS[2])
    off = np.linalg.norm(kept.mocap_pos - flown.true_pos, axis=-1)
    assert np.nanmax(np.where(injected(BAGS[2]), np.nan, off)) < 1e-3  # six spreads of noise of 0.15 mm
    assert np.nanmin(np.where(injected(BAGS[2]), off, np.nan)) > 0.2 - 1e-3  # the smallest step
