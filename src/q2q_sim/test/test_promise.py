"""A tube holds as often as it says; encounters with full dynamics are judged by what vehicles did."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.documents.json_file import with_nulls
from q2q_model.documents.plain_values import to_plain
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import SetpointStatus, SwarmSetpoint
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.commands.promise import main, parser
from q2q_sim.experiments.promise import promise_flights
from q2q_sim.experiments.promise.kept_flights import resume_flights
from q2q_sim.experiments.promise.promise_flights import run
from q2q_sim.experiments.promise.promise_verdict import Rate, promise_verdict, verdict_json
from q2q_sim.experiments.promise.room_encounter import (
    STEADY,
    EncounterRecord,
    PromiseCase,
    encounter_scenario,
    fly_room_encounter,
    starts_apart,
)
from q2q_sim.experiments.promise.tracking_tube import (
    TubeFlights,
    conformal_bound,
    fewest_flights,
    learn_tube,
    read_tube,
)
from q2q_sim.experiments.promise.tube_report import different_conditions, reused_seeds, tube_lines
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import safe_replanner_params
from q2q_sim.scenarios import library
from q2q_sim.scenarios.room_profiles import IDEAL
from q2q_sim.scenarios.scenario import Scenario

CONDITIONS = PromiseCase().conditions
BLANK = EncounterRecord(
    seed=0, vehicles=2, apart_at_start=True, horizontal=0.05, vertical=0.02, clearance=0.1,
    announced=True, ticks=100, broken_ticks=0, arrived=None, in_reach=None,
)  # fmt: skip
"""Flight in which nothing happens."""


@pytest.mark.parametrize(("n", "alpha"), [(19, 0.05), (60, 0.05), (99, 0.01), (250, 0.01)])
def test_a_fresh_flight_leaves_the_bound_as_often_as_the_closed_form_says(n: int, alpha: float) -> None:
    """1 - k / (n + 1), for any continuous distribution; here one of heavy tails."""
    generator = np.random.default_rng(0)
    left = []
    for _ in range(4000):
        scores = generator.pareto(1.5, n)
        left.append((1.0 + conformal_bound(scores, alpha)) ** -1.5)  # exact, of a fresh draw
    rank = np.ceil((n + 1) * (1.0 - alpha) - 1e-9)
    expected = 1.0 - rank / (n + 1)
    # of Beta(n + 1 - k, k), over 4000 draws: five standard errors
    spread = np.sqrt(expected * (1.0 - expected) / (n + 2) / 4000)
    assert np.mean(left) == pytest.approx(expected, abs=5.0 * spread)
    assert np.mean(left) <= 1.2 * alpha


@pytest.mark.parametrize("alpha", [0.05, 0.01])
def test_a_tube_of_both_errors_is_left_by_no_more_than_its_share_of_fresh_flights(alpha: float) -> None:
    generator = np.random.default_rng(1)
    left = []
    for _ in range(300):
        # heights err less than positions, and both err together
        errors = generator.gamma(4.0, 0.02, (1400, 1)) * generator.gamma(3.0, [1.0, 0.4], (1400, 2))
        tube = learn_tube(errors[:400], alpha, CONDITIONS)
        left.append(np.mean([not tube.holds(one) for one in errors[400:]]))
    assert alpha / 1.2 < np.mean(left) <= 1.2 * alpha


def test_the_fewest_flights_bound_by_their_largest_error() -> None:
    assert fewest_flights(0.05) == 19
    assert fewest_flights(0.01) == 99
    assert conformal_bound(np.arange(19.0), 0.05) == 18.0
    assert conformal_bound(np.arange(99.0), 0.05) == 94.0  # the 95th of 99
    with pytest.raises(ValueError, match=r"18 scores at alpha = 0.05: 19 are needed"):
        conformal_bound(np.arange(18.0), 0.05)


@pytest.mark.parametrize(("alpha", "fewest"), [(0.05, 24), (0.01, 124)])
def test_too_few_flights_for_a_tube_are_refused_before_they_are_flown(alpha: float, fewest: int) -> None:
    learn_tube(np.random.default_rng(3).random((fewest, 2)), alpha, CONDITIONS)
    asked = ["--count", str(fewest - 1), "--alpha", str(alpha), "--learn", "tube.json"]
    with pytest.raises(ValueError, match=rf"{fewest - 1} flights at alpha = {alpha:g}: .* at least"):
        run(parser().parse_args(asked))


@pytest.mark.parametrize(("row", "error"), [(0, np.nan), (-1, np.nan), (-1, np.inf), (slice(None), 0.0)])
def test_errors_that_give_no_tube_are_refused(row: int | slice, error: float) -> None:
    errors = np.random.default_rng(3).random((24, 2))
    errors[row, 1] = error
    with pytest.raises(ValueError, match="must be finite, and most above 0"):
        learn_tube(errors, 0.05, CONDITIONS)


def test_a_tube_file_gives_the_tube_back_and_a_wrong_one_names_its_key(tmp_path: Path) -> None:
    flown = TubeFlights(first=100, count=200, horizontal=0.12, vertical=0.12)
    tube = learn_tube(np.random.default_rng(2).random((200, 2)), 0.05, CONDITIONS, flown)
    file = tmp_path / "tube.json"
    file.write_text(json.dumps(to_plain(tube)))
    assert read_tube(file) == tube
    assert not different_conditions(tube, CONDITIONS)
    reported = different_conditions(tube, replace(CONDITIONS, jerk_max=0.0))
    assert reported == [f"jerk_max = 0.0, of the tube {CONDITIONS.jerk_max}"]
    file.write_text(json.dumps(to_plain(tube)).replace('"vertical"', '"upwards"'))
    with pytest.raises(ValueError, match=r"upwards"):
        read_tube(file)


@pytest.mark.parametrize(
    ("change", "said"),
    [({"alpha": 7.0}, "alpha = 7: above 0 and below 1"), ({"vertical": 0.0}, "above 0 is allowed")],
)
def test_a_tube_file_with_a_number_out_of_bounds_is_refused_by_name(
    tmp_path: Path, change: dict[str, float], said: str
) -> None:
    tube = to_plain(learn_tube(np.full((200, 2), 0.1), 0.05, CONDITIONS))
    assert isinstance(tube, dict)
    file = tmp_path / "tube.json"
    file.write_text(json.dumps(tube | change))
    with pytest.raises(ValueError, match=f"tube.json: .*{said}"):
        read_tube(file)


def test_a_tube_file_of_an_older_version_is_read_and_compared_in_what_it_knows(tmp_path: Path) -> None:
    tube = to_plain(learn_tube(np.full((200, 2), 0.1), 0.05, CONDITIONS))
    assert isinstance(tube, dict)
    assert isinstance(tube["conditions"], dict)
    for name in ("approach", "grace"):
        del tube["conditions"][name]
    del tube["learned_from"]
    file = tmp_path / "tube.json"
    file.write_text(json.dumps(tube))
    found = read_tube(file)
    assert not different_conditions(found, CONDITIONS)
    assert different_conditions(found, replace(CONDITIONS, air="office")) == [
        "air = office, of the tube room"
    ]
    assert reused_seeds(found, 0, 100) is None
    assert len(tube_lines(found)) == 1


def test_flights_of_seeds_that_gave_the_tube_are_named() -> None:
    flown = TubeFlights(first=100, count=200, horizontal=0.12, vertical=0.12)
    tube = learn_tube(np.full((200, 2), 0.1), 0.05, CONDITIONS, flown)
    for first, count in ((0, 101), (299, 1), (150, 10), (0, 1000)):
        assert reused_seeds(tube, first, count) == (
            "seeds 100 to 299 gave the tube, and do not test it; others begin at --first 300"
        )
    assert reused_seeds(tube, 0, 100) is None
    assert reused_seeds(tube, 300, 100) is None


def test_the_command_warns_of_flights_that_gave_the_tube(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(promise_flights, "_flown", lambda *_: [BLANK])
    flown = TubeFlights(first=0, count=200, horizontal=0.12, vertical=0.12)
    file = tmp_path / "tube.json"
    file.write_text(json.dumps(to_plain(learn_tube(np.full((200, 2), 0.1), 0.05, CONDITIONS, flown))))
    assert main(["--count", "1", "--tube", str(file)]) == 0
    assert capsys.readouterr().err.startswith("promise: seeds 0 to 199 gave the tube, and do not test it")
    assert main(["--count", "1", "--first", "200", "--tube", str(file)]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("flown", "said"),
    [
        (0.11, "flights with that one stay within it with probability 0.95"),
        (0.09, "run promise with --tube to count how many flights leave it"),
    ],
)
def test_a_tube_within_the_one_that_was_flown_holds_for_flights_with_that_one(
    flown: float, said: str
) -> None:
    tube = learn_tube(np.full((200, 2), 0.1), 0.05, CONDITIONS, TubeFlights(0, 200, flown, 0.2))
    size, known = tube_lines(tube)
    assert size == "tube at alpha 0.05 from 160 flights: 100 mm horizontally, 100 mm vertically"
    assert known.endswith(said)


def test_the_bound_of_a_rate_is_that_of_clopper_and_pearson() -> None:
    """Without events 1 - 0.05^(1/n); with k events the rate at which k or fewer come in 5 % of all cases."""
    assert Rate(0, 100).most == pytest.approx(1.0 - 0.05**0.01)
    most = Rate(1, 50).most
    assert (1.0 - most) ** 50 + 50 * most * (1.0 - most) ** 49 == pytest.approx(0.05)
    assert Rate(3, 3).most == 1.0


def test_an_encounter_keeps_vehicles_apart_and_stays_in_its_first_tube() -> None:
    record = fly_room_encounter(0, PromiseCase())
    assert record.apart_at_start
    assert not record.entered
    assert 0.01 < record.horizontal < 0.3  # a vehicle is never exactly on its setpoint, nor lost
    assert 0.01 < record.vertical < 0.3
    assert record == fly_room_encounter(0, PromiseCase())


def test_shipped_scenarios_in_rooms_with_delays_or_dropouts_fly_with_the_same_tube() -> None:
    shipped = replace(STEADY, tracking=0.17, tracking_z=0.12, approach=2.0)
    flown = []
    for name in library.names():
        scenario = library.load(name)
        if scenario.vicon == IDEAL.vicon:
            continue
        for one in filter(None, (scenario, scenario.in_air)):
            assert safe_replanner_params(one) == shipped, name
            flown.append(name)
    assert len(flown) == 11


def test_the_tube_of_stack3_keeps_the_promise_that_is_broken_without_it() -> None:
    """Two come near within 12 s; at 5 cm, the first leaves its modified trajectory by more after 6.7 s."""
    scenario = replace(library.load("stack3"), duration=12.0)

    def broken(flown: Scenario) -> float:
        reported: list[bool] = []

        def hear(topic: str, _: int, signal: Signal) -> None:
            if topic == "reference_safe" and isinstance(signal, SwarmSetpoint):
                reported.append(bool((signal.status == SetpointStatus.PROMISE_BROKEN).any()))

        model = find_model(flown.model).interaction
        fly(flown, FlightOptions(replan="safe", model=model, on_signal=hear))
        return float(np.mean(reported))

    loop = {"pid": scenario.overrides["pid"]}
    assert broken(replace(scenario, overrides=loop)) > 0.01
    assert broken(scenario) == 0.0


def swap(apart: float) -> list[VehicleWaypoints]:
    return [
        VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(3, (0, 1, 1)))),
        VehicleWaypoints("cf2", (Waypoint(0, (apart, 0, 1)), Waypoint(3, (apart, 1, 1)))),
    ]


def test_paths_start_apart_where_zone_and_tubes_do() -> None:
    reach = STEADY.eps + 2.0 * STEADY.tracking
    assert not starts_apart(minimum_snap_plan(swap(reach + 0.01)), STEADY)
    assert starts_apart(minimum_snap_plan(swap(reach + 0.03)), STEADY)


def test_an_encounter_flies_the_delay_and_the_loss_that_it_names() -> None:
    scenario = encounter_scenario(minimum_snap_plan(swap(1.0)), 0.02, 0.07, PromiseCase())
    assert (scenario.radio.latency, scenario.radio.loss) == (0.02, 0.07)
    assert scenario.air == "room"


def test_a_verdict_counts_what_happened_under_the_conditions_apart_from_the_rest() -> None:
    kept = EncounterRecord(
        seed=1, vehicles=3, apart_at_start=True, horizontal=0.05, vertical=0.02, clearance=0.1,
        announced=True, ticks=100, broken_ticks=0, arrived=True, in_reach=True,
    )  # fmt: skip
    left = replace(kept, seed=0, horizontal=0.5, broken_ticks=7, arrived=False)
    entered = replace(kept, seed=2, clearance=-0.01, announced=False, arrived=None, in_reach=None)
    other = replace(entered, seed=3, apart_at_start=False, announced=True, horizontal=9.0)
    tube = learn_tube(np.full((19 * 5 // 4 + 1, 2), 0.1), 0.05, CONDITIONS)
    found = promise_verdict([kept, left, entered, other], tube)
    assert verdict_json(found) == {
        "flights": 4, "vehicles": 12, "under_conditions": 3, "entries_under_conditions": 1,
        "entry_rate_most": Rate(1, 3).most, "entries_otherwise": 1, "entries_not_announced": 1,
        "least_distance_m": -0.01, "ticks": 300, "broken_ticks": 7, "left_tube": 1,
        "left_tube_rate_most": Rate(1, 3).most, "arrived": 1, "can_arrive": 2,
        "in_reach": 2,
    }  # fmt: skip


def test_the_numbers_of_flights_none_of_which_counts_are_json() -> None:
    found = with_nulls(verdict_json(promise_verdict([], None)))
    assert isinstance(found, dict)
    assert found["least_distance_m"] is None  # of no vehicles
    json.dumps(found, allow_nan=False)


def test_an_interrupted_series_flies_only_what_is_missing_and_keeps_to_its_case(tmp_path: Path) -> None:
    """The last line is cut off, as by a kill while it is written."""
    file, flown = tmp_path / "flights.jsonl", list[int]()

    def fly_seeds(seeds: Sequence[int]) -> Iterator[EncounterRecord]:
        for seed in seeds:
            flown.append(seed)
            yield replace(BLANK, seed=seed)

    case = PromiseCase()
    assert [one.seed for one in resume_flights(range(3), case, file, fly_seeds)] == [0, 1, 2]
    file.write_text(file.read_text()[:-20])
    found = list(resume_flights(range(1, 5), case, file, fly_seeds))
    assert sorted(one.seed for one in found) == [1, 2, 3, 4]
    assert flown == [0, 1, 2, 2, 3, 4]
    other = PromiseCase(replace(STEADY, tracking=0.2))
    with pytest.raises(ValueError, match="flights of another tube"):
        list(resume_flights(range(3), other, file, fly_seeds))


def test_a_tube_that_cannot_be_written_is_refused_before_any_flight(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(promise_flights, "fly_room_encounter", lambda *_, **__: pytest.fail("flown"))
    with pytest.raises(SystemExit, match="2"):
        main(["--count", "3", "--alpha", "0.7", "--learn", str(tmp_path)])
    assert f"argument --learn: {tmp_path}" in capsys.readouterr().err


def test_the_command_prints_a_tube_and_writes_its_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three flights bound nothing at 5 %; at 70 % the two that give the size do."""
    tube, numbers = tmp_path / "tube.json", tmp_path / "promise.json"
    words = ["--count", "3", "--alpha", "0.7", "--learn", str(tube), "--json", str(numbers)]
    assert main(words) == 0
    learned = read_tube(tube)
    assert learned.conditions == CONDITIONS
    assert learned.learned_from == TubeFlights(0, 3, STEADY.tracking, STEADY.tracking_z)
    printed = capsys.readouterr().out
    assert f"{1e3 * learned.horizontal:.0f} mm horizontally" in printed
    assert json.loads(numbers.read_text())["verdict"]["entries_under_conditions"] == 0


def test_the_numbers_of_flights_that_give_no_tube_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The count is enough for a tube, but of these flights none began under its conditions."""
    flown = [replace(BLANK, seed=seed, apart_at_start=False) for seed in range(3)]
    monkeypatch.setattr(promise_flights, "_flown", lambda *_: flown)
    numbers = tmp_path / "promise.json"
    words = ["--count", "3", "--alpha", "0.7", "--learn", str(tmp_path / "tube.json")]
    assert main([*words, "--json", str(numbers)]) == 1
    assert "flights" in capsys.readouterr().err
    assert json.loads(numbers.read_text())["verdict"]["flights"] == 3


def test_a_share_outside_the_tube_is_refused_where_no_tube_is_learned(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["--count", "1", "--alpha", "0.1"]) == 1
    said = capsys.readouterr().err
    assert said == "promise: --alpha 0.1 is of the tube that --learn FILE writes: give both\n"


def test_a_process_that_dies_ends_the_command_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(promise_flights, "spread_work", lambda _, __, seeds, died: map(died, seeds))
    assert main(["--first", "7", "--count", "2"]) == 1
    said = capsys.readouterr().err.strip()  # after an empty progress bar
    assert said == "promise: encounter 7: its process died when flown alone"
