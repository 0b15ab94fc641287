"""What ends each step of a flight: vehicles and setpoints that arrive, or too long a time without."""

from collections.abc import Callable

from q2q_control.flight_procedure.checks.arrival import (
    above,
    heights_text,
    in_the_air,
    on_the_ground,
    setpoints_rest,
)
from q2q_control.flight_procedure.checks.flight_checks import setpoint_refusal
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.state_machine.active_flight import ActiveFlight
from q2q_control.flight_procedure.steps import ON_GROUND, Act, Call, Step

HAND_OVER_S = 1.0
"""Longest time from the start of a transit until its setpoints are at the vehicles [s]."""


def end_step(flight: ActiveFlight, observation: Observation, t: float) -> None:
    """End the step of a flight at time t [s] if what ends it has happened."""
    _ENDS.get(flight.state.step, _check_ground)(flight, observation, t)


def _climb(flight: ActiveFlight, observation: Observation, t: float) -> None:
    params, state = flight.params, flight.state
    off = state.arrival.update(observation, above(flight.stood, params), t)
    if not off:
        state.enter(Step.HOVER, t)
        state.answer(granted=True, reason=f"hovering: {heights_text(observation)}")
    elif state.late(params.take_off_s, t):
        state.answer(granted=False, reason=f"take-off failed: {off}; landing")
        flight.land(observation, t, off)


def _transit(flight: ActiveFlight, observation: Observation, t: float) -> None:
    if not flight.stream.on:
        _hand_over(flight, observation, t)
        return
    state, first = flight.state, observation.first_points()
    arrived = setpoints_rest(observation, flight.params, first)
    if not arrived:
        state.arrival.reset()
    off = state.arrival.update(observation, in_the_air(first, flight.params), t)
    if arrived and not off:
        _arrive(flight, observation, t)
    elif not setpoints_rest(observation, flight.params):
        state.moving(t)
    elif state.late(0.0, t):
        why = off if arrived else "the setpoints rest away from the first points"
        then = "call land again to land where they are" if flight.lands_after_transit else "holding"
        state.answer(granted=False, reason=f"transit failed: {why}; {then}")
        state.enter(Step.HOLD, t, why)


def _hand_over(flight: ActiveFlight, observation: Observation, t: float) -> None:
    """Stream setpoints once those of the transit are at the vehicles."""
    refusal = setpoint_refusal(observation, flight.params.goal_tolerance, flight.landing)
    if not refusal:
        flight.joins = False
        flight.give(Act.STREAM, observation, t)
    elif t - flight.state.since > HAND_OVER_S:
        flight.state.enter(Step.HOVER, t, refusal)
        flight.state.answer(granted=False, reason=refusal)


def _arrive(flight: ActiveFlight, observation: Observation, t: float) -> None:
    if flight.lands_after_transit:
        flight.land(observation, t)
    else:
        flight.give(Act.START, observation, t)


def _fly(flight: ActiveFlight, observation: Observation, t: float) -> None:
    over = observation.plan is not None and t - flight.state.since > observation.plan.duration
    if over and setpoints_rest(observation, flight.params):
        flight.state.enter(Step.HOLD, t, "the plan is over")


def _hold(flight: ActiveFlight, observation: Observation, t: float) -> None:
    state = flight.state
    if not setpoints_rest(observation, flight.params):
        if state.late(0.0, t):
            state.answer(granted=False, reason="the setpoints do not come to rest; call land again")
        return
    if state.pending is Call.HOLD:
        state.answer(granted=True, reason=f"holding: {heights_text(observation)}")
    elif state.pending is Call.LAND and flight.lands_after_transit:
        flight.give(Act.TRANSIT, observation, t)


def _descend(flight: ActiveFlight, observation: Observation, t: float) -> None:
    params, state = flight.params, flight.state
    off = state.arrival.update(observation, on_the_ground(observation, params), t)
    over = t - flight.landing_end
    to_rest = params.step_timeout_s if state.arrival.there else 0.0
    if not off and over >= 0.0:  # slow landings look like rest before their end
        state.enter(Step.DISARMING, t)
        flight.give(Act.DISARM, observation, t)
    elif state.pending is Call.LAND and over > params.step_timeout_s + to_rest:
        reason = f"not on the ground: {off}; call land again, or emergency"
        state.answer(granted=False, reason=reason)


def _stopped(flight: ActiveFlight, observation: Observation, t: float) -> None:
    flight.down |= {one.name for one in observation.vehicles if one.locked or not one.connected}
    well = all(one.connected and one.locked is False for one in observation.vehicles)
    restarted = flight.state.restarted.update(well and flight.down >= set(observation.names), t)
    if restarted and t - flight.state.since > flight.params.step_timeout_s:
        flight.state.enter(Step.CONNECTED, t, "vehicles were restarted")


def _check_ground(flight: ActiveFlight, observation: Observation, t: float) -> None:
    state, ground = flight.state, flight.ground
    step = ground.update(state.step, observation, t) if state.step in ON_GROUND else None
    if step is not None:
        state.enter(step, t, ground.refusal or ground.unchecked)


_ENDS: dict[Step, Callable[[ActiveFlight, Observation, float], None]] = {
    Step.TAKE_OFF: _climb,
    Step.TRANSIT: _transit,
    Step.FLIGHT: _fly,
    Step.HOLD: _hold,
    Step.LANDING: _descend,
    Step.STOPPED: _stopped,
}
