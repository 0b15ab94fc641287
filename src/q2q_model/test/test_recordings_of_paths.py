"""Flights among files and folders, and the vehicle of tables, which name none."""

from pathlib import Path

import pytest

from q2q_model.bag import TopicMap
from q2q_model.recordings.recording_files import flights_among
from q2q_model.recordings.recordings_of_paths import recordings_of_paths
from q2q_model.tools.vehicle_of_flights import vehicle_of_flights
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1

HEAD = "t,x,y,z\n"
ROWS = "".join(f"{0.01 * k},0,0,1\n" for k in range(3))


def test_every_table_of_a_flight_in_a_folder_is_read_and_lists_are_named(tmp_path: Path):
    (tmp_path / "one.csv").write_text(HEAD + ROWS)
    (tmp_path / "two.csv").write_text('"t","cf1_x","cf1_y","cf1_z"\n' + ROWS)
    (tmp_path / "manifest.csv").write_text("name,seconds\none,40\n")
    (tmp_path / "notes.txt").write_text("")
    found, notes = flights_among([tmp_path])
    assert [path.name for path in found] == ["one.csv", "two.csv"]
    assert notes == [f"skipped: {tmp_path / 'manifest.csv'} has no column t: it is no flight"]
    recordings, notes = recordings_of_paths([tmp_path])
    assert [one.flight.name for one in recordings] == ["one", "two"]
    assert len(notes) == 1
    (tmp_path / "lists").mkdir()
    (tmp_path / "lists" / "manifest.csv").write_text("name\n")
    with pytest.raises(ValueError, match="neither a bag nor a table of a flight"):
        flights_among([tmp_path / "lists"])


def test_a_topic_map_without_a_bag_to_map_is_refused(tmp_path: Path):
    (tmp_path / "one.csv").write_text(HEAD + ROWS)
    with pytest.raises(ValueError, match=r"topics of bags, and .*one\.csv is a table: leave out --topics"):
        recordings_of_paths([tmp_path], TopicMap({"cf1": "/cf1/pose"}))


def test_the_vehicle_of_tables_is_assumed_with_a_note(tmp_path: Path):
    for name in ("one", "two"):
        (tmp_path / f"{name}.csv").write_text(HEAD + ROWS)
    flown = vehicle_of_flights([tmp_path])
    assert flown.vehicle == CRAZYFLIE_2_0
    assert flown.note.endswith("one.csv and 1 more: crazyflie_2_0 is assumed; name it with --vehicle")
    named = vehicle_of_flights([tmp_path], "crazyflie_2_1")
    assert named.vehicle == CRAZYFLIE_2_1
    assert named.note == ""
