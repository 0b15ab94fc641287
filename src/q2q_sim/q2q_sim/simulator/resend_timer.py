"""Time-outs of lockstep: when to publish a frame again, and when to fly on without a command."""

STALL_S = 1.0
"""Time without an answer after which a tick is reported [s]."""


class ResendTimer:
    """Timer of the tick that waits, on wall time.

    The frame of a stalled tick is published again every `period_s`. After `timeout_s` without an answer the
    tick is missed; the following ticks wait only `period_s`, until an answer arrives.
    """

    def __init__(self, period_s: float, timeout_s: float) -> None:
        self._period_s = period_s
        self._timeout_s = timeout_s
        self._limit = timeout_s
        self.has_given_up = False
        """Whether a tick was missed, and none was answered since."""
        self._since = 0.0
        self._asked = 0.0

    def begin(self, now: float) -> None:
        """Start waiting for a tick, at wall time now [s]."""
        self._since = self._asked = now

    def answered(self) -> None:
        """Record that the tick was answered."""
        self._limit, self.has_given_up = self._timeout_s, False

    def is_stalled(self, now: float) -> bool:
        """Return whether the tick waits for long, or follows one that was missed."""
        return self.has_given_up or now - self._since >= STALL_S

    def poll_expiry(self, now: float) -> bool:
        """Return whether the tick is missed; if so, the next ones wait for `resend_period_s` only."""
        if now - self._since < self._limit:
            return False
        self._limit, self.has_given_up = self._period_s, True
        return True

    def poll_resend(self, now: float) -> bool:
        """Return whether to publish the tick's frame again; if so, the period starts again."""
        if now - self._asked < self._period_s:
            return False
        self._asked = now
        return True
