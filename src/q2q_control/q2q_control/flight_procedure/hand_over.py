"""Hand-over to setpoints, as a controller sees it: by the steps that the flight procedure reports.

A controller commands from its first tick on, and its observer and integrals take these commands for flown. On
the ground and in the onboard climb they are not: what is learned there is wrong. With several procedures on
one controller, it is reset only while it flies the vehicles of none: it cannot forget those of one alone.
A procedure whose node has gone flies none, whatever it reported last.
"""

from collections import defaultdict
from collections.abc import Set as AbstractSet

from q2q_control.flight_procedure.steps import FLYING, FOLLOWS_SETPOINTS, Step

STATUS_TOPIC = "procedure/status"
"""Topic of the steps, latched, whatever the node is called that flies the vehicles."""
RECORDED_STATUS_TOPICS = ("radio/status", "crazyswarm/status")
"""Topics of the steps in bags of nodes that had them under their own names."""

RECORDED_TRANSIT = "glide"
"""Name of the step `transit` in bags of nodes that called it so."""

_FOLLOWS = {step.value for step in FOLLOWS_SETPOINTS} | {RECORDED_TRANSIT}
_FLYING = {step.value for step in FLYING} | {RECORDED_TRANSIT}
_LANDING = Step.LANDING.value


def reporter_name(node: str) -> str:
    """Return the name under which a node, given with its namespace, reports its steps."""
    return f"{node}: flight procedure"


class HandOver:
    """Whether commands were flown in the last step that a procedure has reported."""

    def __init__(self) -> None:
        """Start without a report, as in a flight that has begun."""
        self.flown = True
        """Whether commands are flown."""
        self.flying = True
        """Whether vehicles are in the air, and not landing."""
        self._gone = False

    def update(self, step: str) -> bool:
        """Take a reported step; return whether commands begin to be flown in it.

        After a landing they go on to be flown, where setpoints could not be stopped.
        """
        self.flying = step in _FLYING
        begins = step in _FOLLOWS and not self.flown and not self._gone
        self.flown, self._gone = step in _FOLLOWS or step == _LANDING, False
        return begins

    def end(self) -> None:
        """End the procedure, whose node has gone; in flight when it is back, it begins none."""
        self.flown, self.flying, self._gone = False, False, True


class HandOvers:
    """Hand-overs of all procedures that report to a controller."""

    def __init__(self) -> None:
        """Start without a report."""
        self._by_reporter: defaultdict[str, HandOver] = defaultdict(HandOver)
        self._published: set[str] = set()

    @property
    def flying(self) -> bool:
        """Return whether vehicles of any procedure are in the air, and not landing; yes before reports."""
        return not self._by_reporter or any(one.flying for one in self._by_reporter.values())

    def end_absent(self, publishing: AbstractSet[str]) -> None:
        """End the procedures that have published their steps, by themselves, and no longer do.

        Those of a bag, which another node publishes, are never absent.
        """
        self._published |= publishing
        for reporter in (self._by_reporter.keys() & self._published) - publishing:
            self._by_reporter[reporter].end()

    def update(self, reporter: str, step: str) -> bool:
        """Take a step of a procedure; return whether commands begin to be flown, and of no other yet are."""
        own = self._by_reporter[reporter]
        others_flown = any(one.flown for one in self._by_reporter.values() if one is not own)
        return own.update(step) and not others_flown
