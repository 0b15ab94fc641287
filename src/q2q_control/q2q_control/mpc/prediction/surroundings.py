"""Know where all vehicles were and will be: the controlled ones and those of other controllers.

A controlled vehicle goes where its last plan says. A vehicle that is not ours goes where it said it would
(q2q_control.mpc.prediction.predictions), or straight on if it said nothing. One that is no longer seen goes
on likewise, and its downwash counts less and less: it is still there, but nobody knows where. The past
reaches as far back as downwash travel.
"""

import numpy as np

from q2q_control.inputs.alignment import POS, Aligned
from q2q_control.mpc.prediction.downwash_horizon import Tracks
from q2q_control.mpc.prediction.predictions import Predictions, path_at
from q2q_model.signals.values import Array, Names, SwarmState, TrackStatus
from q2q_model.vehicle.constants import GRAVITY

FAR = 1e6
"""Where a vehicle without state is put [m]."""
FADE = 0.5
"""Time constant of the fading downwash of an unseen vehicle [s]: above dropouts of 0.1 to 0.3 s."""
FORGOTTEN = 0.02
"""Downwash that counts less than this counts nothing [-]."""
LATER = 1e-9
"""Two entries of a track are at least this far apart [s]."""
_LOST = int(TrackStatus.LOST)


class Surroundings:
    """Recent positions of the vehicles."""

    def __init__(self) -> None:
        self.heard: Predictions | None = None
        self.loading = 0.0
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._names: Names = ()
        self._when: list[float] = []
        self._where: list[Array] = []
        self._unseen: dict[str, float] = {}

    def tracks(
        self, tick: Aligned, state: SwarmState, future: tuple[Array, Array, Array], span: float
    ) -> Tracks:
        """Return the tracks of the tick's vehicles, then of the others in `state`.

        Args:
            tick: the controlled vehicles.
            state: everybody.
            future: stages (N + 1,) [s], paths (n, N + 1, 3) [m], inputs (n, N, 3) [m/s^2] of the controlled.
            span: how far back downwash comes from [s].
        """
        times, path, inputs = future
        trust = self._trust(tick, path)
        here = np.where(tick.usable[:, None], tick.table[:, POS], path[:, 0])
        names = tick.names
        if state.names != names:
            names, here, path, inputs = self._with_others(state, (times, here, path, inputs), names)
            trust = np.append(trust, np.ones(len(names) - trust.size))
        self._remember(tick.t, names, here, span)
        start = max(times[0], tick.t + LATER)
        when = np.concatenate([self._when, times])
        when[len(self._when)] = start
        pos = np.ascontiguousarray(np.concatenate([np.stack(self._where), path.transpose(1, 0, 2)]))
        lift = inputs + np.array([0.0, 0.0, GRAVITY])
        thrust = np.sqrt((lift * lift).sum(axis=-1, keepdims=True))  # over mass, (n, N, 1)
        strength = 1.0 + self.loading * (thrust[..., 0] / GRAVITY - 1.0) if self.loading > 0.0 else None
        return Tracks(when, pos, lift / thrust, trust, len(self._when), strength)

    def _trust(self, tick: Aligned, path: Array) -> Array:
        """Return how much each vehicle's downwash counts, (n,); put those that count nothing far away."""
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
            if trust[row] < FORGOTTEN or not np.isfinite(path[row]).all():
                trust[row], path[row] = 0.0, FAR * (1.0 + row)
        return trust

    def _remember(self, t: float, names: Names, here: Array, span: float) -> None:
        if names != self._names:
            self._names, self._when, self._where = names, [], []
        self._when.append(t)
        self._where.append(here)
        while len(self._when) > 1 and self._when[1] <= t - span:
            self._when.pop(0)
            self._where.pop(0)

    def _with_others(
        self, state: SwarmState, ours: tuple[Array, Array, Array, Array], names: Names
    ) -> tuple[Names, Array, Array, Array]:
        times, here, path, inputs = ours
        rows = [row for row, name in enumerate(state.names) if name not in names]
        if not rows:
            return names, here, path, inputs
        theirs = np.stack([self._stranger(state, row, times) for row in rows])
        return (
            names + tuple(state.names[row] for row in rows),
            np.concatenate([here, theirs[:, 0]]),
            np.concatenate([path, theirs]),
            np.concatenate([inputs, np.zeros((len(rows), *inputs.shape[1:]))]),
        )

    def _stranger(self, state: SwarmState, row: int, times: Array) -> Array:
        """Return the path (N + 1, 3) of a vehicle that is not ours."""
        told = None if self.heard is None else path_at(self.heard, state.names[row], times)
        if told is not None:
            return told
        straight = state.pos[row] + state.vel[row] * (times - state.t)[:, None]
        known = np.isfinite(straight).all() and state.status[row] != _LOST
        return straight if known else np.full_like(straight, -FAR * (1.0 + row))
