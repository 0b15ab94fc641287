"""Flight in progress: what its calls, the outcomes of its orders and the ends of its steps share."""

from math import inf

import numpy as np

from q2q_control.flight_procedure.checks.flight_checks import apart_refusal
from q2q_control.flight_procedure.checks.ground_check import GroundCheck
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.state_machine.procedure_state import ProcedureState
from q2q_control.flight_procedure.state_machine.setpoint_stream import SetpointStream
from q2q_control.flight_procedure.state_machine.transitions import order_of
from q2q_control.flight_procedure.steps import Act, Order, Step
from q2q_model.signals.values import Array


class ActiveFlight:
    """Step of a flight, its stream of setpoints, where it took off and where a transit leads."""

    def __init__(self, params: FlightProcedureParams, landing: LandingParams) -> None:
        self.params, self.landing = params, landing
        self.state = ProcedureState(params, landing)
        self.stream = SetpointStream(params.setpoint_step_max, params.setpoint_timeout_s)
        self.ground = GroundCheck(params, landing)
        self.lands_after_transit = False
        """The transit leads to a landing, not to the plan."""
        self.joins = False
        """The vehicles were in the air already: no take-off, no transit."""
        self.stood: Array = np.full((0, 3), np.nan)
        """Where the vehicles stood when their take-off began [m], world, (n, 3)."""
        self.down: set[str] = set()
        """Vehicles seen locked or offline since an emergency: the others were not cut yet."""
        self.landing_end = -inf
        """Time at which the duration of the landing under way has passed [s]."""

    def order(self, act: Act, observation: Observation) -> Order:
        """Return the order of an act."""
        return order_of(act, observation, self.params, self.landing)

    def give(self, act: Act, observation: Observation, t: float) -> None:
        """Give the order of an act at time t [s]."""
        self.state.give(self.order(act, observation), t)

    def land(self, observation: Observation, t: float, why: str = "") -> None:
        """Land the vehicles where they are, from time t [s] on."""
        self.stream.stop()
        self.state.enter(Step.LANDING, t, why)
        self.give(Act.STOP_STREAM, observation, t)

    def overlap(self, observation: Observation) -> str:
        """Return which vehicles are too close horizontally to land; empty if none are."""
        return apart_refusal(observation.names, observation.pos, self.params.horizontal_separation_min)
