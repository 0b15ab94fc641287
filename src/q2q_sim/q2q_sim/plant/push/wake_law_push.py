"""Downwash of a wake law between all vehicles, compiled (q2q_sim.air.wake_laws).

Visits pairs only while x_j - x_i is within the widest reach of the wake over the swarm's height range.
"""

import math

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array, Four, Rows
from q2q_sim.air.wake_laws import MEASURED, NONE, PAPER, pair_eta, wake_delay, wake_reach
from q2q_sim.plant.body.state_row import ETA_Z, X, Y, Z
from q2q_sim.plant.push.insertion_sort import sort_by_x
from q2q_sim.plant.push.state_history_ring import THRUST_RATIO


@compiled(**BORROWING)
def _past_source(ring: Array, steps: int, vehicle: int, late: float) -> Four:
    """Return x, y, z, T / (m g) of a vehicle `late` steps ago."""
    slots = ring.shape[0]
    whole = math.floor(late)
    old = late - whole
    new = 1.0 - old
    a, b = (steps - whole) % slots, (steps - whole - 1) % slots
    return (
        new * ring[a, vehicle, X] + old * ring[b, vehicle, X],
        new * ring[a, vehicle, Y] + old * ring[b, vehicle, Y],
        new * ring[a, vehicle, Z] + old * ring[b, vehicle, Z],
        new * ring[a, vehicle, THRUST_RATIO] + old * ring[b, vehicle, THRUST_RATIO],
    )


@compiled(**BORROWING)
def _late_downwash(state: Array, ring: Array, steps: int, pair: tuple[int, int], step: float) -> float:
    """Return the measured downwash eta_z [m/s^2] of vehicle j on vehicle i, `pair` = (i, j)."""
    i, j = pair
    late = wake_delay(MEASURED, state[j, Z] - state[i, Z]) / step
    x, y, z, thrust_ratio = _past_source(ring, steps, j, late)
    dx, dy = x - state[i, X], y - state[i, Y]
    return float(thrust_ratio * pair_eta(MEASURED, dx * dx + dy * dy, z - state[i, Z])[0])


@compiled(**BORROWING)
def wake_law_push(state: Array, ring: Array, rows: Rows, kind: int, step: float) -> None:
    """Write eta_z [m/s^2] of every vehicle into its row of `state` (n, STATE_WIDTH).

    `ring`, `rows` and `kind` are those of an Air; `step` is physics' [s].
    """
    n = state.shape[0]
    lowest, highest = state[0, Z], state[0, Z]
    for i in range(n):
        state[i, ETA_Z] = 0.0
        lowest, highest = min(lowest, state[i, Z]), max(highest, state[i, Z])
    if kind == NONE or n < 2:
        return
    sort_by_x(state[:, X], rows)
    bound = wake_reach(kind, highest - lowest)
    for a in range(n):
        i = rows[a]
        for b in range(a + 1, n):
            j = rows[b]
            dx, dy = state[j, X] - state[i, X], state[j, Y] - state[i, Y]
            if dx > bound:
                break
            dz = state[j, Z] - state[i, Z]
            if dx * dx + dy * dy > wake_reach(kind, abs(dz)) ** 2:
                continue
            if kind == PAPER:
                on_i, on_j = pair_eta(kind, dx * dx + dy * dy, dz)
                state[i, ETA_Z] += on_i
                state[j, ETA_Z] += on_j
            else:
                state[i, ETA_Z] += _late_downwash(state, ring, int(rows[n]), (i, j), step)
                state[j, ETA_Z] += _late_downwash(state, ring, int(rows[n]), (j, i), step)
