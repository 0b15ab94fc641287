"""Hand-over to setpoints, as a controller sees it: by the steps that the flight procedure reports.

A controller commands from its first tick on, and its observer and integrals take these commands for flown. On
the ground and in the onboard climb they are not: what is learned there is wrong.
"""

from q2q_control.flight_procedure.steps import FLYING, FOLLOWS_SETPOINTS, Step

STATUS_TOPIC = "procedure/status"
"""Topic of the steps, latched, whatever the node is called that flies the vehicles."""
RECORDED_STATUS_TOPICS = ("radio/status", "crazyswarm/status")
"""Topics of the steps in bags of nodes that had them under their own names."""
_FOLLOWS = {step.value for step in FOLLOWS_SETPOINTS}
_FLYING = {step.value for step in FLYING}
_LANDING = Step.LANDING.value


class HandOver:
    """Whether commands were flown in the last step that a procedure has reported."""

    def __init__(self) -> None:
        """Start without a report, as in a flight that has begun."""
        self._flown = True
        self.flying = True
        """Whether vehicles are in the air, and not landing."""

    def take(self, step: str) -> bool:
        """Take a reported step; return whether commands begin to be flown in it.

        After a landing they go on to be flown, where setpoints could not be stopped.
        """
        self.flying = step in _FLYING
        begins = step in _FOLLOWS and not self._flown
        self._flown = step in _FOLLOWS or step == _LANDING
        return begins
