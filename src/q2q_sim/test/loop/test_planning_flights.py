"""Section 4.1 flown in the paper's wake: planning around what was learned, and replanning, avoid it.

The model is learned from the recorded flights of Table 2 alone; the wake flown in is the simulator's own.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.pid.pid_params import PidParams
from q2q_model.flights.flight import Flight
from q2q_model.geometry.zone import Cylinder
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import ModelFile
from q2q_model.recordings.recordings_of_bags import recordings_of_bags
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_planner.offline.minimum_snap.minimum_snap import plan_cost
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_sim.loop import flight_blocks
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.metrics.flight_metrics import measure
from q2q_sim.scenarios import library

BAGS = Path(__file__).parents[4] / "bags"
SCENARIO = library.load("section4_1")


def height_errors(flight: Flight) -> Array:
    """Return the z RMSE of each vehicle against what was planned before the flight [m], (n,)."""
    return np.array([one.z_rmse_m for one in measure(flight, SCENARIO.vehicle).vehicles.values()])


@pytest.fixture(scope="module")
def original() -> Flight:
    return fly(SCENARIO, FlightOptions(mode="ignoring"))


@pytest.fixture(scope="module")
def learned() -> ModelFile:
    recordings, _ = recordings_of_bags(sorted(BAGS.glob("table2_*")))
    return identify(recordings, ProcedureParams(model_type="jet"), lambda _: None).file


def test_planning_around_the_learned_downwash_spares_both_85_percent(
    original: Flight, learned: ModelFile
) -> None:
    plan = flight_blocks.plan_around(SCENARIO, learned)
    assert plan.certified
    assert plan_cost(plan) <= 1.3 * plan_cost(flight_blocks.plan_of(SCENARIO))
    flown = fly(SCENARIO, FlightOptions(mode="ignoring", plan=plan))
    assert (height_errors(flown) <= 0.15 * height_errors(original)).all()


def test_the_safe_replanner_spares_both_95_percent_and_never_enters_the_zone(original: Flight) -> None:
    flown = fly(SCENARIO, FlightOptions(mode="ignoring", replan="safe"))
    assert (height_errors(flown) <= 0.05 * height_errors(original)).all()
    params = SafeReplannerParams()
    zone = Cylinder(params.eps, params.d)
    assert measure(flown, SCENARIO.vehicle, zone).zone_time_s == 0.0
    assert measure(original, SCENARIO.vehicle, zone).zone_time_s > 10.0
    moved = flown.safe_pos - flown.ref_pos
    assert np.hypot(moved[..., 0], moved[..., 1]).max() < params.eps
    assert np.abs(moved[..., 2]).max() < 2e-3  # a push goes aside: heights stay
    assert not moved[-1].any()


def test_a_model_without_downwash_is_planned_around_by_its_zone() -> None:
    none = find_model("none")
    plan = flight_blocks.plan_around(SCENARIO, none)
    assert plan_cost(plan) == plan_cost(flight_blocks.plan_of(SCENARIO, none.zone))


@pytest.mark.parametrize("controller", [PidParams(), MpcParams()])
def test_replanned_setpoints_leave_two_fifths_of_the_tilt_to_the_feedback(
    controller: PidParams | MpcParams,
) -> None:
    """Search 345: around a zone with 3 m/s^2 of 3.6, the tilt saturated for 0.8 s, and the PID overshot."""
    assert SafeReplannerParams().acc_max <= 0.6 * GRAVITY * math.tan(controller.tilt_max)
