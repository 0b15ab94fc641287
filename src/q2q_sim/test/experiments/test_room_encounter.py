"""Encounters with full dynamics keep apart in the tube that is shipped."""

from dataclasses import replace

import numpy as np

from q2q_model.model_files.find_model import find_model
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import SetpointStatus, SwarmSetpoint
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.experiments.promise.room_encounter import (
    STEADY,
    PromiseCase,
    encounter_scenario,
    fly_room_encounter,
    starts_apart,
)
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import safe_replanner_params
from q2q_sim.scenarios import library
from q2q_sim.scenarios.room_profiles import IDEAL
from q2q_sim.scenarios.scenario import Scenario


def test_an_encounter_keeps_vehicles_apart_and_stays_in_its_first_tube() -> None:
    record = fly_room_encounter(0, PromiseCase())
    assert record.apart_at_start
    assert not record.entered
    assert 0.01 < record.horizontal < 0.3  # a vehicle is never exactly on its setpoint, nor lost
    assert 0.01 < record.vertical < 0.3
    assert record == fly_room_encounter(0, PromiseCase())


def test_shipped_scenarios_in_rooms_with_delays_or_dropouts_fly_with_the_same_tube() -> None:
    shipped = replace(STEADY, tracking=0.17, tracking_z=0.12, approach=2.0)
    flown = []
    for name in library.names():
        scenario = library.load(name)
        if scenario.vicon == IDEAL.vicon:
            continue
        for one in filter(None, (scenario, scenario.in_air)):
            assert safe_replanner_params(one) == shipped, name
            flown.append(name)
    assert len(flown) == 11


def test_the_tube_of_stack3_keeps_the_promise_that_is_broken_without_it() -> None:
    """Two come near within 12 s; at 5 cm, the first leaves its modified trajectory by more after 6.7 s."""
    scenario = replace(library.load("stack3"), duration=12.0)

    def broken(flown: Scenario) -> float:
        reported: list[bool] = []

        def hear(topic: str, _: int, signal: Signal) -> None:
            if topic == "reference_safe" and isinstance(signal, SwarmSetpoint):
                reported.append(bool((signal.status == SetpointStatus.PROMISE_BROKEN).any()))

        model = find_model(flown.model).interaction
        fly(flown, FlightOptions(replan="safe", model=model, on_signal=hear))
        return float(np.mean(reported))

    loop = {"pid": scenario.overrides["pid"]}
    assert broken(replace(scenario, overrides=loop)) > 0.01
    assert broken(scenario) == 0.0


def swap(apart: float) -> list[VehicleWaypoints]:
    return [
        VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(3, (0, 1, 1)))),
        VehicleWaypoints("cf2", (Waypoint(0, (apart, 0, 1)), Waypoint(3, (apart, 1, 1)))),
    ]


def test_paths_start_apart_where_zone_and_tubes_do() -> None:
    reach = STEADY.eps + 2.0 * STEADY.tracking
    assert not starts_apart(minimum_snap_plan(swap(reach + 0.01)), STEADY)
    assert starts_apart(minimum_snap_plan(swap(reach + 0.03)), STEADY)


def test_an_encounter_flies_the_delay_and_the_loss_that_it_names() -> None:
    scenario = encounter_scenario(minimum_snap_plan(swap(1.0)), 0.02, 0.07, PromiseCase())
    assert (scenario.radio.latency, scenario.radio.loss) == (0.02, 0.07)
    assert scenario.air == "room"
