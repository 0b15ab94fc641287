"""Programs for Crazyswarm2: vehicles are those of its file, and go where they are sent, in time."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_sim.licence.client_commands.client_command import CommandKind
from q2q_sim.licence.crazyflie_py.modules import CONNECT_S
from q2q_sim.licence.crazyflie_py.operator_input import PRESS_AFTER_S, PRESS_S
from q2q_sim.licence.crazyflie_py.served_vehicles import (
    STOCK_PARAMETERS,
    ServedVehicle,
    stock_vehicles,
    vehicles_from_file,
)
from q2q_sim.licence.flight_order import FlightOrder, Program
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.program_process.link_host import scanned_uris
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.room.licence_room import LicenceParams
from q2q_sim.licence.room.trials import GAP_S, LicenceTrial, TrialKind
from q2q_sim.licence.trial_processes import FlownTrial, fly_trials

HEAD = """
from crazyflie_py import Crazyswarm

swarm = Crazyswarm()
allcfs, timeHelper = swarm.allcfs, swarm.timeHelper
cf = allcfs.crazyflies[0]
"""


def fly(
    folder: Path, body: str, count: int = 1, trial: LicenceTrial | None = None, **order: object
) -> FlownTrial:
    """Fly a program of these lines with vehicles 1 m apart along y."""
    file = folder / "flight.py"
    file.write_text(HEAD + body)
    uris = scanned_uris(count)
    starts = tuple((0.0, float(row), 0.0) for row in range(count))
    plain = FlightOrder(
        Program(file, (), folder), LicenceParams(starts), trial or LicenceTrial(), uris, uris, 60.0
    )
    (one,) = fly_trials([replace(plain, **order)], LicenceOptions(), until=float("inf"))
    return one


def log_of(one: FlownTrial) -> LicenceLog:
    """Return the log of a flight whose program ended well."""
    assert one.log is not None
    assert one.log.end.error == ""
    return one.log


def at(log: LicenceLog, t: float) -> int:
    """Return the tick at a time [s]."""
    return int(np.searchsorted(log.t, t))


def test_a_trial_names_the_vehicles_as_the_server_does():
    trial = LicenceTrial(TrialKind.SWAP, 0, 3.0, 1, ("cf231", "cf5"))
    assert trial.words == "swapped markers of cf231 and cf5 at 3.0 s"


FILE = """
fileversion: 3
robots:
  cf7:
    {enabled: true, uri: radio://0/80/2M/E7E7E7E707, initial_position: [0.5, -0.5, 0.0], type: cf21,
     firmware_params: {stabilizer: {controller: 1}}}
  cf10: {enabled: true, uri: radio://0/80/2M/E7E7E7E710, initial_position: [0, 0.5, 0], type: quiet}
  cf9: {enabled: false, uri: radio://0/80/2M/E7E7E7E709, initial_position: [0, 0, 0], type: cf21}
robot_types:
  cf21: {firmware_logging: {default_topics: {status: {frequency: 5}}}}
  quiet: {firmware_logging: {enabled: false}}
all:
  firmware_logging: {enabled: true, default_topics: {pose: {frequency: 20}, status: {frequency: 1}}}
  firmware_params: {stabilizer: {controller: 2, estimator: 2}}
"""


def test_vehicles_are_those_of_the_file_with_their_parameters_and_logs(tmp_path: Path):
    file = tmp_path / "crazyflies.yaml"
    file.write_text(FILE)
    ten, seven = vehicles_from_file(file)
    assert (ten.name, ten.initial, ten.pose_hz, ten.status_hz) == ("cf10", (0.0, 0.5, 0.0), 0, 0)
    assert (seven.name, seven.start, seven.pose_hz, seven.status_hz) == ("cf7", (0.5, -0.5, 0.0), 20, 5)
    assert dict(seven.parameters) == {"stabilizer.controller": 1.0, "stabilizer.estimator": 2.0}
    assert dict(ten.parameters)["stabilizer.controller"] == 2.0


def test_an_initial_position_of_whole_numbers_is_one_of_ints_which_a_message_refuses(tmp_path: Path):
    file = tmp_path / "crazyflies.yaml"
    file.write_text(FILE.replace("[0.5, -0.5, 0.0]", "[1, -1, 0]"))
    ten, seven = vehicles_from_file(file)
    assert [type(one) for one in ten.initial] == [float] * 3  # [0, 0.5, 0]: ROS makes floats of both
    assert (seven.initial, [type(one) for one in seven.initial]) == ((1, -1, 0), [int] * 3)
    assert [type(one) for one in seven.start] == [float] * 3
    one = replace(seven, uri=scanned_uris(1)[0], initial=(0, 0, 0))
    (finding,) = fly(tmp_path, "cf.goTo(cf.initialPosition + [0, 0, 1], 0, 2.0)", served=(one,)).findings
    assert "goTo: goal[0] = np.int64(0) is of type int64: a ROS message needs a float" in finding.why


def test_stock_vehicles_are_named_by_their_addresses():
    (one,) = stock_vehicles(scanned_uris(1), [(0.1, 0.2, 0.3)])
    assert (one.name, one.initial, dict(one.parameters)) == ("cf231", (0.1, 0.2, 0.0), dict(STOCK_PARAMETERS))
    assert [two.name for two in stock_vehicles(scanned_uris(2), [(0.0, 0.0, 0.0)] * 2)] == ["cf1", "cf2"]


def test_a_go_to_ends_where_it_was_sent_and_the_time_is_the_room_s(tmp_path: Path):
    body = """
begin = timeHelper.time()
cf.takeoff(targetHeight=0.8, duration=2.0)
timeHelper.sleep(2.5)
cf.goTo([0.6, -0.4, 1.2], 1.0, 3.0)
timeHelper.sleep(5.5)
x, y, z = cf.get_position()
assert abs(x - 0.6) + abs(y + 0.4) + abs(z - 1.2) < 0.1, (x, y, z)
orientation = cf.get_pose()["orientation"]
assert abs(2.0 * orientation.z - 0.9589) < 0.1, orientation  # 2 sin(1 / 2)
cf.land(targetHeight=0.04, duration=2.0)
timeHelper.sleep(2.5)
assert abs(timeHelper.time() - begin - 10.5) < 0.01
status = cf.get_status()
assert status["pm_state"] == 0 and 4.0 < status["battery"] < 4.2, status
"""
    log = log_of(fly(tmp_path, body))
    assert log.end.t == pytest.approx(CONNECT_S + 10.5, abs=0.01)
    before = at(log, CONNECT_S + 8.0)
    assert log.pos[before, 0] == pytest.approx([0.6, -0.4, 1.2], abs=0.03)  # Mellinger in a room's air
    asked = [one.asked for one in log.commands if one.asked.words.startswith("go_to")]
    assert [one.pos for one in asked] == [pytest.approx((0.6, -0.4, 1.2))]
    assert log.names == ("cf231",)


@pytest.mark.parametrize("last", ["allcfs.takeoff(0.5, 2.0)", "cf.goTo([0.0, 0.0, 0.5], 0.0, 2.0)"])
def test_what_the_last_line_of_a_program_begins_is_flown(tmp_path: Path, last: str) -> None:
    """Its vehicle still stands when the program ends, and hovers 5 s later."""
    flight = fly(tmp_path, last)
    (found,) = flight.findings
    assert (found.rule, found.what) == ("end", "cf231 still flies 5 s after the end of the program")
    assert log_of(flight).pos[-1, 0, 2] == pytest.approx(0.5, abs=0.05)


def test_streamed_states_are_followed_and_outrank_a_go_to_until_they_stop(tmp_path: Path):
    body = """
for _ in range(300):
    cf.cmdFullState([0.0, 0.0, 0.5], [0.0] * 3, [0.0] * 3, 0.0, [0.0] * 3)
    timeHelper.sleepForRate(100)
cf.goTo([0.0, 0.0, 1.5], 0.0, 1.0)
timeHelper.sleep(0.1)
cf.notifySetpointsStop()
cf.land(targetHeight=0.04, duration=2.0)
timeHelper.sleep(2.5)
"""
    one = fly(tmp_path, body)
    log = log_of(one)
    assert one.findings == ()
    sent = [each.t for each in log.commands if each.asked.kind == CommandKind.SETPOINT]
    assert np.diff(sent) == pytest.approx(np.full(299, 0.01), abs=1e-3)
    assert log.pos[at(log, CONNECT_S + 3.0), 0, 2] == pytest.approx(0.5, abs=0.05)
    first, second = (each.asked.refused for each in log.commands if each.asked.kind == CommandKind.PLAN)
    assert first == "setpoints have priority until notify_setpoint_stop"
    assert second == ""


def test_a_mask_lifts_its_group_and_the_relative_go_to_of_all_moves_each_from_where_it_is(tmp_path: Path):
    body = """
one, other = allcfs.crazyflies
other.setGroupMask(4)
allcfs.takeoff(targetHeight=0.5, duration=1.5, groupMask=4)
timeHelper.sleep(2.0)
allcfs.takeoff(targetHeight=0.5, duration=1.5)
timeHelper.sleep(2.0)
allcfs.goTo([0.4, 0.0, 0.2], 0.0, 2.0)
timeHelper.sleep(3.0)
allcfs.land(targetHeight=0.04, duration=2.0)
timeHelper.sleep(2.5)
"""
    log = log_of(fly(tmp_path, body, count=2))
    up = log.pos[at(log, CONNECT_S + 2.0), :, 2]
    assert up[0] < 0.01
    assert up[1] == pytest.approx(0.5, abs=0.1)
    moved = log.pos[at(log, CONNECT_S + 7.0)]
    assert moved == pytest.approx(np.array([[0.4, 0.0, 0.7], [0.4, 1.0, 0.7]]), abs=0.06)


@pytest.mark.parametrize(("call", "lands"), [("cf.land", True), ("allcfs.land", False)])
def test_a_gap_delays_a_command_to_one_vehicle_and_swallows_a_broadcast(
    tmp_path: Path, call: str, *, lands: bool
):
    body = f"""
cf.takeoff(targetHeight=0.5, duration=1.5)
timeHelper.sleep(3.0)
{call}(targetHeight=0.04, duration=1.5)
timeHelper.sleep(3.0)
"""
    sent = CONNECT_S + 3.0
    trial = LicenceTrial(TrialKind.GAP, 0, sent - 0.1)
    log = log_of(fly(tmp_path, body, trial=trial))
    times = [one.t for one in log.commands if one.asked.words.startswith("land")]
    assert times == ([pytest.approx(sent - 0.1 + GAP_S, abs=0.011)] if lands else [])
    assert (log.pos[-1, 0, 2] < 0.05) == lands


def test_commands_at_the_end_of_a_gap_arrive_in_the_order_of_the_calls(tmp_path: Path):
    body = """
timeHelper.sleep(0.49)
cf.goTo([0.0, 0.0, 0.6], 0.0, 2.0)
allcfs.arm(True)
allcfs.takeoff(targetHeight=0.5, duration=2.0)
timeHelper.sleep(0.01)
allcfs.land(targetHeight=0.04, duration=2.0)
"""
    end = CONNECT_S + 0.5
    log = log_of(fly(tmp_path, body, trial=LicenceTrial(TrialKind.GAP, 0, end - GAP_S)))
    assert [one.asked.words.split()[0] for one in log.commands] == ["go_to", "arming", "takeoff", "land"]
    assert [one.t for one in log.commands] == pytest.approx([end] * 4, abs=1e-3)


def test_parameters_have_the_values_set_by_the_program_and_an_installed_package_is_not_used(tmp_path: Path):
    body = """
from math import isnan
assert isnan(cf.getParam("stabilizer.controller"))
cf.setParam("locSrv.extPosStdDev", 0.25)
assert cf.getParam("locSrv.extPosStdDev") == 0.25
cf.setParam("no.such", 1)
assert isnan(cf.getParam("no.such"))
for wrong in ("off", None, float("nan")):
    cf.setParam("ring.effect", wrong)
    allcfs.setParam("ring.effect", wrong)
assert isnan(cf.getParam("ring.effect"))
cf.setParam("ring.effect", "3")
assert cf.getParam("ring.effect") == 3
assert cf.initialPosition.tolist() == [0.0, 0.3, 0.0]
assert list(allcfs.crazyfliesByName) == ["cfa"] and list(allcfs.crazyfliesById) == [231]
allcfs.setParam("ring.effect", 7)
begin = timeHelper.time()
swarm.input.waitUntilButtonPressed()
waited = timeHelper.time() - begin
assert abs(waited - PRESS) < 0.05, waited
""".replace("PRESS", str(PRESS_AFTER_S + PRESS_S))
    (tmp_path / "crazyflie_py.py").write_text("raise ImportError('rclpy is needed')")  # one that is installed
    (uri,) = scanned_uris(1)
    served = ServedVehicle("cfa", uri, (0.0, 0.3, 0.0))
    log = log_of(fly(tmp_path, body, served=(served,)))
    assert log.names == ("cfa",)
    assert "no.such = 1 is not set: KeyError('no.such')" in log.output
    assert "getParam: no.such is not a parameter of the emulated firmware" in log.output
    assert "getParam: ring.effect is not set yet: server.yaml has" in log.output
    assert "ring.effect = 'off' is not set: ValueError" in log.output


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("import rclpy", "ImportError: a licence has no rclpy: programs command by cflib or crazyflie_py"),
        (
            "cf.cmdVelocityWorld([0.0] * 3, 0.0)",
            "Crazyflie has no cmdVelocityWorld: it exists in Crazyswarm1 only",
        ),
        ("allcfs.create_timer(1.0, print)", "CrazyflieServer of a licence has no create_timer"),
        ("import crazyflie_py.joystick as j; j.Joystick()", "a licence has no such hardware"),
        ("Crazyswarm()", "Crazyswarm() can be called once"),
    ],
)
def test_what_is_not_stood_in_for_says_so_in_a_sentence(tmp_path: Path, line: str, sentence: str):
    (finding,) = fly(tmp_path, line).findings
    assert finding.rule == "program"
    assert sentence in finding.why
    assert "\n" not in finding.why


def test_a_vehicle_that_is_not_in_the_file_is_refused(tmp_path: Path):
    served = ServedVehicle("cfa", "radio://0/80/2M/E7E7E7E701", (0.0, 0.0, 0.0))
    body = """
import cflib.crtp
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
cflib.crtp.init_drivers()
SyncCrazyflie("radio://0/80/2M/E7E7E7E702").open_link()
"""
    pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")
    found = fly(tmp_path, body, served=(served,), uris=(served.uri,)).findings
    assert "E702 is not the URI of an enabled vehicle" in found[0].why
