"""Transition table of the flight procedure: the steps that allow a call, and the acts that it leads to."""

import numpy as np

from q2q_control.flight_procedure.checks.flight_checks import (
    airborne_refusal,
    attitude_refusal,
    cut_refusal,
    join_refusal,
    room_refusal,
    state_refusal,
    take_off_refusal,
)
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import FLYING, ON_GROUND, Act, Call, Order, Step

ACTS_OF = {
    Call.START: (Act.ARM, Act.STREAM),
    Call.TAKE_OFF: (Act.WAIT, Act.ARM, Act.TAKE_OFF),
    Call.FLY: (Act.TRANSIT, Act.STREAM, Act.START),
    Call.HOLD: (Act.BRAKE,),
    Call.LAND: (Act.STOP_STREAM, Act.LAND, Act.DISARM),
    Call.EMERGENCY: (Act.EMERGENCY,),
}
"""Acts of each call, in order."""
ALLOWED_IN = {
    Call.START: ON_GROUND,
    Call.TAKE_OFF: ON_GROUND,
    Call.FLY: frozenset({Step.HOVER, Step.HOLD}),
    Call.HOLD: frozenset({Step.TRANSIT, Step.FLIGHT}),
    Call.LAND: FLYING | {Step.ARMING, Step.LANDING},
    Call.EMERGENCY: frozenset(Step),
}
"""Steps in which each call is allowed."""


def step_refusal(call: Call, step: Step) -> str:
    """Return why a call is not allowed in a step; empty if it is."""
    if step in ALLOWED_IN[call]:
        return ""
    allowed = ", ".join(one.value for one in Step if one in ALLOWED_IN[call])
    return f"the step is {step.value}: {call.value} is allowed in {allowed}"


def check_refusal(
    call: Call, observation: Observation, params: FlightProcedureParams, landing: LandingParams
) -> str:
    """Return why the checks of a call refuse it; empty if they do not."""
    if call is Call.TAKE_OFF:
        return take_off_refusal(observation, params, landing)
    if call is Call.START:
        return join_refusal(observation, params, landing)
    if call is Call.FLY:
        unfit = airborne_refusal(observation) or cut_refusal(observation)
        unfit = unfit or state_refusal(observation, landing) or attitude_refusal(observation)
        unplanned = "" if observation.plan else "no plan is waiting"
        return unfit or unplanned or room_refusal(observation, params)
    return ""


def order_of(
    act: Act, observation: Observation, params: FlightProcedureParams, landing: LandingParams
) -> Order:
    """Return the order of an act, with height and duration of a take-off or landing."""
    if act is Act.TAKE_OFF:
        return Order(act, params.ground_height + params.take_off_height, params.take_off_s)
    if act is Act.LAND:
        height = float(np.nan_to_num(observation.pos[:, 2] - params.ground_height).max(initial=0.0))
        return Order(act, params.ground_height, landing.duration(height))
    return Order(act)
