"""The command flies encounters, learns a tube or judges one, and says what it cannot do."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from blank_encounters import BLANK, CONDITIONS

from q2q_model.documents.plain_values import to_plain
from q2q_sim.commands.promise import main
from q2q_sim.experiments.promise import promise_flights
from q2q_sim.experiments.promise.kept_flights import resume_flights
from q2q_sim.experiments.promise.room_encounter import (
    STEADY,
    EncounterRecord,
    PromiseCase,
)
from q2q_sim.experiments.promise.tracking_tube import (
    TubeFlights,
    learn_tube,
    read_tube,
)


def test_the_command_warns_of_flights_that_gave_the_tube(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(promise_flights, "_flown", lambda *_: [BLANK])
    flown = TubeFlights(first=0, count=200, horizontal=0.12, vertical=0.12)
    file = tmp_path / "tube.json"
    file.write_text(json.dumps(to_plain(learn_tube(np.full((200, 2), 0.1), 0.05, CONDITIONS, flown))))
    assert main(["--count", "1", "--tube", str(file)]) == 0
    assert capsys.readouterr().err.startswith(
        "promise: the tube was learned from seeds 0 to 199, which cannot test it"
    )
    assert main(["--count", "1", "--first", "200", "--tube", str(file)]) == 0
    assert capsys.readouterr().err == ""


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
    with pytest.raises(ValueError, match="flights with another tube"):
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
    assert said == "promise: --alpha 0.1 applies to the tube that --learn FILE writes: give both\n"


def test_a_process_that_dies_ends_the_command_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(promise_flights, "spread_work", lambda _, __, seeds, died: map(died, seeds))
    assert main(["--first", "7", "--count", "2"]) == 1
    said = capsys.readouterr().err.strip()  # after an empty progress bar
    assert said == "promise: encounter 7: its process died when flown alone"
