"""Vehicles of a licence are those that the program opens, whenever it does."""

from math import inf
from pathlib import Path

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from q2q_sim.commands.licence import main
from q2q_sim.licence.flight_order import FlightOrder, Program
from q2q_sim.licence.licence_flights import licence
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.room.licence_room import LicenceParams
from q2q_sim.licence.room.trials import LicenceTrial, TrialKind
from q2q_sim.licence.trial_processes import fly_trials

ONE_BY_ONE = """
import time
import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

cflib.crtp.init_drivers()
for number in (9, 8):
    with SyncCrazyflie(f"radio://0/80/2M/E7E7E7E70{number}") as scf:
        commander = scf.cf.high_level_commander
        commander.takeoff(0.4, 1.0)
        time.sleep(1.5)
        assert number == 9, "fails in the air"
        commander.land(0.0, 1.0)
        time.sleep(1.5)
        commander.stop()
"""
OPENED = """
import time
import cflib.crtp
from cflib.crazyflie import Crazyflie
cflib.crtp.init_drivers()
vehicles = [Crazyflie() for _ in range({count})]
for number, vehicle in enumerate(vehicles):
    vehicle.open_link(f"radio://0/80/2M/E7E7E7E7{{number:02X}}")
    time.sleep(0.1)
"""


def test_a_vehicle_that_is_opened_after_the_first_has_landed_is_judged(tmp_path: Path):
    file = tmp_path / "one_by_one.py"
    file.write_text(ONE_BY_ONE)
    found = licence(Program(file, (), tmp_path), LicenceOptions())
    (nominal,) = found.flights
    assert nominal.log is not None
    assert nominal.log.uris == ("radio://0/80/2M/E7E7E7E708", "radio://0/80/2M/E7E7E7E709")
    assert nominal.log.flew.all()
    assert [one.rule for one in nominal.failures] == ["motors", "landing", "program"]
    assert nominal.failures[2].why == "AssertionError: fails in the air, line 13"


SPELLED = """
import cflib.crtp
from cflib.crazyflie import Crazyflie
cflib.crtp.init_drivers()
for uri in ("radio://0/80/2M/E7E7E7E7E7", "radio://0/80/2M", "radio://1/80/2M/e7e7e7e7e7?rate_limit=100"):
    Crazyflie().open_link(uri)
"""


def test_spellings_of_one_uri_are_one_vehicle(tmp_path: Path):
    file = tmp_path / "spelled.py"
    file.write_text(SPELLED)
    order = FlightOrder(Program(file), LicenceParams(((0.0, 0.0, 0.0),)), LicenceTrial(), (), (), 30.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    assert flight.log is not None
    assert flight.log.end.unknown == ""
    assert flight.log.uris == ("radio://0/80/2M/E7E7E7E7E7",)


def test_a_program_that_opens_more_vehicles_than_a_radio_has_fails(tmp_path: Path):
    file = tmp_path / "sixteen.py"
    file.write_text(OPENED.format(count=16))
    (nominal,) = licence(Program(file), LicenceOptions()).flights
    what = "the program opens more vehicles than there are: radio://0/80/2M/E7E7E7E70F is one more than 15"
    assert [one.sentence.partition(" s ")[2] for one in nominal.failures] == [what]


def test_without_time_the_vehicles_that_a_program_opens_are_not_flown(tmp_path: Path):
    file = tmp_path / "two.py"
    file.write_text(OPENED.format(count=2))
    found = licence(Program(file), LicenceOptions(budget=0.0))
    (flight,) = found.flights
    assert [one.what for one in flight.failures] == [
        "no time is left to fly all vehicles that the program opens"
    ]
    assert (found.passed, found.judged, found.left_out) == (False, True, ())


@pytest.mark.parametrize(("starts", "count", "vehicles"), [(1, 2, "2 vehicles"), (2, 1, "1 vehicle")])
def test_starts_that_are_not_as_many_as_the_vehicles_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], starts: int, count: int, vehicles: str
) -> None:
    file = tmp_path / "opened.py"
    file.write_text(OPENED.format(count=count))
    places = [word for row in range(starts) for word in ("--start", "0", str(row), "0")]
    assert main([*places, str(file)]) == 2
    message = f"licence: {starts} --start for {vehicles}: give one for each, or none\n"
    assert capsys.readouterr().err == message


@pytest.mark.parametrize(
    ("places", "why"),
    [
        ("5 0 0", "--start 1 is at 5, 0 m: the room is 6 by 6 m around the origin; move it, or set --room"),
        ("0 0 0 --start 0 -3.1 0", "--start 2 is at 0, -3.1 m: the room is 6 by 6 m around the origin; move"),
        ("0 0 0 --start 0.05 0 0", "--start 1 and --start 2 are 0.05 m apart (minimum 0.14 m)\n"),
    ],
)
def test_starts_at_which_no_vehicle_can_stand_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], places: str, why: str
) -> None:
    """The program failed: its vehicles left the room, or collided, at 0.01 s."""
    file = tmp_path / "opened.py"
    file.write_text(OPENED.format(count=1))
    assert main(["--start", *places.split(), str(file)]) == 2
    assert capsys.readouterr().err.startswith(f"licence: {why}")


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ("initial_position: [0, 3.5, 0]", "cf7 is at 0, 3.5 m: the room is 6 by 6 m"),
        (
            "connection: none",
            "robots.cf7.connection = 'none': Crazyswarm2 reads connection only from robot_types",
        ),
    ],
)
def test_a_crazyflies_file_that_the_server_or_the_room_does_not_allow_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], entry: str, why: str
) -> None:
    file, vehicles = tmp_path / "opened.py", tmp_path / "crazyflies.yaml"
    file.write_text(OPENED.format(count=1))
    robot = f'{{enabled: true, uri: "radio://0/80/2M/E7E7E7E700", type: cf21, {entry}}}'
    vehicles.write_text(f"robots: {{cf7: {robot}}}\nrobot_types: {{cf21: {{}}}}\n")
    assert main(["--crazyflies", str(vehicles), str(file)]) == 2
    assert capsys.readouterr().err.startswith(f"licence: {why}")


def test_a_vehicle_that_is_opened_only_after_a_fault_fails_the_flight(tmp_path: Path):
    """Also where nothing is asked of the vehicle with the fault."""
    file = tmp_path / "two.py"
    file.write_text(OPENED.format(count=2))
    params = LicenceParams(((0.0, 0.0, 0.0),))
    order = FlightOrder(Program(file), params, LicenceTrial(TrialKind.UNARMED), (), (), 30.0)
    (flight,) = fly_trials([order], LicenceOptions(), until=inf)
    assert [one.what for one in flight.failures] == ["the program opens more vehicles than there are"]
