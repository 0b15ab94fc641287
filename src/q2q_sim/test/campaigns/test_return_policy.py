"""A vehicle that does not come back is judged, unless its thrust does not allow it."""

from dataclasses import replace

import numpy as np
import pytest
from changed_flights import AROUND, broken, changed, only

from q2q_model.signals.values import (
    SwarmState,
)
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.campaigns.random_runs import campaign_flight
from q2q_sim.campaigns.random_runs.random_run import GAINS, draw_run
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies import (
    judge,
    trace_in_lockstep,
)


def test_a_vehicle_that_does_not_come_back_breaks_the_return_once_it_had_its_time() -> None:
    away = only("truth", changed(SwarmState, 7.0, 8.0, pos=lambda pos: pos + np.array([0.0, 0.4, 0.0])))
    assert "return" in broken(away)
    recent = replace(AROUND, faults=(Fault("weak_rotor", 4.0, 1.0, ("cf1",), 0.1),))
    assert "return" not in broken(away, recent)
    earlier = replace(AROUND, faults=(Fault("weak_rotor", 2.0, 1.0, ("cf1",), 0.1),))
    assert "return" in broken(away, earlier)
    for duration, lasts in ((0.49, False), (0.51, True)):
        briefly = changed(SwarmState, 7.0, 7.0 + duration, pos=lambda pos: pos + np.array([0.0, 0.4, 0.0]))
        assert ("return" in broken(only("truth", briefly))) == lasts


def test_a_push_beyond_the_thrust_exempts_and_a_weak_controller_with_thrust_to_spare_does_not() -> None:
    """Run 15 on today's stock firmware: two wakes push the lowest of three by more than its thrust holds."""
    most = {"thrust_max": CRAZYFLIE_2_0.thrust_max}
    stock = {"firmware": "stock", "overrides": {"pid": GAINS | most, "mpc": most}, "faults": []}
    run = replace(draw_run(15), document={**draw_run(15).document, **stock})
    flown = campaign_flight.fly_pure(run)
    assert flown.violations == ()
    blind = {topic: found for topic, found in flown.topics.items() if topic != "truth_interference"}
    unaware = trace_in_lockstep(blind)
    assert {one.policy for one in judge(unaware, campaign_flight.circumstances_of(run))} == {"return"}
    light = {**run.document, "vehicle": "crazyflie_2_1"}  # 27 g with the same motors
    assert campaign_flight.fly_pure(replace(run, document=light)).violations == ()
    weak = {"pid": GAINS | {"k_p_z": 4.0, "k_i_z": 0.0}}
    mutant = replace(
        run, document={**light, "overrides": weak}, options=replace(run.options, mode="ignoring")
    )
    assert "return" in {one.policy for one in campaign_flight.fly_pure(mutant).violations}


@pytest.mark.parametrize(("sags", "judged"), [((0.15,), True), ((0.15, 0.1), False), ((0.09, 0.09), True)])
def test_batteries_that_leave_too_little_thrust_to_come_back_exempt(
    sags: tuple[float, ...], judged: bool
) -> None:
    """Search 377: 1 % of thrust to spare. Of the 1.32 times its weight, 0.81 stop a landing in time."""
    away = only("truth", changed(SwarmState, 7.0, 8.0, pos=lambda pos: pos + np.array([0.0, 0.4, 0.0])))
    sagging = tuple(Fault("battery_sag", 1.0, 1.0, (), size) for size in sags)
    assert ("return" in broken(away, replace(AROUND, faults=sagging))) == judged
