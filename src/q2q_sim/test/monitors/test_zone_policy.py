"""A pair in the zone is reported once, if its setpoints clear the zone and both vehicles are controlled."""

import numpy as np
import pytest
from hovering_trace import TICK, hovering

from q2q_model.signals.values import CommandStatus
from q2q_sim.monitors.policies import Circumstances, FlightTrace, Violation, judge
from q2q_sim.monitors.policies.inputs.limits import Limits
from q2q_sim.monitors.policies.separation import zone

AROUND = Circumstances(limits=Limits(settle=0.2))
PLACES = np.array([[-3.0, 2.0, 1.4], [2.0, -1.0, 1.0], [3.1, -1.4, 1.6]])
DEEPEST = 60


def entering() -> FlightTrace:
    """Return a flight whose cf3 is above cf2 at a tick, 0.05 m from its axis."""
    flight = hovering(PLACES)
    flight.true_pos[DEEPEST, 2] = PLACES[1] + [0.04, -0.03, 0.5]
    return flight


def entries(flight: FlightTrace) -> tuple[Violation, ...]:
    return judge(flight, AROUND, {"zone": zone})


def test_a_pair_is_reported_once_where_it_is_deepest_in_the_zone() -> None:
    flight = entering()
    flight.true_pos[70, 2] = PLACES[1] + [0.0, 0.08, 0.5]
    (found,) = entries(flight)
    assert (found.policy, found.who, found.limit) == ("zone", "cf2 and cf3", 0.0)
    assert found.t == pytest.approx(DEEPEST * TICK)
    assert found.value == pytest.approx(-0.05)


@pytest.mark.parametrize(("beside", "judged"), [(0.39, False), (0.41, True)])
def test_setpoints_within_stray_of_the_zone_are_a_planned_entry(beside: float, judged: bool) -> None:
    flight = entering()
    flight.sent_pos[:, 2] = PLACES[1] + [0.6 * beside, -0.8 * beside, 0.5]
    assert bool(entries(flight)) == judged


@pytest.mark.parametrize("row", [1, 2])
@pytest.mark.parametrize(("before", "judged"), [(0.19, False), (0.22, True)])
def test_a_pair_is_not_judged_until_settle_after_either_was_lost(
    row: int, before: float, judged: bool
) -> None:
    flight = entering()
    flight.command_status[DEEPEST - round(before / TICK), row] = CommandStatus.HOLD
    assert bool(entries(flight)) == judged
