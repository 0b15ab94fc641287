"""A run is its seed: scenario, room, vehicles, controller and faults are drawn by it."""

import pytest

from q2q_sim.campaigns.random_runs import random_run
from q2q_sim.campaigns.random_runs.random_run import CALM_S, EXCERPTS, draw_run, excerpt_document
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_document import scenario_from_document


def test_a_run_in_an_air_is_flown_by_the_vehicles_of_that_air() -> None:
    seed = next(seed for seed in range(100) if draw_run(seed).document["vehicle"] == "textbook_065")
    own, run = draw_run(seed), draw_run(seed, "bent")
    assert (run.scenario.vehicle.name, run.scenario.air) == ("crazyflie_2_0", "bent")
    assert run.document["vehicles"] == own.document["vehicles"]
    assert run.document["overrides"] != own.document["overrides"]  # the bound on thrust is the vehicle's


def test_a_run_is_its_seed_and_seeds_draw_everything() -> None:
    assert draw_run(7) == draw_run(7)
    runs = [draw_run(seed) for seed in range(60)]
    assert len({str(run.document["description"]) for run in runs}) == len(EXCERPTS)
    assert {run.options.controller for run in runs} == {"pid", "mpc"}
    assert {str(run.document["room"]) for run in runs} == set(random_run.ROOMS)
    for run in runs:
        scenario = run.scenario
        assert 1 <= len(scenario.faults) <= random_run.MOST_FAULTS
        assert all(fault.start <= scenario.duration - CALM_S for fault in scenario.faults)


@pytest.mark.parametrize("excerpt", EXCERPTS, ids=lambda excerpt: excerpt.scenario)
def test_an_excerpt_begins_and_ends_where_its_scenario_is_then(excerpt: random_run.Excerpt) -> None:
    whole = library.load(excerpt.scenario)
    document = excerpt_document(library.document(excerpt.scenario), excerpt)
    short = scenario_from_document("excerpt", document)
    assert short.duration == pytest.approx((excerpt.end - excerpt.begin) * excerpt.pace)
    for long_way, way in zip(whole.waypoints, short.waypoints, strict=True):
        at_rest = [point.pos for point in long_way.waypoints if point.t <= excerpt.begin][-1]
        assert way.waypoints[0].pos == at_rest
        assert way.waypoints[0].t == 0.0
        assert all(a.t < b.t for a, b in zip(way.waypoints, way.waypoints[1:], strict=False))
