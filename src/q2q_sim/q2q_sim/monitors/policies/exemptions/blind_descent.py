"""Blind descents that end on the floor: a vehicle that was sent down needs height and time to stop.

    t - t_d < T / 2,    z_d - z <= v_d T / 4        uniform braking from v_d to rest within T / 2

After it, the vehicle is flown again, and no command to land explains that it comes down.

| symbol | name | meaning [unit] |
|---|---|---|
| t_d | left | last tick at which the newest command sent it down [s] |
| z_d, v_d | | height and velocity of sinking then [m], [m/s]; unknown ones limit nothing |
| T | settle | from the last fault to the return [s] (Limits); half of it stops a vehicle (overpowered) |
"""

import numpy as np

from q2q_model.signals.values import Mask
from q2q_sim.monitors.policies.exemptions.feedback_loss import DOWN
from q2q_sim.monitors.policies.flight_trace import FlightTrace


def ends_blind_descent(trace: FlightTrace, row: int, tick: int, settle: float) -> bool:
    """Return whether vehicle `row` is where a command that sent it down has brought it at a tick."""
    before = np.flatnonzero(_sent_down(trace, row)[: tick + 1])
    if not len(before):
        return False
    left, z = int(before[-1]), trace.true_pos[:, row, 2]
    passed, sunk = trace.t[tick] - trace.t[left], z[left] - z[tick]
    previous = max(left - 1, 0)
    sinking = (z[previous] - z[left]) / max(trace.t[left] - trace.t[previous], 1e-9)
    return bool(passed < 0.5 * settle and not sunk > max(sinking, 0.0) * 0.25 * settle)


def _sent_down(trace: FlightTrace, row: int) -> Mask:
    """Return the ticks at which the newest command to a vehicle sends it down, (T,)."""
    status = trace.command_status[:, row]
    newest = np.maximum.accumulate(np.where(np.isfinite(status), np.arange(len(status)), 0))
    return np.asarray(np.isin(status[newest], DOWN))
