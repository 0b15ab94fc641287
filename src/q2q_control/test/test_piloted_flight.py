"""A piloted flight passes calls, outcomes and orders between procedure and executors."""

from dataclasses import dataclass, field

from q2q_control.flight_procedure.observation import VehicleReport
from q2q_control.flight_procedure.piloted_flight import PilotedFlight
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import Act, Call, Order, Step
from q2q_model.node.reply import Reply

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
    """Executor of the plan that is never asked."""

    def begin(self, act: Act) -> None:
        """Fail."""
        raise AssertionError(act)

    def outcome(self) -> None:
        """Return nothing."""


def flight() -> tuple[PilotedFlight, Vehicles]:
    vehicles = Vehicles()
    return PilotedFlight(("cf1",), vehicles, Plan(), (FlightProcedureParams(), LandingParams())), vehicles


def test_a_refused_call_reaches_no_executor() -> None:
    piloted, vehicles = flight()
    piloted.refusal = lambda call: f"no {call.value} here"
    assert piloted.call(Call.EMERGENCY, 0.0) == Reply(granted=False, reason="no emergency here")
    assert vehicles.begun == []


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
    assert vehicles.begun == [Act.ARM, Act.CUT]
    vehicles.result = DONE
    piloted.update(0.2)
    ((request, reply),) = piloted.replies()
    assert request is Call.EMERGENCY
    assert reply.granted
    assert piloted.begin_single(Act.ARM, "arm", 0.3) is not None  # not on the ground


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
