"""Facts of a flight are stored in its bag and read back."""

from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader as ForeignReader

from q2q_model.bag import (
    BagWriter,
    FlightFacts,
    facts_as_text,
    facts_from_text,
    read_facts,
)


def test_the_facts_of_a_flight_are_read_back_here_and_by_an_independent_reader(tmp_path: Path):
    facts = FlightFacts(vehicle="textbook_065", scenario="table6", seed="3")
    assert facts_from_text(facts_as_text(facts)) == facts
    with BagWriter(tmp_path / "bag", facts=facts):
        pass
    assert read_facts(tmp_path / "bag") == facts
    assert read_facts(tmp_path / "bag" / "bag_0.mcap") == facts
    with ForeignReader(tmp_path / "bag") as reader:
        assert reader.message_count == 0
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        (record,) = make_reader(stream).iter_metadata()
    output = yaml.safe_load(record.metadata["serialized_metadata"])["custom_data"]
    assert output == {"vehicle": "textbook_065", "scenario": "table6", "seed": "3"}


@pytest.mark.parametrize(
    ("damage", "left"),
    [
        ("rosbag2_bagfile_information:\n  custom_data: {vehicle: a, pilot: b}\n", FlightFacts(vehicle="a")),
        ("rosbag2_bagfile_information:\n  custom_data: [vehicle]\n", FlightFacts()),
        ("rosbag2_bagfile_information: 3\n", FlightFacts()),
        ("{", FlightFacts()),
        ("rosbag2_bagfile_information: {custom_data: {flown: 2024-13-45}}\n", FlightFacts()),  # no date
        ("rosbag2_bagfile_information: {custom_data: {flown: !!bool x}}\n", FlightFacts()),
        ("", FlightFacts()),
        (None, FlightFacts()),
    ],
)
def test_facts_that_are_not_there_are_empty_and_those_of_others_passed_over(
    tmp_path: Path, damage: str | None, left: FlightFacts
):
    with BagWriter(tmp_path / "bag", facts=FlightFacts(vehicle="textbook_065")):
        pass
    metadata = tmp_path / "bag" / "metadata.yaml"
    metadata.unlink() if damage is None else metadata.write_text(damage)
    assert read_facts(tmp_path / "bag") == left
    assert read_facts(tmp_path / "bag" / "another.mcap") == FlightFacts()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["vehicle"], "fact 'vehicle': write name=value; name must be one of vehicle, firmware, scenario"),
        (["pilot=me"], "fact 'pilot=me': write name=value"),
        (["vehicle=crazyflie2_1"], "unknown vehicle 'crazyflie2_1'"),
        (["vehicle=crazyflie_2_1", "firmware=stok"], "stok"),
        (["seed=1", "seed=2"], "fact seed is given twice: 1 and 2"),
    ],
)
def test_a_fact_there_is_not_is_refused_with_those_there_are(words: list[str], says: str):
    with pytest.raises(ValueError, match=says):
        facts_from_text(words)
