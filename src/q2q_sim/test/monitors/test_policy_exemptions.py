"""A condition exempts the vehicles that it names from a policy, for its time and within its distance."""

import numpy as np
import pytest
from hovering_trace import TICK, hovering

from q2q_control.failsafe.evasion.descent_evasion import FARTHEST
from q2q_model.signals.values import CommandStatus
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies import Circumstances, judge
from q2q_sim.monitors.policies.exemptions.feedback_loss import DRIFT_M, evading_lately
from q2q_sim.monitors.policies.inputs.limits import Limits
from q2q_sim.monitors.policies.tracking import return_to_path, state_error

PLACES = np.array([[2.0, -1.0, 1.0], [-0.6, 0.4, 1.4]])
LIMITS = Limits(settle=0.2, passing=0.05)


def test_a_vehicle_whose_motors_were_cut_need_not_return_and_the_other_must() -> None:
    flight = hovering(PLACES)
    flight.command_status[20:30, 0] = CommandStatus.CUT
    flight.true_pos[30:45] += [0.0, 0.0, -0.6]  # within 0.2 s of the fault's end
    flight.true_pos[60:] += [0.0, 0.0, -0.3]
    (found,) = judge(flight, Circumstances(limits=LIMITS), {"return": return_to_path})
    assert found.who == "cf2"
    assert found.value == pytest.approx(0.3)


@pytest.mark.parametrize(("late", "who"), [(0.99, ["cf2"]), (1.02, ["cf1", "cf2"])])
def test_a_state_may_be_wrong_until_a_second_after_an_error_that_no_filter_detects(
    late: float, who: list[str]
) -> None:
    flight = hovering(PLACES, ticks=200)
    end = 0.5
    flight.state_pos[round((end + late) / TICK), :, 1] -= 0.11
    jump = Fault("jump", 0.2, end - 0.2, ("cf1",), 0.5)
    found = judge(flight, Circumstances(faults=(jump,), limits=LIMITS), {"state_error": state_error})
    assert [one.who for one in found] == who


@pytest.mark.parametrize(("beyond", "evades"), [(-0.01, True), (0.01, False)])
@pytest.mark.parametrize("status", [CommandStatus.LEVEL, CommandStatus.LAND])
@pytest.mark.parametrize("where", ["true_pos", "sent_pos"])
def test_a_vehicle_may_evade_a_lost_one_that_it_or_its_setpoint_is_near_at_any_height(
    where: str, status: CommandStatus, beyond: float, evades: bool
) -> None:
    flight = hovering(PLACES)
    aside = FARTHEST + DRIFT_M + beyond
    getattr(flight, where)[:, 1] = PLACES[0] + [0.6 * aside, -0.8 * aside, -0.9]
    flight.command_status[40:45, 0] = status
    found = np.zeros((100, 2), dtype=np.bool_)
    found[40:65] = True, evades  # until 0.2 s after the last tick of the status
    np.testing.assert_array_equal(evading_lately(flight, 0.205), found)
