"""Dead-reckoned descents that end on the floor: a vehicle that was sent down needs height and time to stop.

    t - t_d < T / 2,    z_d - z <= v_d T / 4        uniform braking from v_d to rest within T / 2

After it, the vehicle is flown again, and no command to land explains that it comes down.

| symbol | name | meaning [unit] |
|---|---|---|
| t_d | left | last tick at which the newest command sent it down [s] |
| z_d, v_d | | height and velocity of sinking then [m], [m/s]; exempt where either is unknown |
| T | settle | from the last fault to the return [s] (Limits); half of it stops a vehicle (thrust_exceeded) |
"""

from math import nan

import numpy as np

from q2q_model.flights.masks_over_time import last_row
from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Mask
from q2q_sim.monitors.policies.exemptions.feedback_loss import DOWN
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace

SINKING_OVER = 0.1
"""Time up to t_d over which v_d is taken [s]: 2 mm of noise are 3 cm/s, and 2.5 cm of height to stop."""


def ends_dead_reckoned_descent(trace: FlightTrace, row: int, tick: int, settle: float) -> bool:
    """Return whether vehicle `row` is where a command that sent it down has brought it at a tick."""
    before = np.flatnonzero(_sent_down(trace, row)[: tick + 1])
    if not len(before):
        return False
    left, z = int(before[-1]), trace.true_pos[:, row, 2]
    passed, sunk = trace.t[tick] - trace.t[left], z[left] - z[tick]
    sinking = np.maximum(_sinking(trace, row, left), 0.0)
    return bool(passed < 0.5 * settle and not sunk > sinking * 0.25 * settle)


def _sinking(trace: FlightTrace, row: int, left: int) -> float:
    """Return v_d of a vehicle at a tick [m/s]; NaN if unknown, as in the held state of a lost vehicle."""
    t, pos = trace.t[: left + 1], trace.true_pos[: left + 1, row]
    since = max(int(np.searchsorted(t, t[left] - SINKING_OVER + SAME_STAMP, "right")) - 1, 0)
    if since == left or (pos[since:] == pos[left]).all():
        return nan
    return float((pos[since, 2] - pos[left, 2]) / (t[left] - t[since]))


def _sent_down(trace: FlightTrace, row: int) -> Mask:
    """Return the ticks at which the newest command to a vehicle sends it down, (T,)."""
    status = trace.command_status[:, row]
    newest = np.maximum(last_row(np.isfinite(status)), 0)
    return np.asarray(np.isin(status[newest], DOWN))
