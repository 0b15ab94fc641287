"""High-level commands of cflib reach the planner."""

import math

import numpy as np
import pytest

from cflib_fleet import CflibFleet
from q2q_sim.firmware.commander.planner import PlannerResult, PlanState


def test_cflibs_high_level_commands_reach_the_planner(grounded: CflibFleet) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    wire = grounded.wire()
    crazyflies = commander(wire)
    planner = grounded.firmware().planner
    crazyflies.takeoff(1.0, 2.0, yaw=None)
    assert planner.state == PlanState.FLYING
    assert wire.answers[-1] == wire.sent[-1][:4] + b"\0"
    assert planner.goal(grounded.firmware().seconds + 2.0).pos[2] == pytest.approx(1.0)
    crazyflies.go_to(1.0, 2.0, 3.0, 0.5, 4.0, relative=True, linear=False)
    end = planner.goal(grounded.firmware().seconds + 4.0)
    np.testing.assert_allclose(end.pos, [1.0, 2.0, 3.0], atol=1e-6)  # from the ground; 32-bit floats
    crazyflies.spiral(math.pi, 1.0, 1.0, 0.0, 3.0)
    assert planner.goal(grounded.firmware().seconds + 3.0).yaw == pytest.approx(0.5 + math.pi, abs=1e-6)
    crazyflies.land(0.0, 2.0)
    assert planner.state == PlanState.LANDING
    crazyflies.stop()
    assert planner.state == PlanState.IDLE


def test_a_group_mask_keeps_commands_from_vehicles_of_other_groups(grounded: CflibFleet) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    crazyflies = commander(grounded.wire())
    crazyflies.set_group_mask(0b0010)
    crazyflies.takeoff(1.0, 2.0, group_mask=0b0100)
    assert grounded.firmware().planner.state == PlanState.IDLE
    crazyflies.takeoff(1.0, 2.0, group_mask=0b0110)
    assert grounded.firmware().planner.state == PlanState.FLYING


def test_a_command_of_more_than_an_hour_is_taken(grounded: CflibFleet) -> None:
    commander = pytest.importorskip("cflib.crazyflie.high_level_commander").HighLevelCommander
    wire, firmware = grounded.wire(), grounded.firmware()
    commander(wire).takeoff(1.0, 7200.0)
    assert wire.answers[-1][-1] == PlannerResult.OK
    assert firmware.planner.goal(firmware.seconds + 3600.0).pos[2] == pytest.approx(0.5)
