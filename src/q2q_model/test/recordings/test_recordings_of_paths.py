"""Flights among files and folders, and the vehicle of tables, which name none."""

from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagWriter, TopicMap
from q2q_model.flights.tables.flight_table import flight_table
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.flights.tables.table_signals import signals_of
from q2q_model.recordings.recording_reader import flights_among
from q2q_model.recordings.recordings_of_paths import recordings_of_paths
from q2q_model.recordings.vehicle_of_flights import vehicle_of_flights
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1

HEAD = "t,x,y,z\n"
ROWS = "".join(f"{0.01 * k},0,0,1\n" for k in range(3))


def test_every_table_of_a_flight_in_a_folder_is_read_and_lists_are_named(tmp_path: Path):
    (tmp_path / "one.csv").write_text(HEAD + ROWS)
    (tmp_path / "two.csv").write_text('"t","cf1_x","cf1_y","cf1_z"\n' + ROWS.replace(",1", ",2"))
    (tmp_path / "manifest.csv").write_text("name,seconds\none,40\n")
    (tmp_path / "notes.txt").write_text("")
    found, notes = flights_among([tmp_path])
    assert [path.name for path in found] == ["one.csv", "two.csv"]
    assert notes == [f"skipped: {tmp_path / 'manifest.csv'} has no column t, so it is not a flight"]
    recordings, notes = recordings_of_paths([tmp_path])
    assert [one.flight.name for one in recordings] == ["one", "two"]
    assert len(notes) == 1
    (tmp_path / "lists").mkdir()
    (tmp_path / "lists" / "manifest.csv").write_text("name\n")
    with pytest.raises(ValueError, match="neither bags nor flight tables"):
        flights_among([tmp_path / "lists"])


def test_a_flight_without_a_position_says_what_its_kind_of_file_needs(tmp_path: Path) -> None:
    gaps = "".join(f"{row},1\n" for row in ROWS.split())
    (tmp_path / "lost.csv").write_text("t,x,y,z,gap\n" + gaps)
    wanted = r"lost\.csv: no vehicle has a position: x, y, z in a row whose gap is 0"
    with pytest.raises(ValueError, match=wanted):
        recordings_of_paths([tmp_path / "lost.csv"])
    bag = _imported(tmp_path / "lost.csv", tmp_path / "bag")
    with pytest.raises(ValueError, match=r"bag: no vehicle has a position; record the topic mocap or state"):
        recordings_of_paths([bag])


def test_a_table_that_is_no_flight_is_refused_by_its_name(tmp_path: Path) -> None:
    _table(tmp_path / "one.csv", 1)
    (tmp_path / "two.csv").write_text(HEAD + ROWS.splitlines()[0] + "\n" + ROWS)
    with pytest.raises(
        ValueError, match=r"^table .*two\.csv: t must begin at 0 or later and increase; row 1"
    ):
        recordings_of_paths([tmp_path])


def test_a_topic_map_without_a_bag_to_map_is_refused(tmp_path: Path):
    (tmp_path / "one.csv").write_text(HEAD + ROWS)
    with pytest.raises(ValueError, match=r"applies to bags, but .*one\.csv is a table: leave out --topics"):
        recordings_of_paths([tmp_path], TopicMap({"cf1": "/cf1/pose"}))


def _table(path: Path, seed: int) -> Path:
    """Write a table of a flight that is another one for each seed; return its path."""
    path.parent.mkdir(exist_ok=True)
    rows = np.column_stack([0.01 * np.arange(5), np.random.default_rng(seed).normal(size=(5, 3))])
    np.savetxt(path, rows, delimiter=",", header="t,x,y,z", comments="", fmt="%.17g")
    return path


def _imported(table: Path, bag: Path) -> Path:
    with BagWriter(bag) as writer:
        for topic, signals in signals_of(flight_table(read_columns(table))).items():
            for signal in signals:
                writer.write_signal(topic, round(signal.t * 1e9), signal)
    return bag


def test_a_flight_given_twice_under_two_names_is_refused(tmp_path: Path) -> None:
    table, other = _table(tmp_path / "one.csv", 0), _table(tmp_path / "two.csv", 1)
    bag, copy = _imported(table, tmp_path / "room"), _table(tmp_path / "copy.csv", 0)
    for again in (bag, copy):
        with pytest.raises(
            ValueError, match=r"one\.csv contain the same flight|copy\.csv contain the same flight"
        ):
            recordings_of_paths([other, table, again])
    with pytest.raises(ValueError, match=r"two\.csv is given twice; give each flight once"):
        recordings_of_paths([other, table, other])
    assert len(recordings_of_paths([other, bag])[0]) == 2


def test_flights_of_one_name_have_their_folders_in_it(tmp_path: Path) -> None:
    tables = [_table(tmp_path / folder / "flight.csv", k) for k, folder in enumerate(("a", "b"))]
    bags = [_imported(_table(tmp_path / f"{k}.csv", k), tmp_path / f"c{k}" / "bag") for k in (2, 3)]
    named = [one.flight.name for one in recordings_of_paths([*tables, *bags])[0]]
    assert named == ["c2/bag", "c3/bag", "a/flight", "b/flight"]
    beside = _imported(_table(tmp_path / "4.csv", 4), tmp_path / "a" / "flight")
    named = [one.flight.name for one in recordings_of_paths([tables[0], beside])[0]]
    assert named == [str(beside), str(tables[0])]


def test_the_vehicle_of_tables_is_assumed_with_a_note(tmp_path: Path):
    for name in ("one", "two"):
        (tmp_path / f"{name}.csv").write_text(HEAD + ROWS)
    flown = vehicle_of_flights([tmp_path])
    assert flown.vehicle == CRAZYFLIE_2_0
    assumed = "crazyflie_2_0 is assumed; name it with --vehicle (in Python vehicle=)"
    assert flown.note.endswith(f"one.csv and 1 more: {assumed}")
    named = vehicle_of_flights([tmp_path], "crazyflie_2_1")
    assert named.vehicle == CRAZYFLIE_2_1
    assert named.note == ""
