"""Results of flights: metrics and verdict, figures, bags and pages."""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import yaml

import q2q
from q2q_model.bag import BagError, FlightFacts
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.flights.flight import Flight
from q2q_sim.experiments.explanation.recorded_setup import SAME, recorded_setup
from q2q_sim.faults.faults import Fault
from q2q_sim.flight_bag.bag_verdict import bag_verdict
from q2q_sim.monitors.metrics.flight_metrics import measure
from q2q_sim.scenarios.scenario_to_document import document_of

SHORT = replace(q2q.scenario("table6_room", air="room"), duration=0.5)


@pytest.fixture(scope="module")
def flight() -> q2q.FlightResult:
    """Return a short flight in a room's air."""
    return q2q.fly(SHORT)


def test_a_printed_result_says_what_flew_and_how_it_ended(flight: q2q.FlightResult):
    assert repr(flight) == (
        "<FlightResult table6_room, PID, aware, seed 0: cf1, cf2; ok: 0.5 s flown to the end>"
    )
    recorded = replace(flight, facts=FlightFacts())
    assert repr(recorded).startswith(f"<FlightResult {flight.arrays.name}: cf1, cf2; ")


def test_a_printed_result_of_many_vehicles_gives_their_number():
    swarm = replace(q2q.scenario("swarm10"), duration=0.05)
    assert ": 10 vehicles; " in repr(q2q.fly(swarm))


def test_a_bag_holds_every_array_of_the_flight(flight: q2q.FlightResult, tmp_path: Path):
    read = q2q.read_bag(flight.to_bag(tmp_path / "bag"))
    for field in Flight.__dataclass_fields__:
        if field not in ("name", "names"):
            np.testing.assert_array_equal(getattr(read.arrays, field), getattr(flight.arrays, field), field)
    assert read.facts == flight.facts
    assert read.vehicle == flight.vehicle
    np.testing.assert_equal(asdict(read.metrics), asdict(flight.metrics))


def test_a_flight_of_a_changed_scenario_is_flown_again_by_its_bag_alone(tmp_path: Path):
    late = replace(SHORT, name="document", radio=replace(SHORT.radio, latency=0.05))
    bag = q2q.fly(late, seed=2).to_bag(tmp_path / "bag")
    assert q2q.read_bag(bag).facts.scenario == "scenario.yaml"
    found = recorded_setup(bag)
    assert found.difference < 1e-9
    assert found.setup.scenario.radio.latency == 0.05


def test_a_flight_longer_than_its_named_scenario_is_flown_again_to_its_end(tmp_path: Path):
    file = tmp_path / "short.yaml"
    file.write_text(yaml.safe_dump(document_of(replace(SHORT, duration=0.3))), encoding="utf-8")
    flight = q2q.fly(replace(q2q.scenario(file), duration=0.5))
    named = replace(flight, facts=replace(flight.facts, scenario=str(file)))
    found = recorded_setup(named.to_bag(tmp_path / "bag"))
    assert not (tmp_path / "bag" / "scenario.yaml").exists()
    np.testing.assert_array_equal(found.flight.t, flight.arrays.t)
    assert found.difference < 1e-9


def test_a_flight_corrected_with_a_models_own_residual_is_flown_again_with_it(tmp_path: Path):
    """With that of the real flights a vehicle was 9 mm elsewhere, and the flight refused."""
    loud = replace(ResidualProcess(), noise=8.0 * ResidualProcess().noise)
    model = q2q.save_model(replace(q2q.load_model("measured_law"), residual=loud), tmp_path / "own.q2q")
    flight = q2q.fly(SHORT, model=model, correct=True)
    found = recorded_setup(flight.to_bag(tmp_path / "bag"))
    assert found.difference < 1e-9
    usual = q2q.fly(SHORT, model="measured_law", correct=True)
    assert np.abs(usual.arrays.true_pos - flight.arrays.true_pos).max() > SAME  # the residual matters


@pytest.mark.parametrize(
    ("changed", "unknown"),
    [
        ({"model": "ModelFile"}, "no model 'ModelFile'"),
        ({"air": "RoomAir"}, "no air 'RoomAir'"),
        ({"controller": "Pd"}, "unknown controller 'Pd'"),
    ],
)
def test_a_flight_by_an_object_is_not_flown_again(
    flight: q2q.FlightResult, tmp_path: Path, changed: dict[str, str], unknown: str
):
    bag = replace(flight, facts=replace(flight.facts, **changed)).to_bag(tmp_path / "bag")
    with pytest.raises(ValueError, match=rf"bag: {unknown}: .*; a Python object cannot be flown again"):
        recorded_setup(bag)


def test_a_bag_whose_metadata_name_its_scenario_holds_none(flight: q2q.FlightResult, tmp_path: Path):
    bag = flight.to_bag(tmp_path / "bag")
    assert sorted(file.name for file in bag.iterdir()) == ["bag_0.mcap", "metadata.yaml"]
    assert recorded_setup(bag).difference < 1e-9


def test_a_flight_of_a_bag_is_not_written_again(flight: q2q.FlightResult, tmp_path: Path):
    read = q2q.read_bag(flight.to_bag(tmp_path / "bag"))
    with pytest.raises(BagError, match="copy"):
        read.to_bag(tmp_path / "copy")


def test_an_assumed_vehicle_is_a_warning(flight: q2q.FlightResult, tmp_path: Path):
    silent = replace(flight, facts=FlightFacts()).to_bag(tmp_path / "silent")
    with pytest.warns(UserWarning, match=r"crazyflie_2_0 is assumed; name it with .*in Python vehicle="):
        assert q2q.read_bag(silent).vehicle.name == "crazyflie_2_0"


def test_metrics_and_verdict_are_those_of_the_monitors(flight: q2q.FlightResult):
    np.testing.assert_equal(asdict(flight.metrics), asdict(measure(flight.arrays, SHORT.vehicle)))
    assert flight.verdict.ok
    assert "0.5 s" in str(flight.verdict)


@pytest.mark.parametrize("part", ["vehicle", "plan"])
def test_a_bag_that_cannot_hold_its_scenario_says_so_and_holds_the_faults(part: str, tmp_path: Path):
    sag = Fault("battery_sag", 0.01, 0.02, ("cf1",), 0.3)
    named = replace(SHORT, duration=0.05, faults=(sag,))
    heavy, planned = replace(SHORT.vehicle, mass=0.04), q2q.plan(SHORT)
    flown = q2q.fly(replace(named, vehicle=heavy) if part == "vehicle" else replace(named, plan=planned))
    with pytest.warns(UserWarning, match=f"table6_room: a bag does not store its {part}"):
        bag = flown.to_bag(tmp_path / "bag")
    read = q2q.read_bag(bag, SHORT.vehicle.name)
    assert read.faults == (sag,)
    assert read.facts.vehicle == ("" if part == "vehicle" else SHORT.vehicle.name)


@pytest.mark.filterwarnings("ignore::q2q_model.bag.BagRepairWarning")
def test_a_recorded_flight_is_judged_up_to_the_end_of_its_bag(flight: q2q.FlightResult, tmp_path: Path):
    whole = flight.to_bag(tmp_path / "whole")
    early = replace(flight, facts=replace(flight.facts, duration="50")).to_bag(tmp_path / "early")
    cut = tmp_path / "cut"
    cut.mkdir()
    written = (whole / "whole_0.mcap").read_bytes()
    (cut / "cut_0.mcap").write_bytes(written[: len(written) * 3 // 4])
    verdicts = []
    for bag in (whole, early, cut):
        read = q2q.read_bag(bag, "crazyflie_2_0")
        assert read.verdict == bag_verdict(bag, read.arrays, read.vehicle)
        verdicts.append(read.verdict)
    assert [verdict.ok for verdict in verdicts] == [True, False, False]
    assert "the flight ended at 0.5 s of 50.0 s, before its end" in str(verdicts[1])


def test_a_figure_draws_the_chosen_vehicle_of_each_flight(flight: q2q.FlightResult):
    other = q2q.fly(SHORT, seed=1)
    axes = q2q.plot({"seed 0": flight, "seed 1": other}, "altitude", "cf2").axes[0]
    drawn = {line.get_label(): np.asarray(line.get_ydata()) for line in axes.lines}
    for label, one in (("seed 0", flight), ("seed 1", other)):
        np.testing.assert_array_equal(drawn[label], one.arrays.true_pos[:, 1, 2])


def test_a_figure_of_an_unknown_vehicle_or_kind_is_refused(flight: q2q.FlightResult):
    with pytest.raises(ValueError, match="cf1, cf2"):
        flight.plot("altitude", "cf9")
    with pytest.raises(ValueError, match="altitude"):
        flight.plot("speed")  # type: ignore[arg-type]


def test_flights_without_labels_are_refused_by_figures_and_pages(flight: q2q.FlightResult, tmp_path: Path):
    with pytest.raises(TypeError, match=r"flights is int; must be a mapping of labels to flights"):
        q2q.plot(3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"flights is list"):
        q2q.page([flight], tmp_path / "page.html")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"flights has str: int"):
        q2q.plot({"first": flight, "second": 2})  # type: ignore[dict-item]
    with pytest.raises(ValueError, match=r"flights is empty"):
        q2q.page({}, tmp_path / "page.html")


def test_a_page_replays_the_flights_under_their_labels(flight: q2q.FlightResult, tmp_path: Path):
    text = q2q.page({"first": flight, "second": flight}, tmp_path / "new" / "page.html", "Two").read_text()
    assert text.count('<script type="application/json">') == 2
    assert "<h1>Two</h1>" in text
    assert flight.page(tmp_path / "one.html").read_text().count('<script type="application/json">') == 1


def test_bag_and_page_judge_a_flight_by_the_faults_of_its_scenario(tmp_path: Path):
    at = [{"t": 0.0, "pos": [0.0, 0.0, 2.0]}, {"t": 4.0, "pos": [0.0, 0.0, 2.0]}]
    jump = {"kind": "jump", "start": 0.5, "duration": 2.5, "vehicles": ["cf1"], "size": -1.6}
    flown = q2q.fly({"vehicle": "crazyflie_2_0", "vehicles": {"cf1": at}, "faults": [jump], "duration": 4.0})
    assert np.abs(flown.arrays.true_pos - flown.arrays.ref_pos).max() > 1.5  # it follows its markers
    assert str(flown.verdict).endswith("from its setpoint (a marker was displaced: policies allow for it)")
    read = q2q.read_bag(flown.to_bag(tmp_path / "bag"))
    assert read.faults == flown.faults
    assert str(read.verdict) == str(flown.verdict)
    assert str(flown.verdict) in flown.page(tmp_path / "page.html").read_text()
