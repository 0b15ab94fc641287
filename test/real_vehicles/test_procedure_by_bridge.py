"""Whole flights by the procedure through the node `crazyswarm`, in simulated time."""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/radio.txt has it")
pytest.importorskip("q2q_msgs", reason="the workspace is not built")
from procedure_room import ProcedureRoom
from procedure_server import Server, by_bridge, said_in_order
from procedure_vehicles import NAMES, SHORT, SHORT_ENDS, TABLE6_ENDS, fly_plan, land
from room_node import Client, Future

from q2q_control.flight_procedure.steps import Call
from q2q_model.signals.stamps import TICK_S
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

SERVERS_ORDER = [
    "trajectory/wait_landed", "arm", "notify_setpoints_stop", "takeoff",
    "trajectory/transit", "cmd_full_state", "trajectory/start", "cmd_full_state",
    "trajectory/transit", "cmd_full_state", "notify_setpoints_stop", "land", "arm",
]  # fmt: skip


def test_table6_by_the_bridge_flies_lands_and_disarms_in_the_servers_order(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room, _ = by_bridge(monkeypatch)
    room.wait(1.5)
    fly_plan(room, *TABLE6_ENDS)
    assert room.height_error(50.0).max() < 0.005
    land(room)
    assert said_in_order(room) == SERVERS_ORDER


def test_a_plan_is_flown_by_the_bridge_three_times_in_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    room, _ = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    for _ in range(3):
        fly_plan(room, *SHORT_ENDS)
        assert room.height_error(3.0).max() < 0.005
        land(room)
        assert said_in_order(room) == SERVERS_ORDER


def test_the_bridge_flies_with_poses_of_the_second_version(monkeypatch: pytest.MonkeyPatch) -> None:
    room, _ = by_bridge(monkeypatch, SHORT, version=2)
    room.wait(1.5)
    for call in (Call.TAKE_OFF, Call.FLY):
        assert room.call(call).granted, room.node.lines[-5:]
    room.wait(4.0)
    land(room)
    assert said_in_order(room) == SERVERS_ORDER


@pytest.mark.parametrize("absent", ["cf2/takeoff", "cf2/notify_setpoints_stop", "cf2/land", "all/emergency"])
def test_no_flight_begins_while_the_server_lacks_a_service_of_it(
    monkeypatch: pytest.MonkeyPatch, absent: str
) -> None:
    """A take-off was granted whose landing no service could begin."""
    room, _ = by_bridge(monkeypatch, SHORT, absent=absent)
    room.wait(1.5)
    why = f"{absent} not available: start Crazyswarm2's server, or update it"
    assert room.call(Call.TAKE_OFF).reason == why
    assert said_in_order(room) == []


def test_a_vehicle_that_the_server_does_not_have_is_offline(monkeypatch: pytest.MonkeyPatch) -> None:
    room, _ = by_bridge(monkeypatch, SHORT, absent="cf2/arm")
    room.wait(1.5)
    (refusal, _) = room.node.published["procedure/status"][-1].values
    assert refusal.value == "cf2 offline: check URI, battery and radio"


def test_vehicles_of_the_server_that_the_bridge_does_not_fly_stay_on_the_floor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """They took off unchecked."""
    waypoints = (Waypoint(0.0, (0.0, 0.0, 0.8)), Waypoint(3.0, (0.0, 0.0, 1.0)))
    room, _ = by_bridge(
        monkeypatch, minimum_snap_plan([VehicleWaypoints("cf1", waypoints)]), vehicles=("cf1",)
    )
    room.wait(1.5)
    assert all(room.call(call).granted for call in (Call.TAKE_OFF, Call.FLY))
    room.wait(1.0)
    land(room)
    highest = np.max(room.height, axis=0)
    assert highest[0] > 0.8
    assert highest[1] < 0.001


def test_a_landing_that_does_not_happen_is_not_a_success(monkeypatch: pytest.MonkeyPatch) -> None:
    """A server that is deaf to `land`: it answers, and the vehicles stay up."""
    room, server = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    server.ignore_signals.add("land")
    reply = room.call(Call.LAND)
    assert not reply.granted
    assert "not on the ground: cf1 is at 0.5" in reply.reason
    server.ignore_signals.clear()
    assert room.call(Call.LAND).granted


def test_a_battery_that_the_server_does_not_log_refuses_the_take_off(monkeypatch: pytest.MonkeyPatch) -> None:
    room, server = by_bridge(monkeypatch)
    server.reports.remove("status")
    room.wait(1.5)
    assert "cf1 does not report its battery" in room.call(Call.TAKE_OFF).reason


REFUSED_BY_WHAT_THE_SERVER_REPORTS = [
    ({"offset": 0.3}, "cf1 estimates itself 0.30 m from its measured position (maximum 0.10 m)"),
    (
        {"held": {"ctrlMel.mass": 0.034, "ctrlMel.massThrust": 132000.0}},
        "cf1 would be sent 68 % of the thrust",
    ),
    ({"held": {"stabilizer.controller": 1.0}}, "cf1: its stabilizer.controller is 1, expected 2"),
]


@pytest.mark.parametrize(("reported", "why"), REFUSED_BY_WHAT_THE_SERVER_REPORTS)
def test_the_bridge_refuses_the_take_off_by_what_the_server_reports(
    monkeypatch: pytest.MonkeyPatch, reported: dict[str, object], why: str
) -> None:
    room, server = by_bridge(monkeypatch, SHORT)
    for name, value in reported.items():
        setattr(server, name, value)
    room.wait(1.5)
    assert why in room.call(Call.TAKE_OFF).reason
    assert not {"arm", "takeoff"} & set(room.log)


def test_an_estimate_that_is_no_longer_reported_refuses_the_take_off(monkeypatch: pytest.MonkeyPatch) -> None:
    room, server = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    server.reports.remove("onboard")
    room.wait(3.1)
    assert "cf1 stopped sending its own estimate x, y, z" in room.call(Call.TAKE_OFF).reason


def test_what_the_server_does_not_report_is_said_not_to_be_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    room, server = by_bridge(monkeypatch, SHORT)
    server.reports = {"status"}
    room.wait(1.5)
    words = "not checked: parameters of cf1, cf2; own estimate of cf1, cf2; thrust scale of cf1, cf2"
    assert room.node.lines[-1] == f"step checked: {words}"
    values = {one.key: one.value for one in room.node.published["procedure/status"][-1].values}
    assert values == {"take_off_refusal": "", "unchecked": words}
    assert room.call(Call.TAKE_OFF).granted
    assert f"step arming: {words}" in room.node.lines


def test_an_emergency_by_the_bridge_stops_the_motors(monkeypatch: pytest.MonkeyPatch) -> None:
    room, _ = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    assert room.call(Call.EMERGENCY).granted
    room.wait(1.0)
    assert room.height[-1].max() < 0.02
    assert "the step is stopped" in room.call(Call.TAKE_OFF).reason


def test_a_dry_run_by_the_bridge_calls_the_server_for_an_emergency_only(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room, server = by_bridge(monkeypatch, SHORT, dry_run=True)
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).reason.startswith("dry run, not executed; ")
    room.wait(1.0)
    assert room.log == []
    for name in NAMES:
        server.services()[f"{name}/arm"](SimpleNamespace(arm=True))
    room.wait(1.5)
    server.take_off(0.5, 1.0)
    room.wait(1.5)
    assert room.height[-1].min() > 0.4
    assert room.call(Call.EMERGENCY).granted
    assert room.log == ["arm", "arm", "emergency"]
    room.wait(1.0)
    assert room.height[-1].max() < 0.02


GENTLE = 0.8
"""Sink rate of no fall [m/s]: a landing's peaks at 2.19 times its mean of 1 m in 3 s, a fall's at 4."""


def fastest_sink(room: ProcedureRoom) -> float:
    """Return the fastest sink rate of the last 5 s [m/s]."""
    return float(-np.diff(room.height[-500:], axis=0).min() / TICK_S)


def ended(room: ProcedureRoom, server: Server) -> float:
    """End the node, and let the room's time pass while it lands; return how long it would at most [s]."""
    assert server.bridge is not None
    seconds = server.bridge.land()
    latest = room.now() + seconds
    while server.bridge.land() > 0.0 and room.now() < latest:
        room.tick()
    return seconds


def test_vehicles_land_before_they_fall_where_no_downwash_comes_any_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Setpoints came, none was sent: the firmware cut the motors after 2 s."""
    room, _ = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    assert all(room.call(call).granted for call in (Call.TAKE_OFF, Call.FLY))
    said_in_order(room)
    room.speaks.remove("interference")
    room.wait(8.0)
    assert any("step landing: nothing sent to cf1 for 1.0" in line for line in room.node.lines)
    assert said_in_order(room) == ["notify_setpoints_stop", "land", "arm"]
    assert room.height[-1].max() < 0.02
    assert fastest_sink(room) < GENTLE


HOVER, FLIGHT = (Call.TAKE_OFF,), (Call.TAKE_OFF, Call.FLY)
LONGEST_S = 3.0 + 5.0
"""Wait for a landing: landing_duration_min and step_timeout_s [s]."""


@pytest.mark.parametrize("calls", [HOVER, FLIGHT], ids=["hover", "flight"])
def test_a_bridge_that_is_ended_in_flight_lands_vehicles_where_they_are(
    monkeypatch: pytest.MonkeyPatch, calls: tuple[Call, ...]
) -> None:
    """They fell 2 s after the last setpoint."""
    room, server = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    assert all(room.call(call).granted for call in calls)
    room.wait(1.0)
    said_in_order(room)
    assert ended(room, server) == LONGEST_S
    assert said_in_order(room) == ["notify_setpoints_stop", "land", "arm"]
    assert room.height[-1].max() < 0.02
    assert fastest_sink(room) < GENTLE
    assert ended(room, server) == 0.0  # on the ground nothing is sent
    assert said_in_order(room) == []


def test_a_bridge_that_is_ended_without_motion_capture_waits_as_long_as_a_landing_takes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room, server = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    said_in_order(room)
    room.speaks.clear()
    before = room.now()
    ended(room, server)
    assert room.now() - before == pytest.approx(LONGEST_S, abs=1.5 * TICK_S)
    assert said_in_order(room) == ["notify_setpoints_stop", "land"]  # disarmed: only if seen at rest
    assert room.height[-1].max() < 0.02


@pytest.mark.parametrize(("missing", "waits"), [("service_is_ready", 0.05), ("done", 5.1)])
def test_a_bridge_that_is_ended_does_not_wait_for_a_server_that_is_gone(
    monkeypatch: pytest.MonkeyPatch, missing: str, waits: float
) -> None:
    room, server = by_bridge(monkeypatch, SHORT)
    room.wait(1.5)
    assert room.call(Call.TAKE_OFF).granted
    said_in_order(room)
    monkeypatch.setattr(Client if missing == "service_is_ready" else Future, missing, lambda _: False)
    before = room.now()
    ended(room, server)
    assert room.now() - before < waits
    assert any("stop streaming failed" in line for line in room.node.lines)


def test_a_plan_0_2_m_above_the_floor_is_flown_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """The landed vehicles are as near to the last references as in flight."""
    low = minimum_snap_plan(
        [
            VehicleWaypoints(name, (Waypoint(0.0, (0.0, y, 0.2)), Waypoint(3.0, (0.2, y, 0.2))))
            for name, y in (("cf1", 0.0), ("cf2", 2.0))
        ]
    )
    room, _ = by_bridge(monkeypatch, low)
    room.wait(1.5)
    for _ in range(2):
        fly_plan(room, 3.0, [0.2, 0.2])
        land(room)
