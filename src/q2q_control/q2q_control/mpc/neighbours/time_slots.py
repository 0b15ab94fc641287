"""Time slots in which vehicles broadcast their predictions, staggered over the swarm (time division).

Of n vehicles, the one in row i of the state has slots of length T that begin at

    s_i = T (k + i / n),   k = 0, 1, 2, ...

and sends the first prediction that it makes in a slot. Senders and receivers thus know from the stamp of a
tick alone which predictions have been sent.
"""

import math

from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Names, SwarmState

RATE_HZ = 10.0
"""Predictions of a vehicle per second [Hz]: a path changes within the lag of the tilt, 0.12 s."""


def slot_start(state: SwarmState, row: int, period: float) -> float:
    """Return the beginning of a vehicle's slot of length `period` at the state's time [s]."""
    place = row / len(state.names)
    return period * (math.floor((state.t + SAME_STAMP) / period - place) + place)


class BroadcastSchedule:
    """Time of the last prediction that a node has sent."""

    def __init__(self, own: Names, period: float) -> None:
        """Send predictions of the vehicles `own` once in each slot of length `period` [s]."""
        self._own, self._period = own, period
        self.reset()

    def reset(self) -> None:
        """Forget the last prediction."""
        self._sent = -math.inf

    def take_turn(self, state: SwarmState) -> bool:
        """Return whether to send the prediction of this tick, and remember that it was sent."""
        rows = [state.names.index(name) for name in self._own if name in state.names]
        newest = max((slot_start(state, row, self._period) for row in rows), default=-math.inf)
        if newest - SAME_STAMP < self._sent <= state.t:
            return False
        self._sent = state.t
        return True
