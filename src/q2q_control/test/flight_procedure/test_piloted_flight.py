"""A piloted flight passes calls, outcomes and orders between procedure and executors."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_control.flight_procedure.observation import PlanOutline, VehicleReport
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.state_machine.piloted_flight import PilotedFlight
from q2q_control.flight_procedure.steps import Act, Call, Order, Step
from q2q_model.node.reply import Reply
from q2q_model.signals.values import CommandStatus, SwarmCommand, SwarmState

DONE = Reply(granted=True)


@dataclass
class Vehicles:
    """Executor that has begun orders and returns outcomes set by the test."""

    begun: list[Act] = field(default_factory=list)
    result: Reply | None = None

    def begin(self, order: Order, _: float) -> None:
        """Record the act."""
        self.begun.append(order.act)

    def outcome(self, _: float) -> Reply | None:
        """Return the outcome once."""
        result, self.result = self.result, None
        return result

    def reports(self) -> tuple[VehicleReport, ...]:
        """Return a connected vehicle."""
        return (VehicleReport("cf1", connected=True),)


@dataclass
class Plan:
    """Executor of the plan, with outcomes set by the test."""

    begun: list[Act] = field(default_factory=list)
    result: Reply | None = None

    def begin(self, act: Act) -> None:
        """Record the act."""
        self.begun.append(act)

    def outcome(self) -> Reply | None:
        """Return the outcome once."""
        result, self.result = self.result, None
        return result


def flight(params: FlightProcedureParams | None = None) -> tuple[PilotedFlight, Vehicles]:
    vehicles = Vehicles()
    both = params or FlightProcedureParams(), LandingParams()
    return PilotedFlight(("cf1",), vehicles, Plan(), both), vehicles


def in_hover() -> tuple[PilotedFlight, Vehicles, Plan]:
    """Return a flight whose vehicle hovers at 0.5 m over its plan's first point, at t = 1 s."""
    vehicles, plan = Vehicles(), Plan()
    params = FlightProcedureParams(voltage_start=0.0, settle_s=0.5), LandingParams()
    piloted = PilotedFlight(("cf1",), vehicles, plan, params)
    first = np.array([[0.0, 0.0, 1.0]])
    piloted.store_plan(PlanOutline(("cf1",), first, first, first, duration=4.0))
    piloted.store_state(state_at(0.0), 0.0)
    piloted.update(0.0)
    assert piloted.call(Call.TAKE_OFF, 0.0) is None
    for height in (0.0, 0.0, 0.5):
        plan.result, vehicles.result = DONE, DONE
        piloted.store_state(state_at(height), 0.4)
        piloted.update(0.4)
    for t in (0.4, 1.0):
        piloted.store_state(state_at(0.5), t)
        piloted.update(t)
    assert piloted.replies()[0][1].granted
    return piloted, vehicles, plan


def state_at(height: float) -> SwarmState:
    pos = np.array([[0.0, 0.0, height]])
    return resting_state(0.0, ("cf1",), pos)


@pytest.mark.parametrize("call", [Call.START, Call.TAKE_OFF, Call.FLY])
def test_a_refused_flight_reaches_no_executor(call: Call) -> None:
    piloted, vehicles = flight()
    piloted.refusal = lambda: "another radio node runs: radio_2"
    assert piloted.call(call, 0.0) == Reply(granted=False, reason="another radio node runs: radio_2")
    assert vehicles.begun == []


def test_what_refuses_flights_refuses_no_landing_and_no_emergency() -> None:
    piloted, vehicles, _ = in_hover()
    piloted.refusal = lambda: "another radio node runs: radio_2"
    assert piloted.call(Call.LAND, 1.1) is None
    assert vehicles.begun[-1] is Act.STOP_STREAM
    assert piloted.call(Call.EMERGENCY, 1.2) is None
    assert vehicles.begun[-1] is Act.EMERGENCY


def test_a_single_act_is_answered_with_its_outcome() -> None:
    piloted, vehicles = flight()
    assert piloted.begin_single(Act.ARM, "arm", 0.0) is None
    assert piloted.begin_single(Act.DISARM, "disarm", 0.1) is not None  # one at a time
    assert vehicles.begun == [Act.ARM]
    vehicles.result = DONE
    piloted.update(0.2)
    assert piloted.replies() == [(Act.ARM, DONE)]
    assert piloted.replies() == []


def test_a_call_supersedes_a_single_act_and_its_outcome_is_that_of_the_call() -> None:
    piloted, vehicles = flight()
    piloted.begin_single(Act.ARM, "arm", 0.0)
    assert piloted.call(Call.EMERGENCY, 0.1) is None
    assert piloted.replies() == [(Act.ARM, Reply(granted=False, reason="emergency took over"))]
    assert vehicles.begun == [Act.ARM, Act.EMERGENCY]
    vehicles.result = DONE
    piloted.update(0.2)
    ((request, reply),) = piloted.replies()
    assert request is Call.EMERGENCY
    assert reply.granted
    assert piloted.begin_single(Act.ARM, "arm", 0.3) is not None  # not on the ground


@pytest.mark.parametrize("outcome", [DONE, Reply(granted=False, reason="not stopped: cf1 is not connected")])
def test_an_emergency_called_again_is_sent_again_and_has_one_outcome(outcome: Reply) -> None:
    piloted, vehicles = flight()
    assert piloted.call(Call.EMERGENCY, 0.0) is None
    assert piloted.call(Call.EMERGENCY, 0.1) is None
    assert vehicles.begun == [Act.EMERGENCY, Act.EMERGENCY]
    assert piloted.replies() == []
    vehicles.result = outcome
    piloted.update(0.2)
    ((request, reply),) = piloted.replies()
    assert (request, reply.granted) == (Call.EMERGENCY, outcome.granted)


def test_a_refused_call_leaves_a_single_act_under_way() -> None:
    piloted, vehicles = flight()
    piloted.begin_single(Act.ARM, "arm", 0.0)
    refused = piloted.call(Call.HOLD, 0.1)
    assert refused is not None
    assert piloted.replies() == []
    vehicles.result = DONE
    piloted.update(0.2)
    assert piloted.replies() == [(Act.ARM, DONE)]


def test_a_single_act_without_outcome_fails_after_the_patience() -> None:
    piloted, _ = flight()
    piloted.begin_single(Act.ARM, "arm", 0.0)
    piloted.update(FlightProcedureParams().step_timeout_s)
    assert piloted.replies() == []
    piloted.update(FlightProcedureParams().step_timeout_s + 0.1)
    ((request, reply),) = piloted.replies()
    assert (request, reply.granted) == (Act.ARM, False)
    assert piloted.begin_single(Act.DISARM, "disarm", 6.0) is None


def test_in_a_dry_run_no_single_act_is_sent() -> None:
    piloted, vehicles = flight(FlightProcedureParams(dry_run=True))
    refused = piloted.begin_single(Act.ARM, "arm", 0.0)
    assert refused == Reply(granted=False, reason="dry run, not executed; arm means: arm")
    assert vehicles.begun == []


def test_an_order_to_vehicles_is_not_concluded_by_a_late_outcome_of_the_plan() -> None:
    piloted, vehicles, plan = in_hover()
    assert piloted.call(Call.FLY, 1.05) is None
    assert plan.begun[-1] is Act.TRANSIT
    assert piloted.call(Call.LAND, 1.06) is None
    assert vehicles.begun[-1] is Act.STOP_STREAM
    plan.result = Reply(granted=False, reason="no such transit")
    piloted.update(1.07)
    assert vehicles.begun[-1] is Act.STOP_STREAM, "its setpoints are not stopped yet"
    vehicles.result = DONE
    piloted.update(1.08)
    assert vehicles.begun[-1] is Act.LAND


def test_a_status_is_new_once_per_change() -> None:
    piloted, _ = flight()
    first = piloted.new_status()
    assert first is not None
    assert first.step is Step.OFFLINE
    assert piloted.new_status() is None
    piloted.call(Call.EMERGENCY, 0.0)
    changed = piloted.new_status()
    assert changed is not None
    assert changed.step is Step.STOPPED


def test_a_take_off_is_refused_until_the_controller_is_no_longer_cut() -> None:
    piloted, _ = flight(FlightProcedureParams(voltage_start=0.0))
    cut, sound = (
        SwarmCommand(0.0, ("cf1",), *np.zeros((4, 1)), np.array([status], np.uint8))
        for status in (CommandStatus.CUT, CommandStatus.OK)
    )
    piloted.store_command(cut)
    refused = piloted.call(Call.TAKE_OFF, 0.0)
    assert refused is not None
    assert refused.reason.startswith("the controller has cut cf1")
    piloted.store_command(sound)
    other = piloted.call(Call.TAKE_OFF, 0.0)
    assert other is not None
    assert "cut" not in other.reason
