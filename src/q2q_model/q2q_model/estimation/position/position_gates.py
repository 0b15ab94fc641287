"""Gates of a position sample, with the thresholds of q2q_model.estimation.association.outlier_thresholds.

A sample r of a vehicle last measured at p, tau ago, and predicted at p- with variance S is accepted if it
passes every gate:

| gate | condition |
|---|---|
| room | max abs r <= pos_max |
| velocity | abs(r - p) <= jump_max + speed_max tau |
| position | abs(r - c) <= jump_max + GATE_SIGMAS sqrt(S), c: nearest to r on the line from 2 p - p- to p- |
| lost | tau <= coast_s |
| repeat | the pose differs from all recent ones, unless the vehicle is at rest and there is no noise |

The position gate spans a line, because a vehicle that hits the ground is stopped on its way or thrown back,
with no more speed than it came with: a tenth of a second after the last sample, it may be 2 v tau short of
its prediction. At 100 Hz that is 2 cm at 1 m/s.

A pose that equals a recent one bit for bit is an old one with a new stamp if one of these holds:

- the vehicle should have moved by more than REPEAT_STEP since the pose first came;
- the pose fails another gate, and is not where another vehicle stands (exchanged_repeats);
- noise has kept VARIED poses apart.

A motion capture server that has lost a body may send its last pose again and again. Such poses are no
samples until the track is lost; where there is noise, until frozen_reacquire_s after the last sample. Good
poses repeat where a vehicle stands in a simulator without noise, and where they are rounded to millimetres;
above 0.05 m/s none of these comes three times.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.association.outlier_thresholds import REPEAT_STEP
from q2q_model.estimation.position.track_columns import TrackColumns
from q2q_model.signals.values import Array, Mask

GATE_SIGMAS = 1.0
"""Width of the position gate beyond jump_max in standard deviations of the prediction: after a dropout an
outlier does more harm than the short delay of reacquisition."""

REPEATS_S = 0.02
"""Time for which the velocity of a track shows how far a vehicle has moved under a pose that repeats [s]:
two ticks; each of its samples slows the track."""


SLOW = 0.2
"""Speed below which a pose may repeat [m/s]: REPEAT_STEP in a tick of 100 Hz."""
SMOOTH = 1e-5
"""Distance of a sample from its prediction below which no noise has moved it [m]: that of VICON is 0.15 mm at
rest; 0.1 m/s^2 move a vehicle by 5 um within a tick."""
GRID = 1e-4
"""Steps in which samples are rounded that may repeat in spite of noise [m]."""
ON_GRID = 0.01
"""Part of a step by which a rounded sample may be off: 1 um, the resolution of float32 at 8 m."""
VARIED = 20
"""Noisy samples in a row after which a pose should not repeat: 0.2 s at 100 Hz."""


class PositionGates(NamedTuple):
    """Gates of every vehicle at one tick."""

    last: Array
    """Position at the last sample p [m], (n, 3)."""
    moved: Array
    """Movement to the last sample since its pose first came, at most REPEATS_S ago [m], (n, 3)."""
    expected: Array
    """Predicted position p- [m], (n, 3)."""
    reach: Array
    """Largest accepted distance from p [m], (n,)."""
    deviation: Array
    """Largest accepted distance from the line of the position gate [m], (n,)."""
    lost: Mask
    """Tracks without a sample for longer than coast_s, (n,)."""
    varies: Mask
    """Vehicles whose poses do not repeat, as noise keeps them apart, (n,); none after frozen_reacquire_s."""
    pos_max: float
    """[m]"""


@compiled
def screen(measured: Array, repeated: Mask, gates: PositionGates) -> tuple[Array, Mask, Mask]:
    """Return the samples, (n, 3), which of them pass, (n,), and which vehicles' poses are frozen, (n,).

    Samples outside the room or of old frames are NaN.

    Args:
        measured: Positions [m], (n, 3); NaN where absent.
        repeated: Poses that equal a recent one bit for bit, (n,).
        gates: Gates of this tick.
    """
    samples, (passed, frozen) = measured.copy(), np.empty((2, len(measured)), np.bool_)
    for i in range(len(measured)):
        passed[i] = _passes(measured[i], i, gates)
        stale = repeated[i] and _stale(passed[i], i, gates)
        frozen[i] = stale and gates.varies[i]
        if stale or _outside(measured[i], gates.pos_max):
            samples[i], passed[i] = np.nan, False
    return samples, passed, frozen


@compiled
def _passes(sample: Array, i: int, gates: PositionGates) -> bool:
    return bool(
        not gates.lost[i]
        and _distance_squared(sample, gates.last[i]) <= gates.reach[i] ** 2
        and _from_line_squared(sample, gates.last[i], gates.expected[i]) <= gates.deviation[i] ** 2
    )


@compiled
def _outside(sample: Array, pos_max: float) -> bool:
    return bool(abs(sample[0]) > pos_max or abs(sample[1]) > pos_max or abs(sample[2]) > pos_max)


@compiled
def _stale(passed: bool, i: int, gates: PositionGates) -> bool:
    """Return whether a repeated pose is an old one with a new stamp."""
    if gates.lost[i]:
        return bool(gates.varies[i])
    moves = False
    for k in range(3):
        step = gates.moved[i, k] + gates.expected[i, k] - gates.last[i, k]
        moves = moves or abs(step) > REPEAT_STEP
    return bool(moves or gates.varies[i] or not passed)


@compiled
def count_varied(tracks: TrackColumns, i: int, sample: tuple[Array, Array], repeated: bool) -> None:
    """Count a sample that noise moved off its prediction while the vehicle was slow.

    The count begins again where a pose repeats, and where it is rounded, or as predicted, while it is slow.

    Args:
        tracks: Of all vehicles.
        i: The vehicle.
        sample: Position and its prediction [m], (3,) each.
        repeated: Whether the pose equals a recent one bit for bit.
    """
    off_squared = speed_squared = 0.0
    for k in range(3):
        off_squared += (sample[0][k] - sample[1][k]) ** 2
        speed_squared += tracks.state[i, 1, k] ** 2
    slow = speed_squared < SLOW * SLOW
    smooth = off_squared < SMOOTH * SMOOTH or _is_rounded(sample[0])
    if repeated or (slow and smooth):
        tracks.varied[i] = 0
    elif slow:
        tracks.varied[i] += 1


@compiled
def _is_rounded(sample: Array) -> bool:
    """Return whether all coordinates (3,) [m] are multiples of GRID."""
    for k in range(3):
        steps = sample[k] / GRID
        if abs(steps - round(steps)) > ON_GRID:
            return False
    return True


@compiled
def _from_line_squared(sample: Array, last: Array, expected: Array) -> float:
    """Return the squared distance [m^2] of a sample (3,) from the line of the position gate."""
    along, length_squared = 0.0, _distance_squared(expected, last)
    for k in range(3):
        along += (expected[k] - sample[k]) * (expected[k] - last[k])
    if not along > 0.0:  # at the end or beyond it, or no number
        return _distance_squared(sample, expected)
    back = min(along / length_squared, 2.0)
    squared = 0.0
    for k in range(3):
        squared += (sample[k] - expected[k] + back * (expected[k] - last[k])) ** 2
    return squared


@compiled
def _distance_squared(one: Array, other: Array) -> float:
    return float((one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2 + (one[2] - other[2]) ** 2)
