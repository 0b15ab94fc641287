"""While a plan waits, the reference is where vehicles are seen; none in flight is left to drift by it."""

from dataclasses import replace

import numpy as np
import pytest
from played_room import ABOVE, GROUND, NAMES, PLAN, STEP, PlayedRoom, frame

from q2q_model.signals.values import Array, MocapFrame
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.plan_playback.plan_player import PlanPlayer
from q2q_planner.plan_playback.transit import TransitParams


def test_while_it_waits_the_reference_is_where_the_vehicles_are_seen() -> None:
    room = PlayedRoom()
    np.testing.assert_array_equal(room.tick().pos, GROUND)
    room.pos = ABOVE
    np.testing.assert_array_equal(room.tick(5.0).pos, room.pos)
    assert room.player.played is None


def test_a_vehicle_missing_from_a_frame_rests_where_it_was_last_seen() -> None:
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True)
    player.update(frame(0.0, GROUND))
    near = GROUND[:1] + 0.1
    alone = MocapFrame(0.1, PLAN.names[:1], near, np.array([[0.0, 0.0, 0.0, 1.0]]))
    np.testing.assert_array_equal(player.update(alone).pos, [*near, *GROUND[1:]])


def test_the_reference_follows_no_outlier_but_a_vehicle_that_is_put_elsewhere() -> None:
    room = PlayedRoom()
    room.tick(0.1)
    for outlier in (np.array([1.0, -1.0, 0.5]), np.array([-0.5, 1.5, 1.0])):
        room.pos = GROUND + np.array([outlier, np.zeros(3)])
        np.testing.assert_array_equal(room.tick().pos, GROUND)
    room.pos = GROUND
    np.testing.assert_array_equal(room.tick(5 * STEP).pos, GROUND)
    room.pos = ABOVE
    np.testing.assert_array_equal(room.tick().pos, GROUND)
    np.testing.assert_array_equal(room.tick().pos, ABOVE)


def partial(t: float, names: tuple[str, ...], pos: Array) -> MocapFrame:
    """Return a frame of some vehicles, level, at positions (len(names), 3)."""
    return MocapFrame(t, names, pos, np.tile([0.0, 0.0, 0.0, 1.0], (len(names), 1)))


OUTLIER = np.array([1.0, -1.0, 0.5])


def test_the_reference_follows_no_outlier_in_frames_with_another_object() -> None:
    player, names = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True), (*NAMES, "wand")
    places = np.array([*GROUND, [2.0, 2.0, 0.0]])
    for k in range(10):
        player.update(partial(STEP * k, names, places))
    wrong = places + np.array([OUTLIER, np.zeros(3), np.zeros(3)])
    np.testing.assert_array_equal(player.update(partial(0.1, names, wrong)).pos, GROUND)
    assert "has moved at 150.0 m/s" in player.transit().reason
    np.testing.assert_array_equal(player.update(partial(0.1 + STEP, names, places)).pos, GROUND)
    for k in range(2, 4):
        carried = player.update(partial(0.1 + STEP * k, names, wrong)).pos
    np.testing.assert_array_equal(carried, wrong[:2])


def test_the_reference_follows_no_outlier_next_to_a_vehicle_that_is_missing() -> None:
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True)
    for k in range(10):
        player.update(frame(STEP * k, GROUND))
    for t, off in ((0.1, 0.0), (0.1 + STEP, 1.0)):
        seen = player.update(partial(t, NAMES[:1], GROUND[:1] + off * OUTLIER))
        np.testing.assert_array_equal(seen.pos, GROUND)


def test_an_outlier_is_not_confirmed_by_frames_without_its_vehicle() -> None:
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True)
    for k in range(10):
        player.update(frame(STEP * k, GROUND))
    wrong = frame(0.1, GROUND + np.array([OUTLIER, np.zeros(3)]))
    np.testing.assert_array_equal(player.update(wrong).pos, GROUND)
    for k in range(1, 4):
        rest = player.update(partial(0.1 + STEP * k, NAMES[1:], GROUND[1:]))
        np.testing.assert_array_equal(rest.pos, GROUND)


def test_no_transit_begins_where_a_vehicle_was_measured_once_only() -> None:
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True)
    player.update(frame(0.0, GROUND + np.array([OUTLIER, np.zeros(3)])))
    assert "not been measured at rest in two frames" in player.transit().reason
    np.testing.assert_array_equal(player.update(frame(STEP, GROUND)).pos, GROUND)
    assert "not been measured at rest in two frames" in player.transit().reason
    np.testing.assert_array_equal(player.update(frame(2 * STEP, GROUND)).pos, GROUND)
    assert player.transit().granted


def test_frames_of_single_vehicles_one_shortly_after_the_other_show_no_outliers() -> None:
    """The motion since a vehicle's own last frame was divided by the 1 ms since the other vehicle's."""
    player, carried = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True), GROUND.copy()
    player.update(frame(-STEP, GROUND))
    for k in range(100):
        for row in range(2):
            carried[row, 0] += 0.2 * STEP  # at 0.2 m/s
            one = partial(STEP * k + 0.001 * row, NAMES[row : row + 1], carried[row : row + 1])
            np.testing.assert_array_equal(player.update(one).pos, carried)
    assert player.transit().granted


def test_the_vehicle_that_has_not_been_measured_twice_is_named() -> None:
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True)
    player.update(frame(0.0, GROUND))
    player.update(partial(STEP, NAMES[:1], GROUND[:1]))
    assert player.transit().reason == "cf2 has not been measured at rest in two frames yet: call again"


def test_an_outlier_after_a_gap_of_its_vehicle_is_not_followed() -> None:
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True)
    for k in range(10):
        player.update(frame(STEP * k, GROUND))
    for k in range(10, 500):
        player.update(partial(STEP * k, NAMES[1:], GROUND[1:]))
    wrong = frame(5.0, GROUND + np.array([OUTLIER, np.zeros(3)]))
    np.testing.assert_array_equal(player.update(wrong).pos, GROUND)
    np.testing.assert_array_equal(player.update(frame(5.0 + STEP, GROUND)).pos, GROUND)


def test_the_reference_follows_a_clock_that_is_set_back() -> None:
    room = PlayedRoom()
    room.tick(0.1)
    for k in range(20):
        last = room.player.update(frame(1.0 + STEP * k, ABOVE))
    np.testing.assert_array_equal(last.pos, ABOVE)


def test_a_vehicle_that_was_never_seen_has_no_reference_and_is_named() -> None:
    player = PlanPlayer(PLAN, -1.0, TransitParams(), wait=True)
    with pytest.raises(ValueError, match="cf2 not measured yet"):
        player.update(MocapFrame(0.0, ("cf1",), GROUND[:1], np.array([[0.0, 0.0, 0.0, 1.0]])))
    assert player.transit().reason == "no vehicle has been measured yet"


@pytest.mark.parametrize("held", [False, True])
def test_no_vehicle_in_flight_is_left_to_drift_by_a_wait(held: bool) -> None:
    """Both fly 3 cm below their references; the same without the wait is the truth."""
    rooms = PlayedRoom(ABOVE), PlayedRoom(ABOVE)
    for room in rooms:
        room.tick()
        assert room.player.transit().granted
        room.tick(1.0)
        if held:
            assert room.player.hold().granted
            room.tick(2.0)
        room.pos = room.setpoints[-1].pos - np.array([0.0, 0.0, 0.03])
        room.tick()
    refusal = rooms[0].player.wait()
    assert not refusal.granted
    assert refusal.reason == (
        "cf1 is 0.03 m from its reference and would drift in flight; "
        "hold or land it first, or call wait_landed if it stands there"
    )
    for _ in range(50):
        waited, flown = (room.tick() for room in rooms)
        np.testing.assert_array_equal(waited.pos, flown.pos)


def test_vehicles_that_have_landed_are_followed_again_by_a_wait_and_one_that_has_not_refuses_it() -> None:
    room = PlayedRoom(ABOVE)
    room.tick()
    assert room.player.transit().granted
    flying = room.tick(8.0).pos
    room.pos = np.array([GROUND[0], flying[1]])
    room.tick()
    assert "cf2 is 0.00 m from its reference" in room.player.wait().reason
    room.pos = GROUND
    room.tick()
    assert room.player.wait().granted
    np.testing.assert_array_equal(room.tick().pos, GROUND)


@pytest.mark.parametrize(("ground", "height"), [(0.0, 0.2), (0.2, 0.4)])
def test_vehicles_found_on_the_ground_are_followed_after_a_flight_however_low(
    ground: float, height: float
) -> None:
    """On the floor, and on a table 0.2 m high."""
    ways = Waypoint(0.0, (0.0, 0.0, height)), Waypoint(3.0, (0.5, 0.0, height))
    player = PlanPlayer(minimum_snap_plan([VehicleWaypoints("cf1", ways)]), -1.0, TransitParams(), wait=True)
    level = np.array([[0.0, 0.0, 0.0, 1.0]])
    flown = MocapFrame(0.0, ("cf1",), np.array([[0.0, 0.0, height]]), level)
    player.update(replace(flown, t=-STEP))
    landed = MocapFrame(9.0, ("cf1",), np.array([[0.0, 0.0, ground]]), level)
    player.update(flown)
    assert player.transit().granted
    player.update(landed)
    assert "wait_landed if it stands there" in player.wait().reason
    assert player.wait_landed().granted
    np.testing.assert_array_equal(player.update(landed).pos, landed.pos)
