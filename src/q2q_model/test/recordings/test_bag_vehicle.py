"""Which vehicle flew a bag: the asked one, the bag's, or the default with a note."""

from pathlib import Path

import pytest

from q2q_model.bag import BagWriter, FlightFacts
from q2q_model.commands import evaluate, identify
from q2q_model.recordings.bag_vehicle import common_vehicle, flown_vehicle
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1, TEXTBOOK_065, firmware_of, on_firmware


def bag_of(folder: Path, vehicle: str, firmware: str = "") -> Path:
    with BagWriter(folder, facts=FlightFacts(vehicle=vehicle, firmware=firmware)):
        return folder


def test_the_asked_vehicle_comes_before_the_bags_own_and_that_before_the_default(tmp_path: Path):
    heavy, silent = bag_of(tmp_path / "heavy", "textbook_065"), bag_of(tmp_path / "silent", "")
    assert flown_vehicle(heavy, "crazyflie_2_1").vehicle == CRAZYFLIE_2_1
    assert (flown_vehicle(heavy).vehicle, flown_vehicle(heavy).note) == (TEXTBOOK_065, "")
    assert flown_vehicle(silent).vehicle == CRAZYFLIE_2_0
    assert "silent does not name its vehicle: crazyflie_2_0 is assumed" in flown_vehicle(silent).note


def test_a_bag_says_on_which_firmware_its_vehicle_flew(tmp_path: Path):
    for vehicle in (CRAZYFLIE_2_1, on_firmware(CRAZYFLIE_2_1, "thrust_upgrade"), TEXTBOOK_065):
        bag = bag_of(tmp_path / f"{vehicle.name}{vehicle.thrust_max}", vehicle.name, firmware_of(vehicle))
        assert flown_vehicle(bag).vehicle == vehicle


def test_a_vehicle_that_does_not_exist_is_refused_with_the_remedy_and_can_be_overruled(tmp_path: Path):
    bag = bag_of(tmp_path / "odd", "crazyflie_9")
    with pytest.raises(
        ValueError, match=r"odd: unknown vehicle 'crazyflie_9'; choose one of .*; name the vehicle with"
    ):
        flown_vehicle(bag)
    assert flown_vehicle(bag, "crazyflie_2_1").vehicle == CRAZYFLIE_2_1


def test_several_bags_have_one_vehicle_or_are_refused(tmp_path: Path):
    heavy, silent = bag_of(tmp_path / "heavy", "textbook_065"), bag_of(tmp_path / "silent", "")
    light = bag_of(tmp_path / "light", "crazyflie_2_0")
    assert common_vehicle([heavy, heavy]).vehicle == TEXTBOOK_065
    found = common_vehicle([silent, heavy, silent])
    assert found.vehicle == TEXTBOOK_065
    assert "silent and 1 more: textbook_065 is assumed" in found.note
    with pytest.raises(
        ValueError, match=r"heavy of textbook_065, .*light of crazyflie_2_0: process them separately"
    ):
        common_vehicle([heavy, light])
    assert common_vehicle([heavy, light], "crazyflie_2_0").vehicle == CRAZYFLIE_2_0


def test_identify_and_evaluate_refuse_an_unknown_vehicle_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    bag = str(bag_of(tmp_path / "odd", "crazyflie_9"))
    assert identify.main([bag, "--out", str(tmp_path / "model.q2q")]) == 1
    assert "identify: bag" in (lines := capsys.readouterr().err)
    assert "unknown vehicle 'crazyflie_9'" in lines
    assert evaluate.main([bag, "--model", "none"]) == 1
    assert "Traceback" not in capsys.readouterr().err
