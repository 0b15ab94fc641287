"""Neighbours that a lockstep tick waits for, so that its numbers do not depend on who computes first."""

from collections.abc import Callable

import numpy as np

from q2q_control.mpc.neighbours.time_slots import slot_start
from q2q_model.signals.values import Names, SwarmState, TrackStatus


class AwaitedPredictions:
    """Neighbours that are expected to have sent a prediction by the last tick.

    A tick that begins without one no longer expects it: a neighbour that has ended delays one tick only.
    """

    def __init__(self, own: Names, period: float, has_received: Callable[[str, float], bool]) -> None:
        """Expect one prediction in each slot of the other vehicles.

        Args:
            own: vehicles of this node.
            period: length of a slot [s].
            has_received: whether a vehicle's prediction of a tick [s] or a later one is here.
        """
        self._own, self._period, self._has_received = own, period, has_received
        self.reset()

    def reset(self) -> None:
        """Expect nothing."""
        self._slots: dict[str, float] = {}
        self._silent: set[str] = set()

    def complete(self) -> bool:
        """Return whether the predictions expected by the last tick are here."""
        return all(
            self._has_received(name, since) for name, since in self._slots.items() if name not in self._silent
        )

    def begin(self, state: SwarmState) -> None:
        """Begin a tick: expect predictions of all neighbours that have a state and are not silent."""
        self._silent = {name for name, since in self._slots.items() if not self._has_received(name, since)}
        self._slots = {
            state.names[row]: slot_start(state, row, self._period)
            for row in np.flatnonzero(state.status != TrackStatus.LOST).tolist()
            if state.names[row] not in self._own
        }
