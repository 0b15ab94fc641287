"""Motion capture: 100 frames per second with noise, outliers, dropouts, flips and swaps.

Effects on a frame, applied in this order, each from its own random stream:

| effect | what the frame shows | injected flag |
|---|---|---|
| noise | position and attitude off by normal errors | - |
| flip | body turned half a turn about x, y or z: reflections | FLIP |
| swap | poses of the vehicle and its nearest neighbour exchanged | SWAP |
| outlier | position off by a step in a random direction, one frame | OUTLIER |
| stale | the frame before the burst repeated under new stamps, all vehicles | STALE |
| dropout, missing | vehicle absent from the frame for 0.1-0.3 s, or for seconds | DROPOUT |

The first frame says which vehicle is which: no swap begins in it. `injected` lists the effects on the last
frame, for tests only. The camera's latency is not modelled here: a controller knows only stamps, so late
frames and late commands are equivalent, and the room adds both delays to the radio's (q2q_sim.loop.room).
"""

from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from q2q_model.geometry.rotations import quat_multiply
from q2q_model.signals.values import Array, Mask, MocapFrame, SwarmState
from q2q_sim.random_streams import DrawnAhead, stream
from q2q_sim.sensors.episodes import Episodes
from q2q_sim.sensors.pose_noise import add_noise
from q2q_sim.sensors.vicon_params import ViconParams, frequencies


class Injected(IntFlag):
    """Effects on a vehicle's row of a frame."""

    NOTHING = 0
    OUTLIER = 1
    FLIP = 2
    SWAP = 4
    DROPOUT = 8
    STALE = 16
    NAN = 32
    STAMP = 64
    """Frame late, repeated, out of order, or with a wrong stamp (q2q_sim.faults.faults)."""


Flags = NDArray[np.uint8]


class Vicon:
    """Motion capture from true states to frames, one per tick."""

    def __init__(self, params: ViconParams, vehicles: int, tick: float, seed: int) -> None:
        """Observe `vehicles` vehicles every `tick` [s]."""
        self._params = params
        self._rng = {name: stream(seed, f"vicon {name}") for name in ("flip axis", "outlier size")}
        self._noise = DrawnAhead(stream(seed, "vicon noise").standard_normal, (2, vehicles, 3))
        self._happens = [
            (name, Episodes(often, 1 if name == "stale" else vehicles, tick, stream(seed, f"vicon {name}")))
            for name, often in frequencies(params).items()
            if often.rate > 0.0
        ]
        self._now: dict[str, tuple[Mask, Mask]] = {}  # rows in an episode, and that start one, in this tick
        self._turn = np.zeros((vehicles, 4))
        self._partner = np.arange(vehicles)
        self._last: tuple[Array, Array] | None = None
        self.injected: Flags = np.zeros(vehicles, dtype=np.uint8)
        """Effects on each vehicle in the last frame: Injected, (n,)."""

    def observe(self, truth: SwarmState) -> MocapFrame:
        """Return the frame of a tick; call once per tick."""
        self.injected = np.zeros(len(truth.names), dtype=np.uint8)
        pos, quat = self._noisy(truth)
        self._now = {name: now for name, one in self._happens if (now := one.step()) is not None}
        if not self._now:
            self._last = pos, quat
            return MocapFrame(t=truth.t, names=truth.names, pos=pos, quat=quat)
        quat = self._flipped(quat)
        pos, quat = self._swapped(truth.pos, pos, quat)
        pos = self._with_outliers(pos)
        pos, quat = self._stale(pos, quat)
        absent = self._absent()
        if absent is None:
            return MocapFrame(t=truth.t, names=truth.names, pos=pos, quat=quat)
        self._mark(absent, Injected.DROPOUT)
        seen = ~absent
        names = tuple(name for name, here in zip(truth.names, seen, strict=True) if here)
        return MocapFrame(t=truth.t, names=names, pos=pos[seen], quat=quat[seen])

    def _noisy(self, truth: SwarmState) -> tuple[Array, Array]:
        params = self._params
        if params.pos_noise == 0.0 and params.angle_noise == 0.0:
            return truth.pos, truth.quat
        pos, quat = np.empty(truth.pos.shape), np.empty(truth.quat.shape)
        add_noise(
            (truth.pos, truth.quat), self._noise.next(), (params.pos_noise, params.angle_noise), pos, quat
        )
        return pos, quat

    def _flipped(self, quat: Array) -> Array:
        happening = self._now.get("flip")
        if happening is None:
            return quat
        flips, begins = happening
        if begins.any():
            axis = self._rng["flip axis"].integers(0, 3, len(quat))
            self._turn[begins] = np.eye(3, 4)[axis[begins]]  # half a turn about x, y or z
        self._mark(flips, Injected.FLIP)
        return np.where(flips[:, None], quat_multiply(quat, self._turn), quat)

    def _swapped(self, true_pos: Array, pos: Array, quat: Array) -> tuple[Array, Array]:
        happening = self._now.get("swap")
        if len(pos) < 2 or happening is None:
            return pos, quat
        swaps, begins = happening
        for row in np.flatnonzero(begins):
            away = np.linalg.norm(true_pos - true_pos[row], axis=1)
            away[row] = np.inf
            self._partner[row] = row if self._last is None else np.argmin(away)
        rows = np.arange(len(pos))
        for row in np.flatnonzero(swaps):
            rows[[row, self._partner[row]]] = rows[[self._partner[row], row]]
        self._mark(rows != np.arange(len(pos)), Injected.SWAP)
        return pos[rows], quat[rows]

    def _with_outliers(self, pos: Array) -> Array:
        happening = self._now.get("outlier")
        if happening is None:
            return pos
        outliers, _ = happening
        params, rng = self._params, self._rng["outlier size"]
        direction = rng.standard_normal(pos.shape)
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        size = rng.uniform(params.outlier_min, params.outlier_max, (len(pos), 1))
        self._mark(outliers, Injected.OUTLIER)
        return np.where(outliers[:, None], pos + size * direction, pos)

    def _stale(self, pos: Array, quat: Array) -> tuple[Array, Array]:
        if "stale" in self._now and self._last is not None:
            self._mark(np.ones(len(pos), dtype=np.bool_), Injected.STALE)
            return self._last
        self._last = pos, quat
        return pos, quat

    def _mark(self, rows: Mask, what: Injected) -> None:
        self.injected[rows] |= np.uint8(what)

    def _absent(self) -> Mask | None:
        """Return which vehicles are not in the frame, (n,); None if all are."""
        dropout, missing = self._now.get("dropout"), self._now.get("missing")
        if dropout is None or missing is None:
            either = dropout or missing
            return None if either is None else either[0]
        return dropout[0] | missing[0]
