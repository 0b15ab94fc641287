"""A tube file gives the tube back, and says under which conditions and for which flights it holds."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from blank_encounters import CONDITIONS

from q2q_model.documents.plain_values import to_plain
from q2q_sim.experiments.promise.tracking_tube import (
    TubeFlights,
    learn_tube,
    read_tube,
)
from q2q_sim.experiments.promise.tube_report import different_conditions, reused_seeds, tube_lines


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
    [({"alpha": 7.0}, "alpha = 7; must be above 0 and below 1"), ({"vertical": 0.0}, "m; must be above 0")],
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
            "the tube was learned from seeds 100 to 299, which cannot test it; give --first 300"
        )
    assert reused_seeds(tube, 0, 100) is None
    assert reused_seeds(tube, 300, 100) is None


@pytest.mark.parametrize(
    ("flown", "said"),
    [
        (0.11, "flights with the flown one stay within it with probability 0.95"),
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
