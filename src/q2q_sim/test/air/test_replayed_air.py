"""The air of a replay travels as the one that was flown in, and pushes only vehicles under others."""

from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

from q2q_model.flights.flight import Flight
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.air_file import load
from q2q_sim.air.air_names import ROOM, air_path
from q2q_sim.air.lookup.travel_speed import travel_speed
from q2q_sim.air.wake_laws import MEASURED, MEASURED_SPEED, PAPER, wake_push
from q2q_sim.commands.replay_page import main
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.replay_page import in_air, replay_run
from q2q_sim.replay_page.packed_run import packed_run
from q2q_sim.replay_page.replay_run import DOWNWASH_RADIUS

ROOT = Path(__file__).resolve().parents[4]
T = 0.01 * np.arange(100, dtype=np.float64)
GUST = np.array([0.3, 0.0, -0.5])


def flown(cf2: tuple[float, float, float]) -> Flight:
    """Return a flight of cf1 at a height of 1 m, and cf2."""
    empty = FlightRecorder(("cf1", "cf2"), len(T)).flight("made")
    pos = np.tile([(0.0, 0.0, 1.0), cf2], (len(T), 1, 1))
    return replace(empty, t=T, true_pos=pos)


@pytest.mark.parametrize(
    ("cf2", "is_under"),
    [((0.3, 0.0, 1.5), True), ((0.5, 0.0, 1.5), False), ((0.0, 0.0, 3.0), True), ((9.0, 9.0, 1.0), False)],
)
def test_the_push_of_the_air_is_shown_on_vehicles_under_another(
    cf2: tuple[float, float, float], is_under: bool
) -> None:
    flight = replace(flown(cf2), true_eta=np.full((len(T), 2, 3), GUST))
    found = replay_run(flight, CRAZYFLIE_2_0).downwash
    np.testing.assert_array_equal(found[:, 0], np.tile(GUST if is_under else 0.0 * GUST, (len(T), 1)))
    assert not found[:, 1].any()


def test_no_downwash_of_the_wake_laws_is_hidden() -> None:
    gaps = np.arange(0.1, 4.0, 0.05)
    beside = [wake_push(law, gap, DOWNWASH_RADIUS**2) for law in (PAPER, MEASURED) for gap in gaps]
    assert max(beside) < 0.02
    push = np.array([0.0, 0.0, -wake_push(MEASURED, 2.0, 0.0)])  # 0.55 m/s^2, 2 m below
    flight = replace(flown((0.0, 0.0, 3.0)), true_eta=np.tile([push, 0.0 * push], (len(T), 1, 1)))
    np.testing.assert_array_equal(replay_run(flight, CRAZYFLIE_2_0).downwash, flight.true_eta)


def test_a_prediction_is_of_downwash_and_shown_as_it_is() -> None:
    predicted = np.full((len(T), 2, 3), [0.0, 0.0, -0.01])
    run = replay_run(replace(flown((9.0, 9.0, 1.0)), eta=predicted), CRAZYFLIE_2_0)
    np.testing.assert_array_equal(run.downwash, predicted)


@pytest.mark.parametrize(
    ("air", "speed"),
    [
        ("paper", inf),
        ("none", inf),
        ("measured", MEASURED_SPEED),
        ("", MEASURED_SPEED),
        ("my_module:MyAir", MEASURED_SPEED),
        ("out/gone.air", MEASURED_SPEED),
    ],
)
def test_downwash_travels_as_the_law_says_and_as_of_real_vehicles_where_unknown(
    air: str, speed: float
) -> None:
    assert travel_speed(air) == speed


def test_downwash_travels_in_a_room_as_its_flights_taught() -> None:
    jet = load(air_path(ROOM)).jet
    assert jet is not None
    for name in (ROOM, "room without wind meander", "recorded:bags/mine"):
        assert travel_speed(name) == jet.travel_speed_mps


def test_a_page_has_the_speed_of_its_air_and_none_where_downwash_acts_at_once() -> None:
    run = replay_run(flown((9.0, 9.0, 1.0)), CRAZYFLIE_2_0)
    assert packed_run(run)["wakeSpeed"] == MEASURED_SPEED
    assert packed_run(in_air(run, "paper"))["wakeSpeed"] is None


def test_the_page_of_a_bag_has_the_air_of_its_metadata(tmp_path: Path) -> None:
    file = tmp_path / "page.html"
    assert main([str(ROOT / "bags" / "table2_4"), "--end", "2", "--out", str(file)]) == 0
    assert '"wakeSpeed":null' in file.read_text(encoding="utf-8")
