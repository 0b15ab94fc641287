"""Plan files and waypoint files are flown in place of a scenario, or refused by name."""

from pathlib import Path

import numpy as np
import pytest

from q2q_model.trajectory import plan_file
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1, on_firmware
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits, with_limits_of
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.plan_playback.plan_waypoints import waypoints_of
from q2q_planner.tools.waypoint_file import read_waypoints
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.commands.fly import main
from q2q_sim.loop import flight_blocks
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.scenarios import library
from q2q_sim.scenarios.choices import WAKES
from q2q_sim.scenarios.scenario_variants import with_choices, with_firmware

WAYPOINTS = """vehicles:
  cf1: [{t: 0, pos: [0, 0, 1]}, {t: 1.5, pos: [0.2, 0, 1], yaw: 0.3}, {t: 2, pos: [0.2, 0.1, 1.1]}]
  cf2: [{t: 0, pos: [1, 0, 1]}, {t: 1, pos: [1, 0, 1.2]}]
"""


@pytest.fixture
def waypoints(tmp_path: Path) -> Path:
    path = tmp_path / "points.yaml"
    path.write_text(WAYPOINTS)
    return path


@pytest.fixture
def plan(waypoints: Path) -> Path:
    """Return the plan through the waypoints, as `plan --no-avoid` writes it."""
    path = waypoints.with_name("mine.json")
    swarm = read_waypoints(waypoints, FlightLimits(), "stop_and_go")
    plan_file.save(path, minimum_snap_plan(swarm, "stop_and_go"))
    return path


def test_waypoints_and_the_plan_through_them_fly_the_same(waypoints: Path, plan: Path) -> None:
    by_points, by_plan = library.load(str(waypoints)), library.load(str(plan))
    assert by_points.duration == by_plan.duration == 2.0
    assert (by_plan.vehicle, by_plan.wake, by_plan.model) == (CRAZYFLIE_2_0, "none", "none")
    flown, again = (fly(one, FlightOptions()) for one in (by_points, by_plan))
    np.testing.assert_array_equal(again.ref_pos, flown.ref_pos)
    np.testing.assert_array_equal(again.true_pos, flown.true_pos)
    assert flown.ref_pos[-1, 0] == pytest.approx([0.2, 0.1, 1.1], abs=1e-3)


def test_the_points_of_a_plan_are_the_waypoints_it_was_made_of(waypoints: Path, plan: Path) -> None:
    given = read_waypoints(waypoints, FlightLimits(), "stop_and_go")
    for found, made_of in zip(waypoints_of(plan_file.load(plan)), given, strict=True):
        assert found.name == made_of.name
        np.testing.assert_allclose(found.times, made_of.times, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(found.points, made_of.points, rtol=0.0, atol=1e-9)


def test_a_plan_that_ends_on_the_ground_is_flown(tmp_path: Path) -> None:
    """Its polynomial ends 4e-15 m below."""
    points, path = tmp_path / "landing.yaml", tmp_path / "landing.json"
    points.write_text(
        "vehicles: {cf1: [{t: 0, pos: [0, 0, 0]}, {t: 3, pos: [0, 0, 1]}, {t: 6, pos: [1, 0, 0]}]}"
    )
    swarm = read_waypoints(points, FlightLimits(), "stop_and_go")
    plan_file.save(path, minimum_snap_plan(swarm, "stop_and_go"))
    (found,) = library.load(str(path)).waypoints
    assert -1e-12 < found.waypoints[-1].pos[2] < 0.0


def test_waypoints_without_times_get_those_that_plan_gives_them(tmp_path: Path) -> None:
    path = tmp_path / "untimed.yaml"
    path.write_text("vehicles: {cf1: [{pos: [0, 0, 1]}, {pos: [1, 0, 1]}, {pos: [1, 1, 2]}]}")
    limits = with_limits_of(FlightLimits(), CRAZYFLIE_2_0)  # as `plan` does
    (expected,) = read_waypoints(path, limits, "stop_and_go")
    (found,) = library.load(str(path)).waypoints
    assert found == expected
    assert library.load(str(path)).duration == expected.times[-1] > 0.0


def test_a_scenario_may_name_a_plan_beside_it_and_all_the_rest(plan: Path) -> None:
    path = plan.with_name("whole.yaml")
    path.write_text("plan: mine.json\nduration: 5.0\nvehicle: crazyflie_2_1\nwake: paper\nmodel: paper_law\n")
    found = library.load(str(path))
    assert (found.duration, found.vehicle, found.wake) == (5.0, CRAZYFLIE_2_1, "paper")
    np.testing.assert_array_equal(
        flight_blocks.plan_of(found).trajectories[0].coefficients,
        plan_file.load(plan).trajectories[0].coefficients,
    )


def test_vehicle_and_air_of_the_command_line_come_before_the_files(plan: Path) -> None:
    request = FlightRequest(str(plan), vehicle="crazyflie_2_1", wake="measured", model="measured_law")
    found = load_scenario(request)
    assert (found.vehicle, found.wake, found.model) == (CRAZYFLIE_2_1, "measured", "measured_law")
    upgraded = with_firmware(found, "thrust_upgrade")
    chosen = with_choices(upgraded, "crazyflie_2_0", "")
    assert chosen.vehicle == on_firmware(CRAZYFLIE_2_0, "thrust_upgrade")
    assert chosen.wake == "measured"
    assert set(WAKES) == {wake.name.lower() for wake in WakeLaw}


def test_choices_of_which_one_would_be_ignored_are_refused() -> None:
    with pytest.raises(ValueError, match="distributed with controller = 'pid': give controller = 'mpc'"):
        FlightRequest("table6", distributed=True)
    with pytest.raises(ValueError, match="record predictions: the flight is not distributed"):
        FlightRequest("table6", controller="mpc", record=("predictions",))
    with pytest.raises(ValueError, match="wake = 'paper' and air = 'room': give one of them"):
        FlightRequest("table6", wake="paper", air="room")


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("both.yaml", "plan: mine.json\n" + WAYPOINTS, "vehicles and plan are both given"),
        ("none.yaml", "plan: absent.json\n", "plan .*absent.json cannot be read"),
        ("number.yaml", "plan: 3\n", "plan = 3; must be the path of a plan file"),
        ("points.json", '{"vehicles": {}}', "points.json is not a plan: format and version"),
        ("points.csv", "t,x,y,z\n", "or a file: .yaml of a scenario or waypoints, .json of a plan"),
    ],
)
def test_what_cannot_be_flown_is_refused_with_what_can(
    plan: Path, name: str, text: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = plan.with_name(name)
    path.write_text(text)
    with pytest.raises(ValueError, match=says):
        load_scenario(FlightRequest(str(path)))
    if name == "points.csv":  # refused by its name alone, before anything starts
        assert main([str(path)]) == 1
        assert says in capsys.readouterr().err


def test_a_plan_is_not_planned_around_the_downwash_anew(plan: Path) -> None:
    with pytest.raises(ValueError, match=r"mine\.json is flown by its own plan: leave out --plan avoid"):
        load_scenario(FlightRequest(str(plan), plan="avoid"))
