"""The verdict on a flight names what went wrong, where and when, and nothing that went as it was sent."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from judged_hover import AROUND, HOVER, T, flown, moved, output

from q2q_model.model_files.find_model import find_model
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.flight_outcomes import IN_FLIGHT
from q2q_sim.monitors.flight_verdict import FlightVerdict, verdict_line
from q2q_sim.monitors.policies import Circumstances, judge
from q2q_sim.monitors.policies.inputs.trace_from_arrays import trace_from_arrays
from q2q_sim.scenarios.scenario_document import scenario_from_document


def test_a_flight_that_goes_as_it_is_sent_is_ok() -> None:
    assert output(flown()) == "ok: 10.0 s flown to the end"


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ((0.0, 1.0, 0.0), "cf2 hit the floor at 5.6 s"),
        ((0.0, 0.1, 1.0), "cf1 and cf2 collided at 5.6 s, down to 0.10 m apart"),
        ((0.0, 2.7, 1.0), "cf2 left its path at 5.6 s, up to 1.70 m from its setpoint"),
    ],
)
def test_what_goes_wrong_is_named_with_who_and_when(where: tuple[float, float, float], words: str) -> None:
    assert output(flown(moved(5.6, 5.8, 1, where))) == words


def test_a_fall_that_no_command_prevents_is_a_failure_when_it_happens() -> None:
    """The policies exempt it until 3.5 s after the push: a vehicle that lies there then has fallen before."""
    push = np.zeros_like(HOVER)
    push[T < 3.0, 0, 2] = -20.0
    while_exempt, longer = (
        replace(flown(moved(1.0, up, 0, (0.0, 0.0, 0.0))), true_eta=push) for up in (6.0, 9.0)
    )
    said = "cf1 hit the floor at 1.0 s (no command could prevent it: policies exempt it)"
    assert output(while_exempt) == said
    assert output(longer) == "cf1 hit the floor at 1.0 s"
    judged = [one.t for one in judge(trace_from_arrays(longer), AROUND, IN_FLIGHT)]
    assert judged == pytest.approx([1.0])


def test_a_failure_that_policies_exempt_does_not_hide_one_that_they_do_not() -> None:
    push = np.zeros_like(HOVER)
    push[T >= 5.9, 1, 2] = -20.0
    away = moved(2.0, 2.5, 1, (0.0, 2.7, 1.0))
    away[(T >= 6.0) & (T < 6.5), 1] = (0.0, 1.0, 2.8)  # further, while its thrust is exceeded
    said = "cf2 left its path at 2.0 s, up to 1.80 m from its setpoint"
    assert output(replace(flown(away), true_eta=push)) == said
    away[T < 5.0] = HOVER[0]
    exempt = "cf2 left its path at 6.0 s, up to 1.80 m from its setpoint (no command could prevent it: "
    assert output(replace(flown(away), true_eta=push)).startswith(exempt)


def test_a_vehicle_sent_to_the_floor_does_not_hit_it() -> None:
    path = HOVER.copy()
    path[:, 1, 2] = np.clip(0.5 * T, 0.0, 1.0)  # a take-off 0.15 m behind its setpoint
    behind = np.maximum(path - [0.0, 0.0, 0.08], 0.0)
    assert output(flown(behind, path)).startswith("ok")
    assert output(flown(path * [1.0, 1.0, 0.0], path)).startswith("cf1 did not take off at 0.0 s")


def test_several_flights_are_reported_in_one_line_by_their_names() -> None:
    fine = FlightVerdict(5.0)
    assert verdict_line([("aware", fine)]) == "verdict: ok: 5.0 s flown to the end"
    fallen = verdict_of(flown(moved(5.6, 5.8, 1, (0.0, 1.0, 0.0))), AROUND)
    line = verdict_line([("aware", fine), ("ignoring", fallen)])
    assert line == "verdict: aware: ok: 5.0 s flown to the end | ignoring: cf2 hit the floor at 5.6 s"


@pytest.mark.parametrize(("mode", "falls"), [("ignoring", True), ("aware", False)])
def test_a_hover_under_another_by_the_soft_loop_falls_where_the_downwash_is_ignored(
    mode: str, falls: bool
) -> None:
    """At rest K_p 0.81 gives way by eta / K_p = 2.5 / 0.81 = 3.1 m: far below the floor from 1 m."""
    above, below = ([[0.0, 0.0, z]] * 2 for z in (1.5, 1.0))
    vehicles = {
        name: [{"t": t, "pos": pos} for t, pos in zip((0.0, 5.0), path, strict=True)]
        for name, path in (("cf1", above), ("cf2", below))
    }
    document = yaml.safe_load("{duration: 5.0, wake: measured, model: measured_law}") | {"vehicles": vehicles}
    scenario = scenario_from_document("hover", document)
    options = FlightOptions(
        mode="ignoring" if mode == "ignoring" else "aware", model=find_model(scenario.model).interaction
    )
    verdict = str(verdict_of(fly(scenario, options), Circumstances(vehicle=scenario.vehicle)))
    assert verdict.startswith("cf2 hit the floor at" if falls else "ok")
