"""Periodic checks of vehicles on the ground: the step that they are in, and why they may not take off."""

import numpy as np

from q2q_control.flight_procedure.checks.flight_checks import connection_refusal, take_off_refusal, unchecked
from q2q_control.flight_procedure.observation import Observation
from q2q_control.flight_procedure.procedure_params import FlightProcedureParams, LandingParams
from q2q_control.flight_procedure.steps import Step

PERIOD_S = 1.0
"""Period of the checks [s]."""


class GroundCheck:
    """Result of the last check on the ground."""

    def __init__(self, params: FlightProcedureParams, landing: LandingParams) -> None:
        self._params, self._landing = params, landing
        self.refusal = ""
        """Why the last check refused a take-off."""
        self.unchecked = ""
        """What it could not check, because vehicles do not report it."""
        self._at = -np.inf

    def reset(self) -> None:
        """Check at the next update."""
        self._at = -np.inf

    def update(self, step: Step, observation: Observation, t: float) -> Step | None:
        """Return the step to enter at time t [s]; None if it stays the same."""
        if t - self._at < PERIOD_S:
            return None
        self._at = t
        self.refusal = take_off_refusal(observation, self._params, self._landing)
        before, self.unchecked = self.unchecked, unchecked(observation)
        offline = connection_refusal(observation)
        found = Step.OFFLINE if offline else Step.CONNECTED if self.refusal else Step.CHECKED
        changed = found is not step or (found is Step.CHECKED and self.unchecked != before)
        return found if changed else None
