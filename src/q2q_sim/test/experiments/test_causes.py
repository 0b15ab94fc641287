"""Causes of a loss: which are present, and what is left without them."""

from dataclasses import replace

import numpy as np
from explained_flights import short

from q2q_sim.experiments.explanation.causes import CAUSES, FAULTS, present_causes, without_causes
from q2q_sim.experiments.explanation.flight_setup import flight_setup, fly_setup
from q2q_sim.faults.faults import KINDS
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.scenarios import library


def test_every_fault_belongs_to_one_cause() -> None:
    kinds = [kind for some in FAULTS.values() for kind in some]
    assert sorted(kinds) == sorted(KINDS)
    assert set(FAULTS) <= set(CAUSES)


def test_without_all_causes_none_is_left() -> None:
    for setup in (short("table6_room"), short("stack3", "room"), short("table6_room", "ring")):
        assert present_causes(without_causes(setup, CAUSES)) == ()


def test_an_ideal_room_without_a_wake_has_causes_in_its_vehicles_only() -> None:
    still = replace(library.load("table6"), wake="none", duration=0.5)
    assert present_causes(flight_setup(still, BlockChoices("ignoring"), 0)) == (
        "battery and saturation",
        "control",
    )


def test_a_cause_is_taken_out_and_the_others_stay() -> None:
    setup = short("stack3", "room")
    assert present_causes(setup) == tuple(CAUSES)
    for cause in CAUSES:
        assert present_causes(without_causes(setup, {cause})) == tuple(one for one in CAUSES if one != cause)


def test_gusts_of_the_scenario_are_no_cause_in_an_air_that_replaces_them() -> None:
    for air in ("ring", "measured"):
        windless = short("stack3", air)
        gusts = replace(windless.scenario.disturbance, air_std=2.0)
        assert "wind" not in present_causes(
            replace(windless, scenario=replace(windless.scenario, disturbance=gusts))
        )


def test_no_vehicle_feels_downwash_once_it_is_taken_out() -> None:
    for setup in (short("stack3"), short("stack3", "ring")):
        flown, still = fly_setup(setup), fly_setup(without_causes(setup, {"downwash", "wind"}))
        assert np.isfinite(flown.true_eta).all()
        assert np.abs(still.true_eta).max() == 0.0
