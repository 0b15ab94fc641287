"""A vehicle that evades a lost one, and is not measured itself for a moment, evades from where it is then."""

from q2q_sim.campaigns.falsification.counterexample import with_faults
from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure
from q2q_sim.campaigns.random_runs.random_run import draw_run
from q2q_sim.faults.faults import Fault

REPEATED = Fault("repeated", 3.8, 0.2, (), 0.0)
"""Nobody is measured, 1.6 s after the room has lost the highest of three: the middle one is 0.8 m aside."""
UPPER, LOWER = Fault("dropout", 4.08, 2.7, ("cf1",), 0.0), Fault("dropout", 4.72, 0.45, ("cf2",), 0.0)
"""cf2 passes cf1 along y at 1.5 m/s as that is lost, and is lost 0.3 m beyond it."""


def test_the_way_back_of_a_vehicle_that_evades_begins_where_it_is() -> None:
    """Its evasion was added to that, and it was sent 1.4 m off its setpoint (search 245)."""
    run = with_faults(draw_run(7376, replan="none"), (REPEATED,))
    assert fly_pure(run).violations == ()


def test_a_vehicle_found_beyond_a_lost_one_does_not_go_back_beneath_it() -> None:
    """It evaded to the side on which it had begun, through the place of the lost vehicle, 0.9 m beyond."""
    flown = fly_pure(with_faults(draw_run(576, replan="none"), (UPPER, LOWER)))
    assert flown.violations == ()
    row = flown.topics["truth"][0].names.index("cf2")
    assert min(one.pos[row, 1] for one in flown.topics["truth"] if one.t > 5.0) > 0.3
