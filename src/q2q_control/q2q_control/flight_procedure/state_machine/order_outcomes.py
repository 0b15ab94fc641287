"""What follows the outcome of an order: the next order, the next step, the answer to the call."""

from q2q_control.flight_procedure.checks.arrival import heights_text
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.state_machine.active_flight import ActiveFlight
from q2q_control.flight_procedure.steps import Act, Order, Step
from q2q_model.node.reply import Reply


def conclude(
    flight: ActiveFlight, order: Order, observation: Observation, outcome: Reply | None, t: float
) -> None:
    """Handle the outcome of an order at time t [s]; one that is late is a failure."""
    outcome = outcome or flight.state.overdue(order, t)
    if outcome is None:
        return
    flight.state.waiting = None
    if order.act is Act.DISARM:
        _on_the_ground(flight, observation, outcome, t)
    elif outcome.granted and order.act is Act.LAND:
        flight.landing_end = t + order.duration
    elif outcome.granted:
        _succeed(flight, order.act, observation, outcome.reason, t)
    else:
        _fail(flight, order.act, observation, outcome.reason, t)


def _on_the_ground(flight: ActiveFlight, observation: Observation, outcome: Reply, t: float) -> None:
    how = "disarmed" if outcome.granted else f"not disarmed: {outcome.reason}"
    flight.state.answer(granted=True, reason=f"on the ground: {heights_text(observation)}; {how}")
    flight.state.enter(Step.CONNECTED, t, how)
    flight.ground.reset()


def _succeed(flight: ActiveFlight, act: Act, observation: Observation, reason: str, t: float) -> None:
    state = flight.state
    if act is Act.WAIT:
        flight.give(Act.ARM, observation, t)
    elif act is Act.ARM:
        flight.stood = observation.pos.copy()
        state.enter(Step.ARMING if flight.joins else Step.TAKE_OFF, t)
        flight.give(Act.STREAM if flight.joins else Act.TAKE_OFF, observation, t)
    elif act is Act.STREAM:
        flight.stream.start(t)
        if flight.joins:
            state.enter(Step.FLIGHT, t)
            state.answer(granted=True, reason="flying the current setpoints")
    elif act is Act.TRANSIT:
        state.enter(Step.TRANSIT, t, reason)
    elif act is Act.START:
        state.enter(Step.FLIGHT, t, reason)
        state.answer(granted=True, reason=reason or "the plan has started")
    elif act is Act.BRAKE:
        state.enter(Step.HOLD, t)
    elif act is Act.STOP_STREAM:
        flight.give(Act.LAND, observation, t)
    elif act is Act.EMERGENCY:
        state.answer(granted=True, reason="motors stopped; restart the vehicles")


def _fail(flight: ActiveFlight, act: Act, observation: Observation, reason: str, t: float) -> None:
    state = flight.state
    state.log.append(f"{act.value} failed: {reason}")
    if act in {Act.WAIT, Act.ARM}:
        flight.ground.refusal = reason
        state.enter(Step.DISARMING, t)
        state.answer(granted=False, reason=reason)
        flight.give(Act.DISARM, observation, t)
    elif act in {Act.TAKE_OFF, Act.STREAM}:  # vehicles may be in the air despite the failure
        state.answer(granted=False, reason=f"{reason}; landing")
        flight.land(observation, t, reason)
    elif act is Act.TRANSIT and flight.lands_after_transit:
        overlap = flight.overlap(observation)
        if overlap:
            text = f"{overlap}, and {reason}; call land again to land anyway"
            state.answer(granted=False, reason=text)
        else:
            flight.land(observation, t, f"where they are: {reason}")
    elif act in {Act.STOP_STREAM, Act.LAND}:
        flight.stream.on = flight.stream.before
        state.enter(Step.HOLD if flight.stream.on else Step.HOVER, t, reason)
        state.answer(granted=False, reason=f"{reason}; call land again, or emergency")
    else:
        state.answer(granted=False, reason=reason)
