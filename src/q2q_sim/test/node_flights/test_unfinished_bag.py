"""No flight whose bag is cut is ok: not where it was flown, and not where the bag is read later."""

import warnings
from pathlib import Path

import pytest
import yaml
from full_disk import full_after

from q2q_model.bag import BagError, BagRepairWarning, BagWriter
from q2q_model.recordings.bag_vehicle import flown_vehicle
from q2q_model.signals.layout import Signal
from q2q_sim.commands import replay_page
from q2q_sim.flight_bag.recorded_trace import trace_in
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun, runs_json
from q2q_sim.node_flights.scenario_flight import MEASURED, recorded_run
from q2q_sim.node_flights.unfinished_bag import why_unfinished
from q2q_sim.scenarios import library
from q2q_sim.simulator.flight_clock import FlightTiming
from q2q_sim.tools.fly_scenario import print_verdict
from q2q_sim.tools.report_bags import report_bag, verdicts

DURATION = 4.0
TIMING = FlightTiming(400, 0, 10.0, latency_p50_ms=1.0, latency_p99_ms=2.0)
Messages = list[tuple[str, int, Signal]]


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a hover of two vehicles."""
    file = tmp_path_factory.mktemp("scenario") / "hover.yaml"
    vehicles = {
        name: [{"t": t, "pos": [0.0, y, 1.0]} for t in (0.0, DURATION)]
        for name, y in (("cf1", 0.0), ("cf2", 1.0))
    }
    file.write_text(yaml.safe_dump({"duration": DURATION, "vehicles": vehicles}))
    return file


@pytest.fixture(scope="module")
def messages(scenario: Path) -> Messages:
    """Return what is recorded of the hover."""
    heard: Messages = []

    def hear(topic: str, stamp_ns: int, signal: Signal) -> None:
        if topic in MEASURED:
            heard.append((f"/{topic}", stamp_ns, signal))

    fly(library.load(str(scenario)), FlightOptions(on_signal=hear))
    return heard


def record(messages: Messages, bag: Path) -> None:
    with BagWriter(bag) as writer:
        for topic, stamp_ns, signal in messages:
            writer.write_signal(topic, stamp_ns, signal)


def record_on_full_disk(messages: Messages, bag: Path, share: float, log: Path) -> None:
    """Record until the disk takes no more than a share of the bag; what the recorder says is in a log."""
    whole = bag.with_name("whole")
    record(messages, whole)
    size = (whole / "whole_0.mcap").stat().st_size
    with full_after(int(share * size)), pytest.raises(BagError, match="File too large") as refusal:
        record(messages, bag)
    log.parent.mkdir(parents=True)
    log.write_text(f"a line of another node\nbag_record: {refusal.value}; nothing more is recorded\n")


def flown_run(scenario: Path, bag: Path, folder: Path) -> FlightRun:
    return recorded_run(FlightRequest(str(scenario), record=MEASURED), TIMING, folder, bag)


def test_a_flight_whose_bag_is_whole_is_ok(scenario: Path, messages: Messages, tmp_path: Path) -> None:
    record(messages, tmp_path / "bag")
    run = flown_run(scenario, tmp_path / "bag", tmp_path)
    assert str(run.verdict) == "ok: 4.0 s flown to the end"
    assert print_verdict([run]) == 0


def test_a_flight_whose_bag_ends_early_is_not_ok_and_says_when(
    scenario: Path, messages: Messages, tmp_path: Path
) -> None:
    record([one for one in messages if one[1] < 1_300_000_000], tmp_path / "bag")
    run = flown_run(scenario, tmp_path / "bag", tmp_path)
    assert str(run.verdict) == "the flight ended at 1.3 s of 4.0 s, before its end"


def test_a_bag_with_vehicles_of_another_simulator_is_not_judged(
    scenario: Path, messages: Messages, tmp_path: Path
) -> None:
    others = scenario.with_name("alone.yaml")
    document = yaml.safe_load(scenario.read_text())
    others.write_text(yaml.safe_dump(document | {"vehicles": {"cf2": document["vehicles"]["cf2"]}}))
    record(messages, tmp_path / "bag")
    said = r"^another simulator flew in this ROS domain \(vehicles cf1\): set another ROS_DOMAIN_ID$"
    with pytest.raises(ValueError, match=said):
        flown_run(others, tmp_path / "bag", tmp_path)


def test_a_flight_whose_disk_was_full_is_not_ok_and_says_what_is_missing(
    scenario: Path, messages: Messages, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag, folder = tmp_path / "bag", tmp_path / "nodes"
    record_on_full_disk(messages, bag, 0.5, folder / "stack.log")
    with pytest.warns(BagRepairWarning):
        run = flown_run(scenario, bag, folder)
    assert print_verdict([run]) == 1
    end = run.flight.t[-1]
    assert 0.9 < end < 3.5
    sentence = (
        f"the bag {bag} can be read up to {end:.1f} s of 4.0 s, and nothing later is judged (File too "
        "large): make room or choose another disk, and fly again"
    )
    assert capsys.readouterr().out == f"verdict: {sentence}\n"
    document = runs_json([run])
    assert isinstance(document, dict)
    assert isinstance(document["runs"], list)
    (found,) = document["runs"]
    assert isinstance(found, dict)
    assert (found["ok"], found["verdict"]) == (False, sentence)


def test_a_bag_in_which_nothing_can_be_read_is_an_error_with_its_reason(
    scenario: Path, messages: Messages, tmp_path: Path
) -> None:
    bag, folder = tmp_path / "bag", tmp_path / "nodes"
    record_on_full_disk(messages, bag, 0.01, folder / "bag_record.log")
    with pytest.raises(BagError, match=r"nothing of the flight can be read .*\(File too large\): make room"):
        flown_run(scenario, bag, folder)


@pytest.mark.parametrize("share", [0.5, 0.01])
def test_of_a_temporary_bag_the_folder_without_room_is_named(
    scenario: Path, messages: Messages, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    """The bag itself is deleted before anybody could look for it."""
    bag, folder = tmp_path / "bag", tmp_path / "nodes"
    record_on_full_disk(messages, bag, share, folder / "stack.log")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "small"))
    request = FlightRequest(str(scenario), record=MEASURED, temporary=True)
    try:
        with warnings.catch_warnings(action="ignore", category=BagRepairWarning):
            said = str(recorded_run(request, TIMING, folder, bag).verdict)
    except BagError as error:
        said = str(error)
    assert f"temporary bag in {tmp_path / 'small'} " in said
    assert said.endswith("(File too large): make room there or set another TMPDIR, and fly again")
    assert str(bag) not in said


def test_a_bag_that_is_not_closed_is_unfinished_without_a_log_too(messages: Messages, tmp_path: Path) -> None:
    record(messages, tmp_path / "bag")
    assert why_unfinished(tmp_path / "bag", tmp_path) == ""
    (tmp_path / "bag" / "metadata.yaml").unlink()
    assert why_unfinished(tmp_path / "bag", tmp_path) == "its recorder did not close it"


def test_who_reads_a_cut_bag_later_learns_that_its_end_is_unknown(
    messages: Messages, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "bag"
    record_on_full_disk(messages, bag, 0.5, tmp_path / "nodes" / "bag_record.log")
    flown = flown_vehicle(tmp_path / "whole", "crazyflie_2_0")
    with pytest.warns(BagRepairWarning):
        found = verdicts([report_bag(bag, flown)])
    assert found.startswith("verdict: the recording was cut off at ")
    assert verdicts([report_bag(tmp_path / "whole", flown)]) == "verdict: ok: 4.0 s flown to the end"
    with pytest.warns(BagRepairWarning) as warned:
        trace_in(bag)
    assert "no metadata" in str(warned[0].message)
    words = [str(bag), "--vehicle", "crazyflie_2_0", "--out", str(tmp_path / "replay.html")]
    for part, known in (([], False), (["--end", "100"], False), (["--end", "0.5"], True)):
        replay_page.main([*words, *part])
        said = capsys.readouterr().out
        assert ("the recording was cut off at " not in said) == known
        assert ("ok: 0.5 s judged, a part of the flight" in said) == known
