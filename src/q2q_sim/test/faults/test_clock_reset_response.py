"""A single step back of stamps sets no clock back; once they rise from there, all blocks follow it."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_setpoint

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.signals.repeated_stamp import StampOrder
from q2q_model.signals.values import MocapFrame, SwarmSetpoint
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.plan_playback.plan_player import PlanPlayer
from q2q_planner.plan_playback.transit import TransitParams
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios import library

NAMES = ("cf1",)
BEGIN = 16.0  # steps back from here are exact in float64


def frame(t: float) -> MocapFrame:
    return MocapFrame(t, NAMES, np.ones((1, 3)), identity_quat((1,)))


def setpoint(t: float) -> SwarmSetpoint:
    zero = np.zeros((1, 3))
    return resting_setpoint(t, NAMES, zero + 1.0)


def followed(stamps: list[float]) -> set[str]:
    """Return the blocks for which the time is the last of these stamps [s] after a tick at BEGIN and them."""
    mocap_filter = MocapFilter(MocapFilterParams(), NAMES)
    guard = Guard(Pid(PidParams(), CRAZYFLIE_2_0), FallbackParams(), CRAZYFLIE_2_0.hover_thrust)
    ways = Waypoint(0.0, (1.0, 1.0, 1.0)), Waypoint(9.0, (1.0, 1.0, 2.0))
    player = PlanPlayer(minimum_snap_plan([VehicleWaypoints("cf1", ways)]), -1.0, TransitParams(), wait=False)
    replanner = StampOrder()
    for t in (BEGIN, *stamps):
        state = mocap_filter.update(frame(t))
        guard.update(state, setpoint(t), None)
        player.update(frame(t))
        late = replanner.reject_stamp(t)
    assert player.played is not None
    follow = {
        "mocap filter": mocap_filter.report.clock_resets == 1,
        "guard": guard.newest == stamps[-1],
        "plan player": player.played.start == stamps[0],
        "replanner": not late,
    }
    return {name for name, one in follow.items() if one}


@pytest.mark.parametrize("back", [0.25, SET_BACK_S, SET_BACK_S + 0.25, 3.0, 1e9])
def test_one_old_stamp_sets_no_clock_back_however_old_it_is(back: float) -> None:
    assert followed([BEGIN - back]) == set()


@pytest.mark.parametrize("back", [SET_BACK_S + 0.25, 3.0, 15.0])
def test_all_blocks_follow_a_clock_that_is_set_back_with_the_same_tick(back: float) -> None:
    rising = [BEGIN - back + k / 128 for k in range(14)]
    assert followed(rising[:-1]) == set()
    assert followed(rising) == {"mocap filter", "guard", "plan player", "replanner"}


@pytest.mark.parametrize("size", [-100.0, 5.5, 100.0])
def test_a_tenth_of_a_second_of_frames_far_off_leaves_vehicles_on_their_paths(size: float) -> None:
    faults = (Fault("clock_jump", 5.0, 0.1, size=size),)
    flight = fly(replace(library.load("table6"), duration=6.0, faults=faults), FlightOptions())
    off = np.linalg.norm(flight.true_pos - flight.ref_pos, axis=2)
    assert off.max() < 0.02  # 5 mm at 0.07 m/s; the plan is 3.9 m away at these stamps
