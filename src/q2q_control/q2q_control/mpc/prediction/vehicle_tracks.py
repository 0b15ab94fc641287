"""Tracks, past and future, of all vehicles: the controlled ones and those of other controllers.

A controlled vehicle follows its last solution, or flies on at its velocity if it has no attitude or setpoint.
A vehicle of another controller follows the prediction that its MPC has sent
(q2q_control.mpc.neighbours.exchanged_paths), else it is extrapolated
(q2q_control.mpc.neighbours.constant_velocity). The weight of a controlled vehicle's downwash decays once it
is no longer seen: it is still there, but its position is uncertain. The past reaches back as far as the
longest downwash delay.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from q2q_control.inputs.alignment import POS, Aligned
from q2q_control.mpc.neighbours.constant_velocity import FAR, Neighbours
from q2q_control.mpc.prediction.downwash_horizon_kernel import PlainTracks, Tracks
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, Rows, index_of
from q2q_model.vehicle.constants import GRAVITY

UNSEEN_FADE = 0.5
"""Time constant of the fading downwash of an unseen vehicle [s]: above dropouts of 0.1 to 0.3 s."""
NEGLIGIBLE = 0.02
"""Weight of downwash below which it is neglected [-]."""
MIN_STEP = 1e-9
"""Minimum time between two entries of a track [s]."""


class Future(NamedTuple):
    """Predicted motion of n vehicles over N stages."""

    times: Array
    """[s], (N + 1,)."""
    path: Array
    """[m], world, (n, N + 1, 3)."""
    inputs: Array
    """Commanded acceleration [m/s^2], world, (n, N, 3)."""


class Past(NamedTuple):
    """Recent positions of n vehicles."""

    times: Array
    """Rising [s], (K,)."""
    pos: Array
    """[m], world, (K, n, 3)."""


class Present(NamedTuple):
    """Present positions of n vehicles."""

    t: float
    """[s]"""
    pos: Array
    """[m], world, (n, 3)."""
    trust: Array
    """Weight of each vehicle's downwash by visibility, (n,)."""


PlainFuture = tuple[Array, Array, Array]
"""Fields of a Future, which numba takes from Python in less than half the time."""
PlainPresent = tuple[float, Array, Array]
"""Fields of a Present."""


class VehicleTracks:
    """Recent positions of the vehicles."""

    def __init__(self, span: float, loading: float) -> None:
        """Remember the last `span` [s]; `loading` is the share of thrust beyond weight that adds downwash."""
        self._span, self._loading = span, loading
        self._names: Names = ()
        self._past = Past(np.zeros(0), np.zeros((0, 0, 3)))
        self._unseen: dict[str, float] = {}

    def tracks(self, tick: Aligned, future: Future, others: Neighbours) -> Tracks:
        """Return the tracks of the tick's vehicles, then of the others.

        Args:
            tick: the controlled vehicles.
            future: of the controlled vehicles.
            others: the vehicles of other controllers.
        """
        trust = self._trust(tick, future.path)
        here = tick.table[:, POS].copy()
        if not tick.all_usable:
            here = np.where(tick.seen[:, None], here, future.path[:, 0])
        names = tick.names
        if others.names:
            names, here, future = _with_others(names, here, future, others)
            trust = np.concatenate((trust, np.ones(len(others.names))))
        if names != self._names:
            rows = index_of(names, self._names)
            self._names, self._past = names, _reordered(self._past, rows, here)
        present = tick.t, here, trust
        tracks = Tracks(*_joined((*self._past,), present, (*future,), self._span, self._loading))
        self._past = Past(tracks.times[: tracks.first], tracks.pos[: tracks.first])
        return tracks

    def _trust(self, tick: Aligned, path: Array) -> Array:
        """Return the weight of each vehicle's downwash by visibility, (n,); move negligible ones far away."""
        if tick.all_usable:
            self._unseen = {}
            return _full_trust(len(tick.names))
        trust = np.ones(len(tick.names))
        for row, name in enumerate(tick.names):
            if tick.seen[row]:
                self._unseen.pop(name, None)
                continue
            since = self._unseen.setdefault(name, tick.t if name in self._names else -np.inf)
            trust[row] = np.exp((since - tick.t) / UNSEEN_FADE)
            if trust[row] < NEGLIGIBLE or not np.isfinite(path[row]).all():
                trust[row], path[row] = 0.0, FAR * (1.0 + row)
        return trust


@lru_cache
def _full_trust(vehicles: int) -> Array:
    """Return a weight of 1 for so many vehicles, which nobody changes."""
    return np.ones(vehicles)


def _reordered(past: Past, rows: Rows, here: Array) -> Past:
    """Return the past of the vehicles of `rows`; new ones, of row -1, have been where they are, (n, 3)."""
    known = np.concatenate((past.pos, np.zeros((past.times.size, 1, 3))), axis=1)[:, rows]
    return Past(past.times, np.where((rows >= 0)[:, None], known, here))


@compiled
def _joined(
    before: tuple[Array, Array], present: PlainPresent, after: PlainFuture, span: float, loading: float
) -> PlainTracks:
    """Return the tracks through the past, the present and the future.

    Of what is older than `span` [s], one entry is kept.
    """
    past, now, future = Past(*before), Present(*present), Future(*after)
    first, stages = 0, future.times.size
    while first < past.times.size:
        later = past.times[first + 1] if first + 1 < past.times.size else now.t
        if later > now.t - span:
            break
        first += 1
    held = past.times.size - first
    times, pos = np.empty(held + 1 + stages), np.empty((held + 1 + stages, now.pos.shape[0], 3))
    times[:held], pos[:held] = past.times[first:], past.pos[first:]
    times[held], pos[held] = now.t, now.pos
    for k in range(stages):
        times[held + 1 + k] = future.times[k]
        for v in range(now.pos.shape[0]):
            for axis in range(3):
                pos[held + 1 + k, v, axis] = future.path[v, k, axis]
    times[held + 1] = max(future.times[0], now.t + MIN_STEP)
    body_z, weight = thrust_axes(future.inputs, now.trust, loading)
    return times, pos, body_z, weight, held + 1


@compiled
def thrust_axes(inputs: Array, trust: Array, loading: float) -> tuple[Array, Array]:
    """Return body z along the thrust, (n, N, 3), and the weight of each source's downwash, (n, N).

    Without thrust, in free fall, body z is level.

    Args:
        inputs: acceleration by thrust, less gravity [m/s^2], world, (n, N, 3).
        trust: weight by visibility, (n,).
        loading: share of thrust beyond weight that adds downwash.
    """
    n, stages = inputs.shape[0], inputs.shape[1]
    axis, weight = np.empty((n, stages, 3)), np.empty((n, stages))
    for i in range(n):
        for k in range(stages):
            x, y, z = inputs[i, k, 0], inputs[i, k, 1], inputs[i, k, 2] + GRAVITY
            size = math.sqrt(x * x + y * y + z * z)
            if size == 0.0:
                axis[i, k, 0], axis[i, k, 1], axis[i, k, 2] = 0.0, 0.0, 1.0
            else:
                axis[i, k, 0], axis[i, k, 1], axis[i, k, 2] = x / size, y / size, z / size
            weight[i, k] = trust[i]
            if loading > 0.0:
                weight[i, k] *= 1.0 + loading * (size / GRAVITY - 1.0)
    return axis, weight


def _with_others(
    names: Names, here: Array, future: Future, others: Neighbours
) -> tuple[Names, Array, Future]:
    """Return names, positions and future with the vehicles of other controllers appended."""
    return (
        names + others.names,
        np.concatenate([here, others.pos]),
        Future(
            future.times,
            np.concatenate([future.path, others.path]),
            np.concatenate([future.inputs, others.inputs]),
        ),
    )
