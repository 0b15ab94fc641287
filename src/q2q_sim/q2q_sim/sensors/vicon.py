"""Motion capture: 100 frames per second with noise, outliers, dropouts, flips and swaps.

Effects on a frame, applied in this order, each from its own random stream:

| effect | what the frame shows | injected flag |
|---|---|---|
| noise | position off by 0.15 mm rms, attitude by a few mrad | - |
| flip | body turned half a turn about x, y or z: reflections | FLIP |
| swap | poses of the vehicle and its nearest neighbour exchanged | SWAP |
| outlier | position off by a step in a random direction, one frame | OUTLIER |
| stale | the frame before the burst repeated under new stamps, all vehicles | STALE |
| dropout, missing | vehicle absent from the frame for 0.1-0.3 s, or for seconds | DROPOUT |

The first frame says which vehicle is which: no swap begins in it. Rates and sizes are those that Crazyswarm
users report (docs and issue trackers); VICON's static noise is 0.15 mm. `injected` lists the effects on the
last frame, for tests only. The camera's latency is not modelled here: a controller knows only stamps, so late
frames and late commands are equivalent, and the room adds both delays to the radio's (q2q_sim.loop.room).
"""

import math
from dataclasses import dataclass
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.geometry.rotations import quat_multiply
from q2q_model.signals.values import Array, Mask, MocapFrame, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_sim.random_streams import DrawnAhead, stream
from q2q_sim.sensors.episodes import Episodes, Frequency


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

_SMALL_ANGLE = 1e-8
"""Below this sin(x)/x is 1 to the last digit [rad]."""


@dataclass(frozen=True, slots=True)
class ViconParams:
    """Noise, dropout and outliers of motion capture; the defaults are perfect."""

    latency: float = tunable(0.0, "exposure to frame at the computer", unit="s", low=0.0, high=0.5)
    pos_noise: float = tunable(0.0, "standard deviation of position", unit="m", low=0.0, high=0.1)
    angle_noise: float = tunable(0.0, "standard deviation of attitude", unit="rad", low=0.0, high=0.5)
    outlier_rate: float = tunable(0.0, "outliers per vehicle", unit="1/s", low=0.0, high=100.0)
    outlier_min: float = tunable(0.2, "smallest outlier", unit="m", low=0.0, high=100.0)
    outlier_max: float = tunable(2.0, "largest outlier", unit="m", low=0.0, high=100.0)
    dropout_rate: float = tunable(0.0, "dropouts a vehicle", unit="1/s", low=0.0, high=10.0)
    dropout_min: float = tunable(0.1, "shortest dropout", unit="s", low=0.0, high=10.0)
    dropout_max: float = tunable(0.3, "longest dropout", unit="s", low=0.0, high=10.0)
    missing_rate: float = tunable(0.0, "long absences a vehicle", unit="1/s", low=0.0, high=10.0)
    missing_min: float = tunable(1.0, "shortest long absence", unit="s", low=0.0, high=100.0)
    missing_max: float = tunable(3.0, "longest long absence", unit="s", low=0.0, high=100.0)
    flip_rate: float = tunable(0.0, "axis flips a vehicle", unit="1/s", low=0.0, high=10.0)
    flip_max: float = tunable(0.05, "longest axis flip", unit="s", low=0.0, high=10.0)
    swap_rate: float = tunable(0.0, "marker swaps a vehicle", unit="1/s", low=0.0, high=10.0)
    swap_max: float = tunable(0.1, "longest marker swap", unit="s", low=0.0, high=10.0)
    stale_rate: float = tunable(0.0, "bursts of stale frames", unit="1/s", low=0.0, high=10.0)
    stale_max: float = tunable(0.1, "longest stale burst", unit="s", low=0.0, high=10.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)
        for name in ("outlier", "dropout", "missing"):
            low, high = (getattr(self, f"{name}_{end}") for end in ("min", "max"))
            if low > high:
                raise ValueError(f"ViconParams.{name}_min = {low} is above {name}_max = {high}")


class Vicon:
    """Motion capture from true states to frames, one per tick."""

    def __init__(self, params: ViconParams, vehicles: int, tick: float, seed: int) -> None:
        """Observe `vehicles` vehicles every `tick` [s]."""
        self._params = params
        self._rng = {name: stream(seed, f"vicon {name}") for name in ("flip axis", "outlier size")}
        self._noise = DrawnAhead(stream(seed, "vicon noise").standard_normal, (2, vehicles, 3))
        self._happens = [
            (name, Episodes(often, 1 if name == "stale" else vehicles, tick, stream(seed, f"vicon {name}")))
            for name, often in _frequencies(params).items()
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


@compiled
def add_noise(
    truth: tuple[Array, Array], noise: Array, sizes: tuple[float, float], pos: Array, quat: Array
) -> None:
    """Write noisy poses; the attitude is turned by exp of a rotation vector (q2q_model.geometry.rotations).

    Args:
        truth: pos, quat.
        noise: standard normal deviates, (2, n, 3).
        sizes: standard deviations [m], [rad].
        pos: written, (n, 3).
        quat: written, (n, 4).
    """
    true_pos, true_quat = truth
    for i in range(true_pos.shape[0]):
        squared = 0.0
        for k in range(3):
            pos[i, k] = true_pos[i, k] + sizes[0] * noise[0, i, k]
            squared += (sizes[1] * noise[1, i, k]) ** 2
        angle = math.sqrt(squared)
        scale = sizes[1] * (0.5 if angle < _SMALL_ANGLE else math.sin(0.5 * angle) / angle)
        a, b, c, d = (
            scale * noise[1, i, 0],
            scale * noise[1, i, 1],
            scale * noise[1, i, 2],
            math.cos(0.5 * angle),
        )
        x, y, z, w = true_quat[i, 0], true_quat[i, 1], true_quat[i, 2], true_quat[i, 3]
        quat[i, 0] = w * a + x * d + y * c - z * b
        quat[i, 1] = w * b + y * d + z * a - x * c
        quat[i, 2] = w * c + z * d + x * b - y * a
        quat[i, 3] = w * d - x * a - y * b - z * c


def _frequencies(params: ViconParams) -> dict[str, Frequency]:
    return {
        "flip": Frequency(params.flip_rate, 0.0, params.flip_max),
        "swap": Frequency(params.swap_rate, 0.0, params.swap_max),
        "outlier": Frequency(params.outlier_rate),
        "stale": Frequency(params.stale_rate, 0.0, params.stale_max),
        "dropout": Frequency(params.dropout_rate, params.dropout_min, params.dropout_max),
        "missing": Frequency(params.missing_rate, params.missing_min, params.missing_max),
    }
