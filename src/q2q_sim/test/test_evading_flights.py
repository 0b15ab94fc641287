"""A vehicle that evades a lost one, and is not measured itself for a moment, stays near its setpoint."""

from q2q_sim.experiments.campaign.campaign_flight import fly_pure
from q2q_sim.experiments.campaign.random_run import draw_run
from q2q_sim.experiments.guided.attack_case import with_faults
from q2q_sim.faults.faults import Fault

REPEATED = Fault("repeated", 3.8, 0.2, (), 0.0)
"""Nobody is measured, 1.6 s after the room has lost the highest of three: the middle one is 0.8 m aside."""


def test_the_way_back_of_a_vehicle_that_evades_begins_where_it_is() -> None:
    """Its evasion was added to that, and it was sent 1.4 m off its setpoint (attack 245)."""
    run = with_faults(draw_run(7376, replan="none"), (REPEATED,))
    assert fly_pure(run).violations == ()
