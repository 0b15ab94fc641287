"""Vehicles that may soon be in a jet: a list for each source, rebuilt when a vehicle has moved, compiled.

A vehicle can be in the jet of a source only within `reach` of it (jet_reach.py). The list holds
all that would be within reach if both moved by SLACK and slopes and speeds rose by STEEPER and FASTER: until
then nobody else is. Vehicles in reach are selected at each step among those of the list, in the order along x
of that step, so that no result depends on when the list was made.

Source: L. Verlet, Computer "experiments" on classical fluids, Physical Review 159, 1967.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows
from q2q_sim.air.wake_laws import BLEND
from q2q_sim.plant.body.state_row import X, Y, Z
from q2q_sim.plant.push.insertion_sort import sort_by_x
from q2q_sim.plant.push.jet_reach import Extremes, JetReach, SearchBound, reach, reach_of

SLACK = 0.15
"""Way that a vehicle may go before the list is rebuilt [m]: 75 steps at 1 m/s."""
STEEPER, FASTER = 0.1, 0.5
"""Growth of the largest slope [-] and speed [m/s] before it is rebuilt."""
NEIGHBOURS = 64
"""Places in the list for each vehicle: more than find room within reach."""

STEEPEST, FASTEST = 0, 1
"""Places in the limits."""


class NeighbourList(NamedTuple):
    """List of the vehicles near each source."""

    begin: Rows
    """Place in `found` of the first vehicle near each source, (n,)."""
    end: Rows
    """Place after that of the last, (n,)."""
    found: Rows
    """Rows of the vehicles near each source, by rising x, (places,)."""
    rank: Rows
    """Place of each vehicle along x, (n,)."""
    at: Array
    """x, y, z [m] of the vehicles when the list was made, (3, n)."""
    limits: Array
    """Largest slope [-] and speed [m/s] for which the list holds; -1 if it holds for none, (2,)."""


def empty_list(count: int) -> NeighbourList:
    """Return space for the list of `count` vehicles, which does not hold yet."""
    near = min(max(count - 1, 0), NEIGHBOURS)
    return NeighbourList(
        begin=np.zeros(count, dtype=np.intp),
        end=np.zeros(count, dtype=np.intp),
        found=np.zeros((near + 1) * count, dtype=np.intp),
        rank=np.zeros(count, dtype=np.intp),
        at=np.zeros((3, count)),
        limits=np.full(2, -1.0),
    )


class Search(NamedTuple):
    """Search for the vehicles near a source."""

    reach: JetReach
    across: float
    """Reach at the largest gap [m]."""


@compiled(**HOT)
def _holds(near: NeighbourList, places: Array, past: Extremes) -> bool:
    """Return whether the list holds for vehicles at `places`."""
    at, moved = near.at, 0
    for i in range(places.shape[1]):
        dx, dy, dz = places[X, i] - at[X, i], places[Y, i] - at[Y, i], places[Z, i] - at[Z, i]
        moved += 0 if dx * dx + dy * dy + dz * dz <= SLACK * SLACK else 1
    past_holds = past.steepest <= near.limits[STEEPEST] and past.fastest <= near.limits[FASTEST]
    return bool(moved == 0 and past_holds)


@compiled(**HOT)
def _wider(to: JetReach, gap: float) -> float:
    """Return the reach at a gap if both vehicles move [m]."""
    return reach(to, gap + 2.0 * SLACK) + 2.0 * SLACK


@compiled(**HOT)
def _search(places: Array, bound: SearchBound, past: Extremes) -> Search:
    """Return the search if slopes and speeds rise."""
    lowest, highest = places[Z, 0], places[Z, 0]
    for i in range(places.shape[1]):
        lowest, highest = min(lowest, places[Z, i]), max(highest, places[Z, i])
    to = reach_of(bound, Extremes(past.steepest + STEEPER, past.fastest + FASTER))
    return Search(to, _wider(to, highest - lowest))


@compiled(**HOT)
def _add_near(near: NeighbourList, places: Array, rows: Rows, a: int, search: Search) -> int:
    """Add those near the a-th vehicle along x to the list; return the place after the last."""
    n, j, across = rows.shape[0] - 1, rows[a], search.across
    x, y, z, count = places[X, j], places[Y, j], places[Z, j], near.begin[j]
    first = a
    while first > 0 and x - places[X, rows[first - 1]] <= across:
        first -= 1
    for b in range(first, n):
        i = rows[b]
        dx, dy, gap = places[X, i] - x, places[Y, i] - y, z - places[Z, i]
        if dx > across:
            break
        far = _wider(search.reach, abs(gap))
        if b != a and gap > -BLEND - 2.0 * SLACK and dx * dx + dy * dy <= far * far:
            near.found[count] = i
            count += 1
    return int(count)


@compiled(**HOT)
def _made(near: NeighbourList, places: Array, rows: Rows, search: Search) -> bool:
    """Make the list; return whether it has enough places."""
    n, count = places.shape[1], 0
    for i in range(n):
        near.at[X, i], near.at[Y, i], near.at[Z, i] = places[X, i], places[Y, i], places[Z, i]
    for a in range(n):
        if count + n > near.found.shape[0]:
            return False
        near.begin[rows[a]] = count
        count = _add_near(near, places, rows, a, search)
        near.end[rows[a]] = count
    return True


@compiled(**HOT)
def _reorder(near: NeighbourList, rows: Rows) -> None:
    """Sort the vehicles near each source by x, of which `rows` has the order."""
    found, rank = near.found, near.rank
    for a in range(rank.shape[0]):
        rank[rows[a]] = a
    for j in range(rank.shape[0]):
        for c in range(near.begin[j] + 1, near.end[j]):
            i, b = found[c], c - 1
            while b >= near.begin[j] and rank[found[b]] > rank[i]:
                found[b + 1] = found[b]
                b -= 1
            found[b + 1] = i


@compiled(**HOT)
def update(near: NeighbourList, places: Array, rows: Rows, bound: SearchBound, past: Extremes) -> bool:
    """Sort `rows`, and rebuild the list if it no longer holds.

    Args:
        near: list.
        places: x, y, z [m] of the vehicles, (3, n).
        rows: rows by rising x at the last step, then the number of steps, (n + 1,).
        bound: of the jet.
        past: slopes and speeds.

    Returns:
        Whether it has enough places. If not, `begin` and `end` point into `rows`: all are near each source.
    """
    changed = sort_by_x(places[X], rows)
    if _holds(near, places, past):
        if changed:
            _reorder(near, rows)
        return True
    fits = _made(near, places, rows, _search(places, bound, past))
    near.limits[STEEPEST] = past.steepest + STEEPER if fits else -1.0
    near.limits[FASTEST] = past.fastest + FASTER
    for j in range(0 if fits else places.shape[1]):
        near.begin[j], near.end[j] = 0, places.shape[1]
    return fits
