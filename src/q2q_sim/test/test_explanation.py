"""Explanations split a loss by its causes, name the first one, and refuse flights that they cannot repeat."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from q2q_model.bag import FlightFacts, read_flight
from q2q_sim.bag_topics.scenario_facts import flown_scenario, scenario_facts
from q2q_sim.commands.explain import main
from q2q_sim.experiments.campaign.campaign_flight import fly_pure, keep_run
from q2q_sim.experiments.campaign.random_run import Run, draw_run
from q2q_sim.experiments.explanation import recorded_case as cases
from q2q_sim.experiments.explanation.accidents import INJECTIONS, ordinary_flight
from q2q_sim.experiments.explanation.causes import CAUSES, FAULTS, present_causes, without_causes
from q2q_sim.experiments.explanation.explanation import CauseShare, Explanation, ExplanationParams, explain
from q2q_sim.experiments.explanation.explanation_page import write_page
from q2q_sim.experiments.explanation.explanation_sentence import explanation_sentence
from q2q_sim.experiments.explanation.first_cause import first_cause
from q2q_sim.experiments.explanation.flight_case import FlightCase, flight_case, fly_flight_case
from q2q_sim.experiments.explanation.loss import LOST, Loss, largest_loss
from q2q_sim.experiments.explanation.recorded_case import RecordedCase, recorded_case
from q2q_sim.experiments.explanation.score import answer_accidents, score_json, score_text
from q2q_sim.experiments.explanation.shapley import orders_of, shapley_shares, standard_error
from q2q_sim.faults.faults import KINDS, Fault
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.random_streams import stream
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_variants import with_air
from q2q_sim.tools.write_replay import part_of_flight

RNG = np.random.default_rng(0)
FOUND = Explanation(
    loss=Loss("height", "cf1", 0, 3.25, 0.83),
    shares=(CauseShare("downwash", 0.61, 0.55, 0.67), CauseShare("latency", 0.1, 0.08, 0.12)),
    rest=0.12,
    without_first=0.2,
    all_orders=False,
    draws=3,
)


def short(name: str, air: str = "") -> FlightCase:
    """Return the first half second of a scenario."""
    scenario = replace(with_air(library.load(name), air, ()), duration=0.5)
    return flight_case(scenario, BlockChoices("ignoring"), 0)


def test_shares_of_an_additive_loss_are_its_terms_in_every_order() -> None:
    sizes = {"a": 0.5, "b": 0.2, "c": -0.1, "d": 0.0}
    orders = orders_of(list(sizes), 6, RNG)
    found = shapley_shares(
        list(sizes), orders, lambda removed: sum(sizes.values()) - sum(map(sizes.get, removed))
    )
    np.testing.assert_allclose(found, [list(sizes.values())] * 6, atol=1e-12)
    np.testing.assert_allclose(standard_error(found), 0.0, atol=1e-12)


def test_causes_that_only_act_together_share_alike() -> None:
    orders = orders_of(["a", "b", "c"], 6, RNG)
    assert len(set(orders)) == 6
    found = shapley_shares(["a", "b", "c"], orders, lambda removed: float(not removed & {"a", "b"}))
    np.testing.assert_allclose(found.mean(axis=0), [0.5, 0.5, 0.0])


def test_many_causes_are_taken_out_in_pairs_of_reversed_orders() -> None:
    orders = orders_of(list(CAUSES), 8, RNG)
    assert len(orders) == 8
    assert all(one == other[::-1] for one, other in zip(orders[::2], orders[1::2], strict=True))


def test_every_fault_belongs_to_one_cause() -> None:
    kinds = [kind for some in FAULTS.values() for kind in some]
    assert sorted(kinds) == sorted(KINDS)
    assert set(FAULTS) <= set(CAUSES)


def test_without_all_causes_none_is_left() -> None:
    for case in (short("table6_room"), short("stack3", "room"), short("table6_room", "ring")):
        assert present_causes(without_causes(case, CAUSES)) == ()


def test_an_ideal_room_without_a_wake_has_causes_in_its_vehicles_only() -> None:
    still = replace(library.load("table6"), wake="none", duration=0.5)
    assert present_causes(flight_case(still, BlockChoices("ignoring"), 0)) == (
        "battery and saturation",
        "control",
    )


def test_a_cause_is_taken_out_and_the_others_stay() -> None:
    case = short("stack3", "room")
    assert present_causes(case) == tuple(CAUSES)
    for cause in CAUSES:
        assert present_causes(without_causes(case, {cause})) == tuple(one for one in CAUSES if one != cause)


def test_gusts_of_the_scenario_are_no_cause_in_an_air_that_replaces_them() -> None:
    for air in ("ring", "measured"):
        windless = short("stack3", air)
        gusts = replace(windless.scenario.disturbance, air_std=2.0)
        assert "wind" not in present_causes(
            replace(windless, scenario=replace(windless.scenario, disturbance=gusts))
        )


def test_no_vehicle_feels_downwash_once_it_is_taken_out() -> None:
    for case in (short("stack3"), short("stack3", "ring")):
        flown, still = fly_flight_case(case), fly_flight_case(without_causes(case, {"downwash", "wind"}))
        assert np.isfinite(flown.true_eta).all()
        assert np.abs(still.true_eta).max() == 0.0


@pytest.mark.parametrize("cause", INJECTIONS)
def test_an_accident_differs_from_an_ordinary_flight_by_its_cause_alone(cause: str) -> None:
    rng = stream(1, "test")
    before = ordinary_flight(1, rng)
    after = INJECTIONS[cause](before, rng)
    repaired = [without_causes(case, {cause}) for case in (before, after)]
    if cause != "downwash":  # it moves the vehicles above cf1
        assert repaired[0].scenario == repaired[1].scenario
    assert after.scenario != before.scenario


def test_a_loss_is_where_the_vehicle_is_farthest_from_its_setpoint() -> None:
    flight = fly_flight_case(short("stack3"))
    moved = flight.safe_pos.copy()
    moved[20, 1] = flight.true_pos[20, 1] + (0.0, 0.3, -0.4)
    moved[30, 2] = flight.true_pos[30, 2] + (0.0, 0.0, 0.45)
    moved_flight = replace(flight, safe_pos=moved)
    by_distance, by_height = largest_loss(moved_flight), largest_loss(moved_flight, "height")
    assert (by_distance.row, by_distance.t, by_distance.size) == (1, 0.2, pytest.approx(0.5))
    assert (by_height.row, by_height.t, by_height.size) == (2, pytest.approx(0.3), pytest.approx(0.45))
    moved[40, 0] = np.nan
    assert largest_loss(replace(flight, safe_pos=moved)).size == LOST


def test_the_sentence_reports_loss_causes_rest_and_the_flight_without_the_first() -> None:
    assert explanation_sentence(FOUND) == (
        "cf1 is 83 cm below its setpoint at 3.2 s: 61 cm (55 to 67 cm) by downwash, 10 cm (8.0 to 12 cm) by "
        "latency, 12 cm with none of the causes; flown again with only downwash taken out: 20 cm."
    )
    certain = replace(FOUND, shares=(CauseShare("downwash", 0.61, 0.6101, 0.6102),))
    assert ": 61 cm by downwash, 12 cm with none" in explanation_sentence(certain)
    assert explanation_sentence(replace(FOUND, shares=())).endswith("by none of the known causes.")
    helped = (*FOUND.shares, CauseShare("wind", -0.05, -0.06, -0.04), CauseShare("control", 0.04, 0.0, 0.08))
    printed = explanation_sentence(replace(FOUND, shares=helped))
    assert "-5.0 cm (-6.0 to -4.0 cm) by wind" in printed
    assert "control" not in printed  # less than a twentieth of the loss


def test_first_causes_of_accidents_are_named_first() -> None:
    found = list(answer_accidents(range(2)))
    assert [one.named for one in found] == [one.first for one in found]
    total = score_json(found)
    assert isinstance(total, dict)
    assert (total["accidents"], total["named_first"], total["mistaken"]) == (2, 2, [])
    wrong = replace(found[0], named="wind", first="control")
    assert score_text([*found, wrong]) == "first cause named first in 2 of 3 accidents (67%)"


def test_shares_and_rest_add_up_to_the_loss_and_other_draws_widen_the_intervals() -> None:
    own, both = (explain(short("stack3"), ExplanationParams(orders=4, draws=n)) for n in (1, 2))
    assert sum(one.share for one in own.shares) + own.rest == pytest.approx(own.loss.size, abs=1e-12)
    assert (own.all_orders, own.draws, both.draws) == (False, 1, 2)
    for one, other in zip(own.shares, both.shares, strict=True):
        assert (one.cause, one.share) == (other.cause, other.share)
        assert one.low >= other.low
        assert one.high <= other.high
    assert sum(one.high - one.low for one in own.shares) < sum(one.high - one.low for one in both.shares)


def test_a_page_shows_the_sentence_first_and_both_flights(tmp_path: Path) -> None:
    case = short("stack3")
    file = write_page(FOUND, RecordedCase(case, fly_flight_case(case), 1e-13), "a bag", tmp_path)
    page = file.read_text()
    assert (
        page.index(explanation_sentence(FOUND))
        < page.index('"name":"as flown"')
        < page.index('"name":"without downwash"')
    )
    assert "<td>61.0</td><td>55.0</td><td>67.0</td>" in page
    assert "that of other orders and other draws of noise, losses and gusts." in page


@pytest.mark.parametrize(
    ("all_orders", "draws", "note"),
    [
        (False, 1, "The 95 % interval is that of other orders."),
        (True, 2, "The 95 % interval is that of other draws of noise, losses and gusts."),
        (True, 1, "All orders were flown with one seed, so the shares have no interval."),
    ],
)
def test_a_page_says_what_its_intervals_are_of(
    tmp_path: Path, *, all_orders: bool, draws: int, note: str
) -> None:
    case = short("stack3")
    nothing = (CauseShare("latency", -1e-5, -2e-5, 1e-5),)
    found = replace(FOUND, shares=nothing, all_orders=all_orders, draws=draws)
    page = write_page(found, RecordedCase(case, fly_flight_case(case), 0.0), "a bag", tmp_path).read_text()
    assert note in page
    assert "<td>0.0</td><td>0.0</td><td>0.0</td>" in page


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the bag of a short campaign run with a replanner, which its metadata do not name."""
    run = draw_run(0)
    document = {**run.document, "duration": 1.5}
    short_run = Run(0, document, replace(run.options, controller="pid", replan="safe"))
    folder = tmp_path_factory.mktemp("kept")
    keep_run(short_run, fly_pure(short_run).signals, folder)
    return folder / "0"


def test_a_bag_is_flown_again_to_the_last_bit(kept: Path) -> None:
    found = recorded_case(kept)
    assert found.difference < 1e-9
    assert found.case.seed == 0


def test_of_a_bag_that_ends_early_only_the_recorded_flight_is_explained(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = recorded_case(kept)
    monkeypatch.setattr(cases, "read_flight", lambda bag: part_of_flight(read_flight(bag), 0.0, 0.2))
    found = recorded_case(kept)
    assert found.difference < 1e-9
    assert found.flight.t[-1] == pytest.approx(0.2)
    np.testing.assert_array_equal(found.flight.true_pos, whole.flight.true_pos[: len(found.flight.t)])


def test_a_bag_that_another_flight_left_is_refused(kept: Path, capsys: pytest.CaptureFixture[str]) -> None:
    metadata = kept / "metadata.yaml"
    text = metadata.read_text()
    metadata.write_text(
        text.replace("mode: aware_unlimited", "mode: ignoring").replace("seed: '0'", "seed: '1'")
    )
    assert main([str(kept)]) == 1
    assert "off its recorded position" in capsys.readouterr().err
    metadata.write_text(text.replace("seed: '0'", "sea: '0'"))
    assert main([str(kept)]) == 1
    assert "its metadata lack seed" in capsys.readouterr().err
    for wrong in ("0", "nan", "inf", "long"):
        metadata.write_text(text.replace("duration: '1.5'", f"duration: '{wrong}'"))
        assert main([str(kept)]) == 1
        printed = capsys.readouterr().err
        assert (
            printed == f"explain: {kept}: duration '{wrong}' in its metadata: seconds, above 0, are allowed\n"
        )
    metadata.write_text(text)


@pytest.mark.parametrize("written", [("--out",), ("--json", "why.json")])
def test_a_place_that_cannot_be_written_is_refused_before_any_flight(
    kept: Path,
    tmp_path: Path,
    written: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    nowhere = tmp_path / "out"
    nowhere.symlink_to(tmp_path / "gone")
    monkeypatch.setattr(cases, "fly_flight_case", lambda _: pytest.fail("flown"))
    assert main([str(kept), written[0], str(nowhere.joinpath(*written[1:]))]) == 1
    assert capsys.readouterr().err == f"explain: {nowhere}: File exists\n"


def test_a_scenario_in_a_bag_comes_before_files_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    bag = tmp_path / "bags" / "bag"
    facts = FlightFacts(scenario="scenario.yaml", model="none")
    for place, height in ((tmp_path / "bags", 1.0), (tmp_path, 2.0), (bag, 3.0)):
        place.mkdir(exist_ok=True)
        path = [{"t": t, "pos": [0.0, 0.0, height]} for t in (0.0, 1.0)]
        (place / "scenario.yaml").write_text(yaml.safe_dump({"vehicles": {"cf1": path}}))
        assert flown_scenario(facts, bag).waypoints[0].waypoints[0].pos[2] == height


def test_the_help_says_which_orders_are_allowed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "an even number of 4 or more (default 8)" in " ".join(capsys.readouterr().out.split())


def test_a_scenario_is_that_of_the_metadata() -> None:
    facts = FlightFacts("crazyflie_2_1", "stock", "stack3", "aware", "pid", "", "none", "", "ring", "0")
    flown = flown_scenario(facts, Path())
    assert (flown.vehicle.name, flown.air, flown.model) == ("crazyflie_2_1", "ring", "none")
    in_wake = flown_scenario(replace(facts, air="", wake="paper"), Path())
    assert (in_wake.air, in_wake.wake) == ("", "paper")
    without = flown_scenario(replace(facts, air="room without residual without wind"), Path())
    assert (without.air, without.air_without) == ("room", ("residual", "wind"))
    for stated, length in (("", 40.0), ("47.5", 47.5), ("0.5", 0.5)):  # without one, that of the scenario
        assert flown_scenario(replace(facts, duration=stated), Path()).duration == length


@pytest.mark.parametrize(
    ("duration", "text"), [(36.0, "36"), (1234.5678, "1234.5678"), (0.1234567, "0.1234567")]
)
def test_the_duration_of_a_flight_is_in_its_metadata_to_the_last_digit(duration: float, text: str) -> None:
    facts = scenario_facts(replace(library.load("stack3"), duration=duration), BlockChoices(), 0)
    assert facts.duration == text


@pytest.mark.parametrize(("left", "faults", "gusts", "first"), [
    # loss 1 m; shares: wind 0.4, lost messages 0.3, control 0.2
    ({"wind": 0.9, "lost messages": 0.8, "control": 0.7}, (), 0.1, "wind"),  # takes none: the largest share
    ({"wind": 0.1, "lost messages": 0.1, "control": 0.1}, (), 2.0, "wind"),  # a storm
    ({"wind": 0.1, "lost messages": 0.1, "control": 0.1}, (), 0.1, "lost messages"),  # gusts of every room
    ({"wind": 0.1, "lost messages": 0.8, "control": 0.1}, (), 0.1, "control"),
    ({"wind": 0.1, "lost messages": 0.1, "control": 0.1}, ("radio_loss",), 2.0, "lost messages"),
    ({"wind": 0.1, "lost messages": 0.8, "control": 0.1}, ("radio_loss",), 2.0, "wind"),
    ({"wind": 0.1, "lost messages": 0.8, "control": 0.1}, ("late",), 2.0, "wind"),
])  # fmt: skip
def test_of_causes_that_only_act_together_the_unusual_one_is_first(
    left: dict[str, float], faults: tuple[str, ...], gusts: float, first: str
) -> None:
    own = library.load("table6")
    struck = tuple(Fault(kind, 1.0, 1.0, (), 0.9) for kind in faults)
    scenario = replace(own, faults=struck, disturbance=replace(own.disturbance, air_std=gusts))
    shares_of = {"wind": 0.4, "lost messages": 0.3, "control": 0.2}
    case, loss = flight_case(scenario, BlockChoices("ignoring"), 0), Loss("distance", "cf1", 0, 3.0, 1.0)
    assert first_cause(case, loss, shares_of, lambda out: left[next(iter(out))]) == first


def test_a_fault_after_the_loss_or_from_the_start_is_no_event_and_a_flight_may_have_no_cause() -> None:
    loss = Loss("distance", "cf1", 0, 3.0, 1.0)
    for start in (0.0, 3.5):
        scenario = replace(library.load("table6"), faults=(Fault("radio_loss", start, 9.0, (), 0.9),))
        case = flight_case(scenario, BlockChoices("ignoring"), 0)
        found = first_cause(case, loss, {"control": 0.4, "lost messages": 0.3}, lambda _: 0.1)
        assert found == "control"
    assert first_cause(case, loss, {}, lambda _: 1.0) is None
