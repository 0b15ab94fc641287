"""Whole flights by the procedure through the node `radio`, in simulated time.

Each of four accidents that hurt people is played: nothing moves, or the refusal names why.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from procedure_server import by_bridge, said_in_order
from procedure_vehicles import SHORT, SHORT_ENDS, TABLE6_ENDS, by_radio, fly_plan, land, refused

from q2q_control.flight_procedure.steps import Call, Step
from q2q_model.vehicle.hover_thrust import OwnHover
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.plan_playback.plan_player import Played
from q2q_sim.scenarios import library
from q2q_sim.scenarios.room_profiles import REAL
from q2q_sim.scenarios.scenario import Scenario


def test_table6_by_radio_from_the_ground_to_the_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch).room
    room.wait(1.5)
    fly_plan(room, *TABLE6_ENDS)
    assert room.height_error(50.0).max() < 0.08  # the paper's soft loop (K_p 0.81), aware: 27 mm direct
    land(room)


def test_a_plan_is_flown_by_radio_three_times_in_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch, SHORT).room
    room.wait(1.5)
    for _ in range(3):
        fly_plan(room, *SHORT_ENDS)
        assert room.height_error(3.0).max() < 0.08
        land(room)


def test_full_states_by_radio_from_the_ground_to_the_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch, SHORT, mode="setpoint").room
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted, room.node.lines[-5:]
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)
    assert room.call(Call.FLY).granted
    room.wait(3.0)
    assert room.height_error(3.0).max() < 0.005  # as by the bridge: the same packets
    land(room)


def seven_in_the_air_of_a_room() -> Scenario:
    """Return a scenario of seven vehicles side by side in the air `room`, with the gaps of a real room."""
    paths = tuple(
        VehicleWaypoints(f"cf{k}", (Waypoint(0.0, (0.0, y, 0.8)), Waypoint(3.0, (0.0, y, 1.0))))
        for k, y in enumerate(np.linspace(-1.8, 1.8, 7).tolist())
    )
    return replace(
        library.load("swarm7"),
        waypoints=paths,
        air="room",
        model="measured_law",
        vicon=REAL.vicon,
        imu=REAL.imu,
        overrides=REAL.overrides,
    )


def test_seven_vehicles_take_off_and_land_in_the_air_of_a_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are slow together for 0.14 s at most, and one of them is often not measured for over 0.1 s."""
    room = by_radio(monkeypatch, scenario=seven_in_the_air_of_a_room()).room
    room.wait(1.5)
    before = room.now()
    take_off = room.call(Call.TAKE_OFF)
    assert take_off.granted, take_off.reason
    assert room.now() - before < 4.5
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)
    land(room)


def test_a_parameter_that_a_vehicle_does_not_hold_refuses_the_take_off(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flown = by_radio(monkeypatch, SHORT, mode="setpoint")
    flown.room.wait(1.5)
    flown.links["cf2"].firmware.parameters.set("stabilizer.controller", 1)
    refusal = flown.room.call(Call.TAKE_OFF)
    assert "cf2: its stabilizer.controller is 1, expected 2" in refusal.reason
    flown.room.wait(1.0)
    assert flown.room.highest() < 0.01


def test_firmware_params_of_the_file_of_vehicles_are_set_and_reported(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """They were ignored in silence."""
    file = tmp_path / "crazyflies.yaml"
    file.write_text("""
all: {firmware_params: {ctrlMel: {kp_z: 2.5}, locSrv: {extPosStdDev: 0.002}}}
robot_types: {heavy: {firmware_params: {ctrlMel: {mass: 0.68}, hlCommander: {vtoff: 0.3}}}}
robots:
  cf1: {enabled: true, uri: "udp://127.0.0.1:19850"}
  cf2:
    {enabled: true, uri: "udp://127.0.0.1:19851", type: heavy, firmware_params: {hlCommander: {vland: 0.4}}}
""")
    given = {"vehicles": (), "uris": (), "crazyflies": str(file), "firmware_params": ("ctrlMel.kp_z=3.0",)}
    flown = by_radio(monkeypatch, SHORT, mode="setpoint", **given)
    flown.room.wait(1.5)
    names = ("ctrlMel.kp_z", "ctrlMel.mass", "hlCommander.vtoff", "hlCommander.vland", "locSrv.extPosStdDev")
    held = {
        name: [float(link.firmware.parameters[one]) for one in names] for name, link in flown.links.items()
    }
    np.testing.assert_allclose(held["cf2"], [3.0, 0.68, 0.3, 0.4, 0.002], rtol=1e-6)
    np.testing.assert_allclose(held["cf1"][2:], [0.5, 0.5, 0.002], rtol=1e-6)  # the firmware's own
    own = "hlCommander.vland=0.4, hlCommander.vtoff=0.3"
    every = "locSrv.extPosStdDev=0.002, locSrv.extQuatStdDev=0.05, stabilizer.controller=2"
    assert {
        f"firmware_params of cf1: ctrlMel.kp_z=3, {every}",
        f"firmware_params of cf2: ctrlMel.kp_z=3, ctrlMel.mass=0.68, {own}, {every}",
    } <= set(flown.room.node.lines)


def test_calls_at_the_wrong_time_move_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch, SHORT).room
    room.wait(1.5)
    refused(room, Step.CHECKED)
    room.wait(1.0)
    assert room.highest() < 0.01
    assert room.call(Call.TAKE_OFF).granted
    hovering = room.fleet.vehicles[0].firmware.rows.pos.copy()
    refused(room, Step.HOVER)
    room.wait(1.0)
    np.testing.assert_allclose(room.fleet.vehicles[0].firmware.rows.pos, hovering, atol=0.02)


def test_a_flight_that_is_held_is_flown_again_from_there(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch, SHORT).room
    room.wait(1.5)
    for call in (Call.TAKE_OFF, Call.FLY, Call.HOLD, Call.FLY, Call.LAND):
        assert room.call(call).granted, room.node.lines[-5:]


def test_a_start_in_the_middle_of_a_plan_is_refused_with_the_distance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The plan runs since 25 s: vehicles would jump from the ground to 1.5 and 2 m, one above the other."""
    room = by_radio(monkeypatch).room
    room.player.played = Played(room.plan, -25.0)
    room.wait(1.5)
    refusal = room.call(Call.START)
    assert not refusal.granted
    assert "cf1 is 1.50 m from its setpoint (maximum 0.30 m)" in refusal.reason
    room.wait(2.0)
    assert room.highest() < 0.01


def test_a_thrust_scale_of_another_vehicle_refuses_the_take_off(monkeypatch: pytest.MonkeyPatch) -> None:
    """An RPYT setpoint for the wrong vehicle asks for less than hovers: its own parameters show it."""
    flown = by_radio(monkeypatch)
    flown.room.wait(1.5)
    flown.links["cf2"].reported["own_hover"] = OwnHover(mass=0.034, mass_thrust=132000.0)
    refusal = flown.room.call(Call.TAKE_OFF)
    assert "cf2 would be sent 68 % of the thrust at which it hovers (allowed within 15 %)" in refusal.reason
    flown.room.wait(2.0)
    assert flown.room.highest() < 0.01


def test_a_plan_that_plays_by_itself_is_not_taken_over(monkeypatch: pytest.MonkeyPatch) -> None:
    room = by_radio(monkeypatch).room
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    room.player.played = Played(room.plan, -20.0)  # started late, by whoever
    room.tick()
    refusal = room.call(Call.FLY)
    assert not refusal.granted
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)


def test_a_plan_that_jumps_in_flight_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A trajectory that is started again plays its plan from the first point."""
    room = by_radio(monkeypatch).room
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    assert room.call(Call.FLY).granted
    room.wait(20.0)
    room.player.played = Played(room.plan, room.player.played.start + 20.0)
    room.wait(12.0)
    assert room.height[-1].max() < 0.02
    assert any("a setpoint jumped by" in line for line in room.node.lines)


def test_a_dry_run_by_radio_moves_nothing_and_says_what_would_be_sent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room = by_radio(monkeypatch, dry_run=True).room
    room.wait(1.5)
    reply = room.call(Call.TAKE_OFF)
    assert "arm, then take off to 0.50 m in 2.0 s" in reply.reason
    room.wait(3.0)
    assert room.highest() < 0.01


def test_nothing_climbs_before_take_off_is_called_and_nothing_is_streamed_before_fly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room, _ = by_bridge(monkeypatch, SHORT)
    room.wait(5.0)
    assert room.highest() < 0.01
    assert room.log == []
    assert room.call(Call.TAKE_OFF).granted
    assert said_in_order(room) == ["trajectory/wait_landed", "arm", "notify_setpoints_stop", "takeoff"]
    np.testing.assert_allclose(room.height[-1], 0.5, atol=0.15)
