"""Height loss of vehicles under another: height below the reference by which a downwash pushed them.

A height loss counts from the moment at which a vehicle is under another until AFTER seconds later, and goes
on while the vehicle is below its reference, until the air counts as clear: it can grow for a second after the
pass.
"""

import numpy as np

from q2q_model.counted import counted
from q2q_model.flights.flight import Flight
from q2q_model.flights.masks_over_time import last_row
from q2q_model.signals.values import Array
from q2q_sim.monitors.metrics.exposure import AFTER, FORGOTTEN, exposed

LOSS_SHOWN = 0.02
"""Smallest height below the reference that is reported [m]: a hover wanders as much."""


def height_loss(flight: Flight, pos: Array, ref_pos: Array) -> Array:
    """Return the height below the reference of vehicles under another [m], (T, n); NaN elsewhere."""
    loss: Array = ref_pos[:, :, 2] - pos[:, :, 2]
    under, decaying = exposed(pos, flight.t, AFTER), exposed(pos, flight.t, FORGOTTEN)
    goes_on = decaying & (last_row(~under & ~(loss > 0.0)) < last_row(under))
    return np.where(under | goes_on, loss, np.nan)


def height_loss_text(flight: Flight, pos: Array, ref_pos: Array, since: float) -> str:
    """Return who lost most height and when, or why nobody.

    Args:
        flight: a part of one.
        pos: positions [m], world, (T, n, 3).
        ref_pos: references [m], world, (T, n, 3).
        since: start of the part, from that of the flight [s].
    """
    under = exposed(pos, flight.t, 0.0).any(axis=0)
    if not under.any():
        return "no vehicle passed under another"
    loss = height_loss(flight, pos, ref_pos)
    if not np.isfinite(loss).any():
        vehicles = counted(int(under.sum()), "vehicle")
        return f"{vehicles} flew under another, without a reference for the height loss"
    tick, row = np.unravel_index(int(np.nanargmax(loss)), loss.shape)
    depth = float(loss[tick, row])
    if depth < LOSS_SHOWN:
        return "no vehicle pushed down"
    t = round(since + float(flight.t[tick] - flight.t[0]), 6)  # a part rounds as the whole flight does
    return f"{flight.names[row]} pushed {100.0 * depth:.0f} cm down at {t:.1f} s"
