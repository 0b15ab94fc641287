"""Past and future tracks of all vehicles: the controlled ones and those of other controllers.

A controlled vehicle follows its last plan. A vehicle of another controller follows the prediction that its
MPC has sent (q2q_control.mpc.prediction.neighbours), else it is extrapolated at constant velocity. A vehicle
that is no longer visible is extrapolated likewise, and the weight of its downwash decays: it is still there,
but its position is uncertain. The past reaches back as far as the longest downwash delay.
"""

from typing import NamedTuple

import numpy as np

from q2q_control.inputs.alignment import POS, Aligned
from q2q_control.mpc.prediction.downwash_stages import Tracks
from q2q_model.signals.values import Array, Names, SwarmState, TrackStatus
from q2q_model.vehicle.constants import GRAVITY

FAR = 1e6
"""Position of a vehicle without state [m]: out of everybody's reach."""
FADE = 0.5
"""Time constant of the fading downwash of an unseen vehicle [s]: above dropouts of 0.1 to 0.3 s."""
NEGLIGIBLE = 0.02
"""Weight of downwash below which it is neglected [-]."""
MIN_STEP = 1e-9
"""Least time between two entries of a track [s]."""
_LOST = int(TrackStatus.LOST)


class Future(NamedTuple):
    """Predicted motion of n vehicles over N stages."""

    times: Array
    """[s], (N + 1,)."""
    path: Array
    """[m], world, (n, N + 1, 3)."""
    inputs: Array
    """Commanded acceleration [m/s^2], world, (n, N, 3)."""


class Neighbours(NamedTuple):
    """Vehicles of other controllers, and their predicted motion over N stages."""

    names: Names
    pos: Array
    """Present positions [m], world, (n, 3)."""
    path: Array
    """[m], world, (n, N + 1, 3); far away if they have no state."""
    inputs: Array
    """Acceleration by thrust [m/s^2], world, (n, N, 3)."""
    spread: Array
    """Standard deviation of the horizontal position, each axis [m], (n,)."""


class Surroundings:
    """Recent positions of the vehicles."""

    def __init__(self, span: float, loading: float) -> None:
        """Remember the last `span` [s]; `loading` is the share of thrust beyond weight that adds downwash."""
        self._span, self._loading = span, loading
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._names: Names = ()
        self._when: list[float] = []
        self._where: list[Array] = []
        self._unseen: dict[str, float] = {}

    def tracks(self, tick: Aligned, future: Future, others: Neighbours) -> Tracks:
        """Return the tracks of the tick's vehicles, then of the others.

        Args:
            tick: the controlled vehicles.
            future: of the controlled vehicles.
            others: the vehicles of other controllers.
        """
        trust = self._trust(tick, future.path)
        here = np.where(tick.usable[:, None], tick.table[:, POS], future.path[:, 0])
        names = tick.names
        if others.names:
            names, here, future = _with_others(names, here, future, others)
            trust = np.append(trust, np.ones(len(others.names)))
        self._remember(tick.t, names, here)
        times = np.concatenate([self._when, future.times])
        times[len(self._when)] = max(future.times[0], tick.t + MIN_STEP)
        pos = np.ascontiguousarray(np.concatenate([np.stack(self._where), future.path.transpose(1, 0, 2)]))
        thrust_acc = future.inputs + np.array([0.0, 0.0, GRAVITY])  # thrust over mass
        size = np.sqrt((thrust_acc * thrust_acc).sum(axis=-1, keepdims=True))  # (n, N, 1)
        weight = np.ones(size.shape[:2]) * trust[:, None]
        if self._loading > 0.0:
            weight *= 1.0 + self._loading * (size[..., 0] / GRAVITY - 1.0)
        return Tracks(times, pos, thrust_acc / size, weight, len(self._when))

    def _trust(self, tick: Aligned, path: Array) -> Array:
        """Return the weight of each vehicle's downwash by visibility, (n,); move negligible ones far away."""
        trust = np.ones(len(tick.names))
        if tick.usable.all():
            self._unseen = {}
            return trust
        for row, name in enumerate(tick.names):
            if tick.usable[row]:
                self._unseen.pop(name, None)
                continue
            since = self._unseen.setdefault(name, tick.t if name in self._names else -np.inf)
            trust[row] = np.exp((since - tick.t) / FADE)
            if trust[row] < NEGLIGIBLE or not np.isfinite(path[row]).all():
                trust[row], path[row] = 0.0, FAR * (1.0 + row)
        return trust

    def _remember(self, t: float, names: Names, here: Array) -> None:
        if names != self._names:
            self._names, self._when, self._where = names, [], []
        self._when.append(t)
        self._where.append(here)
        while len(self._when) > 1 and self._when[1] <= t - self._span:
            self._when.pop(0)
            self._where.pop(0)


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


def at_constant_velocity(state: SwarmState, own: Names, times: Array) -> Neighbours:
    """Return the vehicles of `state` that are not `own`, extrapolated to the stages' `times` (N + 1,) [s]."""
    rows = [row for row, name in enumerate(state.names) if name not in own] if state.names != own else []
    path = np.array([extrapolated(state, row, times) for row in rows]).reshape(len(rows), times.size, 3)
    return Neighbours(
        names=tuple(state.names[row] for row in rows),
        pos=path[:, 0],
        path=path,
        inputs=np.zeros((len(rows), times.size - 1, 3)),
        spread=np.zeros(len(rows)),
    )


def extrapolated(state: SwarmState, row: int, times: Array) -> Array:
    """Return the path (N + 1, 3) of a vehicle at constant velocity; far away if it has no state."""
    straight = state.pos[row] + state.vel[row] * (times - state.t)[:, None]
    known = np.isfinite(straight).all() and state.status[row] != _LOST
    return straight if known else np.full_like(straight, -FAR * (1.0 + row))
