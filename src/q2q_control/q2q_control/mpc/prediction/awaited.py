"""Neighbours that a lockstep tick waits for, so that its numbers do not depend on who answers first."""

from collections.abc import Callable

from q2q_model.signals.values import Names, SwarmState, TrackStatus


class AwaitedPredictions:
    """Neighbours that are expected to have sent a prediction in the last tick.

    A tick that begins without one no longer expects it: a neighbour that has ended delays one tick only.
    """

    def __init__(self, own: Names, has_heard: Callable[[str, float], bool]) -> None:
        """Take the own vehicles, and whether a vehicle's prediction of a tick [s] or a later one is here."""
        self._own, self._has_heard = own, has_heard
        self._expected: set[str] = set()
        self._silent: set[str] = set()
        self._last = 0.0

    def complete(self) -> bool:
        """Return whether the expected predictions of the last tick are here."""
        return all(self._has_heard(name, self._last) for name in self._expected)

    def begin(self, state: SwarmState) -> None:
        """Begin a tick: expect its predictions of all neighbours that have a state and are not silent."""
        self._silent |= {name for name in self._expected if not self._has_heard(name, self._last)}
        self._silent -= {name for name in self._silent if self._has_heard(name, self._last)}
        seen = zip(state.names, state.status, strict=True)
        known = {name for name, status in seen if status != TrackStatus.LOST}
        self._expected, self._last = known - set(self._own) - self._silent, state.t
