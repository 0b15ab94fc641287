"""Time-outs of lockstep: when to publish a frame again, and when to fly on without a command."""


class ResendTimer:
    """Timer of the tick that waits, on wall time.

    The frame of a stalled tick is published again every `again_s`. After `give_up_s` without an answer the
    tick is missed; the following ticks wait only `again_s`, until an answer arrives.
    """

    def __init__(self, again_s: float, give_up_s: float) -> None:
        self._again_s = again_s
        self._give_up_s = give_up_s
        self._limit = give_up_s
        self._since = 0.0
        self._asked = 0.0

    def begin(self, now: float) -> None:
        """Start waiting for a tick, at wall time now [s]."""
        self._since = self._asked = now

    def answered(self) -> None:
        """Record that the tick was answered."""
        self._limit = self._give_up_s

    def has_expired(self, now: float) -> bool:
        """Return whether the tick is missed."""
        if now - self._since < self._limit:
            return False
        self._limit = self._again_s
        return True

    def is_due(self, now: float) -> bool:
        """Return whether the tick's frame should be published again."""
        if now - self._asked < self._again_s:
            return False
        self._asked = now
        return True
