"""A vehicle that evades a lost one keeps its distance, also after it was not measured itself for a moment."""

from q2q_sim.campaigns.falsification.counterexample import with_faults
from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure
from q2q_sim.campaigns.random_runs.random_run import draw_run
from q2q_sim.faults.faults import Fault

REPEATED = Fault("repeated", 3.8, 0.2, (), 0.0)
"""Nobody is measured, 1.6 s after the room has lost the highest of three: the middle one is 0.8 m aside."""
UPPER, LOWER = Fault("dropout", 4.08, 2.7, ("cf1",), 0.0), Fault("dropout", 4.72, 0.45, ("cf2",), 0.0)
"""cf2 passes cf1 along y at 1.5 m/s as that is lost, and is lost 0.3 m beyond it."""

WITHIN_GUSTS = (
    Fault("outlier", 4.37, 0.1, ("cf2",), 1.32),
    Fault("outlier", 4.46, 0.07, ("cf2",), 1.51),
    Fault("swap", 4.7, 0.2, ("cf1", "cf2"), 0.0),
    Fault("clock_jump", 4.882351994040871, 0.7878087901262931, (), 0.04461648436346222),
)
"""Afterwards the room loses cf2 for 2.7 s, and gusts carry it 0.75 m off its dead-reckoned position."""


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


def test_who_evades_is_as_far_away_as_the_lost_one_may_have_drifted() -> None:
    """It lagged behind the distance to keep, which grows, and the lost one passed at 0.10 m (search 26)."""
    run = with_faults(draw_run(783, replan="safe"), WITHIN_GUSTS)
    assert fly_pure(run).violations == ()
