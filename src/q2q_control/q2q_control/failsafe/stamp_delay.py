"""Delay of a stamped message beyond the usual one, between clocks that need not agree.

    d_k = w_k - t_k              arrival minus stamp: latency plus clock offset
    l_k = d_k - min d            minimum over the last one to two windows, without d_k

A stream that is suddenly delivered late is detected, however regular its messages. A step ahead of its clock
is a negative l, once, and one back begins anew. l is at most MOST_S: a slower clock, such as that of a
simulator on a busy machine, must not land a vehicle by itself.

| symbol | name | meaning [unit] |
|---|---|---|
| w | now | wall time [s] |
| t | stamp | capture time [s] |
| l | lateness | [s] |
"""

from math import inf

WINDOW_S = 2.0
"""Length of a window [s]: longer than any hold, so that a delay is detected at once."""
MOST_S = 0.5
"""Largest lateness returned [s]: below land_after_s of q2q_control.failsafe.fallback_phases."""


class StampDelayMonitor:
    """Smallest transport delays of this window and of the one before."""

    def __init__(self) -> None:
        self._stamp = inf
        self._quickest = self._before = inf

    def lateness(self, stamp: float, now: float) -> float:
        """Return how much later than usual the message stamped `stamp` [s] arrived at wall time now [s]."""
        took = now - stamp
        if stamp < self._stamp:  # the first, or of a clock that was set back
            self._began, self._quickest, self._before = now, took, inf
        if now - self._began > WINDOW_S:
            self._began, self._before, self._quickest = now, self._quickest, inf
        late = took - min(self._quickest, self._before)
        self._stamp, self._quickest = stamp, min(self._quickest, took)
        return min(late, MOST_S)
