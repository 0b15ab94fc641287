"""Time that vehicles fly from one tick to the next, of which stamps show only a part.

Stamps may leap because frames came late before, because frames were lost, or because the clock of motion
capture was set ahead. In lockstep a tick is answered for every frame, one TICK_S of flight each: a leap is
flown for as long as frames came before that were not newer, and the rest of it is the clock. Live, a
controller's timer has counted the time for which no tick came (q2q_control.failsafe.input_deadline), and no
leap remains but the clock's.

    leap      h > max(GAP_S, 2 h_0)
    flown     e = min(h, h_0 + m) in a leap, h otherwise; at most LONGEST_STEP
    missing   m += TICK_S by a frame that is not newer;  m -= e - TICK_S, at least 0, by a newer one

| symbol | name | meaning [unit] |
|---|---|---|
| h, h_0 | step, _step | step of the stamps to this tick and to the one before, at least TICK_S [s] |
| m | _missing | time flown that stamps have not shown yet [s] |
"""

from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.signals.stamps import TICK_S

GAP_S = 0.05
"""Longest step of stamps that is flown as stamped, or twice the step before [s]; what was in effect in
a longer one is not known."""
LONGEST_STEP = MocapFilterParams().coast_s
"""Longest time for which the last command is integrated [s]: that for which the filter coasts."""


class ElapsedTime:
    """Step of the last tick, and the time flown since stamps were complete."""

    def __init__(self) -> None:
        self._step, self._missing = TICK_S, 0.0

    def wait(self) -> None:
        """Take a frame that is not newer than the last one."""
        self._missing += TICK_S

    def update(self, step: float, by_frame: bool) -> float:
        """Return for how long the vehicles flew to this tick [s].

        Args:
            step: of the stamps, from the last tick [s].
            by_frame: whether the stamp of a frame gives it; if not, it was counted without one and is flown.
        """
        leap = by_frame and step > max(GAP_S, 2.0 * self._step)
        flown = min(step, self._step + self._missing) if leap else step
        self._missing = max(self._missing - max(flown - TICK_S, 0.0), 0.0)
        self._step = max(step, TICK_S)
        return min(flown, LONGEST_STEP)
