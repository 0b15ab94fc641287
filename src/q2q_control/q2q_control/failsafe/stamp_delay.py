"""Say how much later than usual a stamp came, where two clocks need not agree.

    d_k = w_k - t_k              wall time of arrival minus stamp: latency plus the clocks' difference
    l_k = d_k - min d            over the last window or two: the quickest stands for the usual

A stream that is suddenly delivered late shows as late, however regularly its messages come. A clock that
was set is forgotten after two windows with messages. l is at most MOST_S: a clock that runs slower than
ours, as that of a simulator on a busy machine, must not land a vehicle by itself.

| symbol | name | meaning [unit] |
|---|---|---|
| w | now | wall time [s] |
| t | stamp | capture time [s] |
| l | lateness | [s] |
"""

from math import inf

WINDOW_S = 2.0
"""How long the quickest message counts [s]: longer than any hold, so that lateness is seen at first."""
MOST_S = 0.5
"""Largest lateness that is told [s]: below land_s of q2q_control.failsafe.ladder."""


class StampDelayMonitor:
    """Smallest transport delays of this window and of the one before."""

    def __init__(self) -> None:
        self._began = -inf
        self._quickest = inf
        self._before = inf

    def lateness(self, stamp: float, now: float) -> float:
        """Return how much later than usual the message of a stamp [s] came at wall time now [s]."""
        took = now - stamp
        if now - self._began > WINDOW_S:
            self._began, self._before, self._quickest = now, self._quickest, took
        self._quickest = min(self._quickest, took)
        return min(took - min(self._quickest, self._before), MOST_S)
