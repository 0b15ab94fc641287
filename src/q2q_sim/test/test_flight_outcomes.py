"""What happened to vehicles is judged where they truly were, whatever policies allow for."""

import pytest
from judged_hover import flown, moved

from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.flight_outcomes import IN_FLIGHT
from q2q_sim.monitors.policies import Circumstances, judge
from q2q_sim.monitors.policies.inputs.trace_from_arrays import trace_from_arrays


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ((0.0, 0.1, 1.0), "cf1 and cf2 collided at 5.6 s, 0.10 m apart"),
        ((0.0, 2.7, 1.0), "cf2 left its path at 5.6 s, 1.70 m from its setpoint"),
    ],
)
def test_a_displaced_marker_explains_a_failure_and_does_not_undo_it(
    where: tuple[float, float, float], words: str
) -> None:
    flight = flown(moved(5.6, 5.8, 1, where))
    displaced = Circumstances(faults=(Fault("jump", 5.0, 2.0, ("cf2",), -0.5),))
    assert not judge(trace_from_arrays(flight), displaced, IN_FLIGHT)
    said = str(verdict_of(flight, displaced))
    assert said == f"{words} (a marker was displaced: policies allow for it)"
    assert str(verdict_of(flight, Circumstances())) == words
    later = Circumstances(faults=(Fault("jump", 7.0, 2.0, ("cf2",), -0.5),))
    assert str(verdict_of(flight, later)) == words
