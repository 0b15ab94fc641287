"""Numbers that packages without a common import repeat."""

import pytest

from q2q_control.attitude.command_delay import LATENCY_S
from q2q_control.mpc.neighbours.exchanged_paths import TRACKING
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_sim.scenarios.room_profiles import REAL


def test_controllers_expect_the_delays_of_camera_and_radio_in_the_real_room() -> None:
    assert pytest.approx(REAL.vicon.latency + REAL.radio.latency, abs=1e-9) == LATENCY_S  # whole nanoseconds


def test_distributed_controllers_expect_the_tracking_that_the_safe_replanner_assumes() -> None:
    assert SafeReplannerParams().tracking == TRACKING
