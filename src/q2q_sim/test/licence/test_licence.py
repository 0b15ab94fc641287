"""Programs fly unmodified, and are judged: one sound, one that ends in the air."""

from dataclasses import replace
from math import inf
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from flown_programs import HOP, LAND, ONE, flown, hop, log_of, order_of, written

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from q2q_model.vehicle.setpoint_watchdog import CUT_AFTER_S
from q2q_sim.air.air_names import AirError
from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.licence_flights import Licence, licence
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.licence_reports import (
    junit_xml,
    licence_json,
    report_text,
    verdict_text,
    write_licence_page,
)
from q2q_sim.licence.room.trials import LicenceTrial, TrialKind
from q2q_sim.licence.rules.licence_limits import LicenceLimits
from q2q_sim.licence.trial_processes import fly_trials


def test_a_sound_program_lands_and_flies_the_same_again(tmp_path: Path) -> None:
    order = order_of(hop(tmp_path, LAND))
    flights = list(fly_trials([order, order], LicenceOptions(), until=inf))
    one, other = (log_of(flight) for flight in flights)
    assert [flight.findings for flight in flights] == [(), ()]
    assert one.end.t == pytest.approx(other.end.t, abs=1e-9)
    assert (one.pos == other.pos).all()
    assert 0.3 < one.pos[:, 0, 2].max() < 0.5  # asked for 0.4; it has not settled after 1.5 s
    assert one.pos[-1, 0, 2] <= 0.0


def test_a_setpoint_of_the_last_line_arms_a_vehicle_and_is_flown_until_it_is_too_old(tmp_path: Path) -> None:
    """The link stays open: nothing else is sent."""
    rise = """
import cflib.crtp
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
cflib.crtp.init_drivers()
scf = SyncCrazyflie("radio://0/80/2M/E7E7E7E7E7")
scf.open_link()
scf.cf.supervisor.send_arming_request(True)
scf.cf.commander.send_hover_setpoint(0.0, 0.0, 0.0, 0.5)
"""
    flight = flown(written(tmp_path, rise), params=replace(ONE, arming=True))
    log = log_of(flight)
    assert log.pos[:, 0, 2].max() == pytest.approx(0.5, abs=0.1)
    assert flight.findings[0].rule == "motors"
    assert flight.findings[0].t == pytest.approx(log.commands[-1].t + CUT_AFTER_S, abs=0.05)


def test_a_program_that_ends_in_the_air_fails_with_time_and_reason(tmp_path: Path) -> None:
    found = licence(hop(tmp_path, "pass"), LicenceOptions())
    assert not found.passed
    (flight,) = found.flights
    first = flight.findings[0]
    assert first.rule == "motors"
    assert first.what.startswith("the motors of cf1 stop at a height of 0.3")
    assert first.why.startswith("the closing of the link")
    assert first.sentence in report_text(found)
    case = ET.fromstring(junit_xml(found).encode()).find("testsuite/testcase")  # noqa: S314  our own
    assert case is not None
    failure = case.find("failure")
    assert (case.get("classname"), case.get("name")) == ("hop", "nominal")
    assert failure is not None
    assert failure.get("message") == first.sentence
    assert licence_json(found)["passed"] is False
    page = write_licence_page(found, tmp_path / "page").read_text(encoding="utf-8")
    assert "without faults. It failed, so it did not fly with faults." in page


def test_a_pass_says_if_no_vehicle_flew(tmp_path: Path) -> None:
    program = hop(tmp_path, LAND)
    one = flown(program)
    found = Licence(program, (one,), (), 1.0)
    assert verdict_text(found) == "PASS hop.py: 1 flight in 1 s"
    grounded = replace(one, log=replace(log_of(one), pos=np.zeros_like(log_of(one).pos)))
    found = replace(found, flights=(grounded,))
    assert (found.passed, licence_json(found)["flew"]) == (True, False)
    assert verdict_text(found) == "PASS hop.py: 1 flight in 1 s; no vehicle flew"
    page = write_licence_page(found, tmp_path / "page").read_text(encoding="utf-8")
    assert "with emulated vehicles, none of which left the floor." in page


def test_a_vehicle_that_does_not_arm_stays_on_the_floor(tmp_path: Path) -> None:
    uris = ("radio://0/80/2M/E7E7E7E7E7",)
    flight = flown(hop(tmp_path, LAND), trial=LicenceTrial(TrialKind.UNARMED), uris=uris)
    assert not log_of(flight).flew.any()
    assert flight.findings == ()
    takeoffs = [one.asked for one in log_of(flight).commands if one.asked.words.startswith("takeoff")]
    assert {one.refused for one in takeoffs} == {"the vehicle is not armed"}


def test_vehicles_are_armed_when_the_program_begins_and_take_less_thrust_than_their_weight_for_a_test(
    tmp_path: Path,
) -> None:
    """As in cflib's `ramp`, whose first setpoints come with the connection."""
    head = HOP.partition("    commander =")[0]
    for most, lifts in ((25000, False), (40000, False), (48000, True)):  # 44 027 carry 34 g
        each = f"    for each in (0, {most}, 0):\n        scf.cf.commander.send_setpoint(0, 0, 0, each)"
        flight = flown(written(tmp_path, f"{head}{each}; time.sleep(0.1)\n"), limit=9.0)
        (asked,) = (one.asked for one in log_of(flight).commands if one.asked.kind == CommandKind.SETPOINT)
        assert (asked.refused, asked.lifts) == ("", lifts)


def test_vehicles_without_starts_stand_in_as_few_rows_as_the_room_has_space_for() -> None:
    options = LicenceOptions(limits=LicenceLimits(half_room=(3.0, 3.0)))
    assert options.rows_of(3) == ((0.0, -1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    places = np.array(options.rows_of(15))[:, :2]
    assert (np.abs(places) <= 1.5).all()
    assert len(np.unique(places, axis=0)) == 15
    np.testing.assert_allclose(np.unique(places[:, 0]), [-1.5, -0.5, 0.5, 1.5])


def test_a_landing_in_an_exit_handler_is_flown(tmp_path: Path) -> None:
    land = f"import atexit\n    @atexit.register\n    def land(): {LAND}; scf.close_link()"
    program = hop(tmp_path, land)
    text = program.file.read_text().replace("with SyncCrazyflie", "scf = SyncCrazyflie")
    program.file.write_text(text.replace(" as scf:", "\nscf.open_link()\nif True:"))
    flight = flown(program)
    assert flight.findings == ()


def test_an_air_that_does_not_exist_is_refused_before_a_program_flies(tmp_path: Path) -> None:
    with pytest.raises(AirError, match="no_such_air"):
        licence(hop(tmp_path, LAND), LicenceOptions(air="no_such_air"))


def test_a_program_for_the_multi_ranger_deck_sees_the_walls_of_the_licences_room(tmp_path: Path) -> None:
    look = f"""
    from cflib.utils.multiranger import Multiranger
    with Multiranger(scf) as ranger:
        time.sleep(0.5)
        print(ranger.front, ranger.back, ranger.left, ranger.right, ranger.up > 1.8, ranger.down < 0.6)
    {LAND}"""
    limits = LicenceLimits(half_room=(1.5, 5.0), ceiling=2.5)
    options = LicenceOptions(starts=((0.5, 0.0, 0.0),), limits=limits)
    flight = flown(hop(tmp_path, look), params=options.params(1))
    assert flight.findings == ()
    front, back, left, right, up, down = log_of(flight).output.splitlines()[-1].split()
    assert [float(front), float(back)] == pytest.approx([1.0, 2.0], abs=0.02)  # it hovers not quite still
    assert (left, right, up, down) == ("None", "None", "True", "True")
