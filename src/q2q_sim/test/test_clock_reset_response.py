"""Which blocks follow a single step back of their stamps at once, as that of another flight."""

import numpy as np
import pytest

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.mpc.prediction.neighbours import HeardPredictions, PredictedPaths
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.signals.values import MocapFrame, SwarmSetpoint
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.online.replanner import LONGEST_GAP
from q2q_planner.online.tick_clock import TickClock
from q2q_planner.plan_playback.glide import GlideParams
from q2q_planner.plan_playback.plan_player import PlanPlayer

NAMES = ("cf1",)
BEGIN = 16.0  # steps back from here are exact in float64
EVERYONE = {"mocap filter", "guard", "plan player", "predictions"}


def frame(t: float) -> MocapFrame:
    return MocapFrame(t, NAMES, np.ones((1, 3)), identity_quat((1,)))


def setpoint(t: float) -> SwarmSetpoint:
    zero = np.zeros((1, 3))
    return SwarmSetpoint(t, NAMES, zero + 1.0, zero, zero, np.zeros(1), np.zeros(1), np.zeros(1, np.uint8))


def followed_at_once(to: float) -> set[str]:
    """Return the blocks for which the time is `to` [s] after ticks at BEGIN and then."""
    mocap_filter = MocapFilter(MocapFilterParams(), NAMES)
    guard = Guard(Pid(PidParams(), CRAZYFLIE_2_0), FallbackParams(), CRAZYFLIE_2_0.hover_thrust)
    ways = Waypoint(0.0, (1.0, 1.0, 1.0)), Waypoint(9.0, (1.0, 1.0, 2.0))
    player = PlanPlayer(minimum_snap_plan([VehicleWaypoints("cf1", ways)]), -1.0, GlideParams(), wait=False)
    predictions, replanner = HeardPredictions(0.1), TickClock()
    for t in (BEGIN, to):
        state = mocap_filter.update(frame(t))
        guard.update(state, setpoint(t), None)
        player.update(frame(t))
        predictions.hear(PredictedPaths(t, NAMES, t, 0.1, np.zeros((1, 2, 3), np.float32)))
        late = replanner.is_late(t)
    assert player.played is not None
    follow = {
        "mocap filter": mocap_filter.report.clock_resets == 1,
        "guard": guard.newest == to,
        "plan player": player.played.start == to,
        "predictions": not predictions.has("cf1", BEGIN),
        "replanner": not late,
    }
    return {name for name, one in follow.items() if one}


@pytest.mark.parametrize("back", [0.25, SET_BACK_S])
def test_a_frame_that_is_late_by_up_to_a_second_sets_no_clock_back(back: float) -> None:
    assert followed_at_once(BEGIN - back) == set()


@pytest.mark.parametrize("back", [SET_BACK_S + 0.25, 3.0, LONGEST_GAP])
def test_beyond_all_are_set_back_but_the_replanner_whose_motions_would_leap(back: float) -> None:
    assert followed_at_once(BEGIN - back) == EVERYONE


def test_beyond_the_longest_gap_of_a_motion_the_replanner_is_too() -> None:
    assert followed_at_once(BEGIN - LONGEST_GAP - 0.25) == EVERYONE | {"replanner"}
