"""Rows of a swarm's state, and their history, for downwash with transport delay.

Compiled code checks no bounds, so the arrays of a state are checked when they become rows.

Samples lie in an array at least twice as long as needed; at its end, the valid ones move to the front. They
are thus contiguous and in order of time, and appending one takes amortised constant time.
"""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Rows, SwarmState

FIRST_CAPACITY = 64
"""Samples [-]: 0.6 s at 100 Hz; doubled when more are needed."""


class StateHistory:
    """Positions, velocities and body z axes of a swarm over the last `span` seconds."""

    def __init__(self, vehicles: int, span: float) -> None:
        self._span = span
        self._stamps = np.empty(FIRST_CAPACITY)  # (K,)
        self._samples = np.empty((FIRST_CAPACITY, vehicles, 9))  # (K, n, pos vel axis)
        self._start = self._end = 0

    @property
    def oldest(self) -> float:
        """Return the oldest stamp held [s]; infinity when there is none."""
        return float(self._stamps[self._start]) if self._end > self._start else np.inf

    @property
    def newest(self) -> float:
        """Return the newest stamp held [s]; minus infinity when there is none."""
        return float(self._stamps[self._end - 1]) if self._end > self._start else -np.inf

    @property
    def held(self) -> tuple[Array, Array]:
        """Return the stamps held, (K,) [s], and pos, vel and axis at each, (K, n, 9): views."""
        return self._stamps[self._start : self._end], self._samples[self._start : self._end]

    def push(self, t: float, sample: Array) -> None:
        """Store pos, vel and axis (n, 9) of time t [s], which must be later than the newest."""
        if self._end == self._stamps.size:
            self._make_room()
        self._stamps[self._end] = t
        self._samples[self._end] = sample
        self._end += 1
        while self._end - self._start > 2 and self._stamps[self._start + 1] <= t - self._span:
            self._start += 1

    def at(self, t: Array, vehicles: Rows) -> Array:
        """Return pos, vel and axis (p, 9) of rows `vehicles` (p,) at times t (p,) [s], interpolated.

        Times outside the history take the oldest or the newest sample. NaN where a sample used is NaN.
        """
        return states_at(*self.held, t, vehicles)

    def reordered(self, rows: Rows) -> "StateHistory":
        """Return the history with `rows` (n,): row k is old row rows[k], or NaN where that is -1."""
        other = StateHistory(rows.size, self._span)
        for k in range(self._start, self._end):
            sample = np.where((rows < 0)[:, None], np.nan, self._samples[k][rows])
            other.push(float(self._stamps[k]), sample)
        return other

    def _make_room(self) -> None:
        held = self._end - self._start
        if 2 * held > self._stamps.size:
            self._stamps = np.concatenate((self._stamps, np.empty_like(self._stamps)))
            self._samples = np.concatenate((self._samples, np.empty_like(self._samples)))
        self._stamps[:held] = self._stamps[self._start : self._end].copy()
        self._samples[:held] = self._samples[self._start : self._end].copy()
        self._start, self._end = 0, held


@compiled
def states_at(times: Array, states: Array, t: Array, vehicles: Rows) -> Array:
    """Return rows (p, c) of `vehicles` (p,) in states (K, n, c) at t (p,) [s], linear between times (K,) [s].

    Times outside take the first or the last state.
    """
    found = np.empty((t.size, states.shape[2]))
    for p in range(t.size):
        after = min(max(np.searchsorted(times, t[p]), 1), times.size - 1)
        before, share = max(after - 1, 0), 0.0
        if after > before:
            share = (t[p] - times[before]) / (times[after] - times[before])
            share = min(max(share, 0.0), 1.0)
        for c in range(states.shape[2]):
            one, other = states[before, vehicles[p], c], states[after, vehicles[p], c]
            found[p, c] = (1.0 - share) * one + share * other
    return found


def state_rows(state: SwarmState) -> Array:
    """Return position, velocity, quaternion and age of every vehicle, (n, 11).

    Raises:
        ValueError: an array does not have a row for each name.
    """
    count = len(state.names)
    try:
        columns = state.pos, state.vel, state.quat, state.age[:, None]
        rows = np.concatenate(columns, axis=1, dtype=np.float64)
        if rows.shape == (count, 11) and state.pos.shape == (count, 3) and state.status.shape == (count,):
            return rows
    except (AttributeError, TypeError, ValueError) as error:  # lists, or rows of different numbers
        raise _misfit(state) from error
    raise _misfit(state)


def _misfit(state: SwarmState) -> ValueError:
    """Return an error that names the first array of a wrong shape."""
    count = len(state.names)
    shapes = {"pos": (count, 3), "vel": (count, 3), "quat": (count, 4), "age": (count,), "status": (count,)}
    for name, shape in shapes.items():
        given = getattr(state, name)
        if not isinstance(given, np.ndarray) or given.shape != shape:
            what = f"of shape {given.shape}" if isinstance(given, np.ndarray) else f"a {type(given).__name__}"
            return ValueError(f"{name} of a state of {count} names is {what}; must be an array {shape}")
    return ValueError("the arrays of a state must be of real numbers")
