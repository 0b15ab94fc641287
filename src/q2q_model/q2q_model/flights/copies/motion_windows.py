"""Fingerprint of a flight's motion, by which parts of it are recognised in other flights.

Each window of ROWS successive steps of a vehicle's position, in units of STEP, has a hash; those that are 0
modulo SPARSE are kept (Manber, Finding similar files in a large file system, USENIX 1994), so that the same
motion gives the same hashes wherever it begins. Stamps, names, the origin and the order of vehicles are not
in them, and rounding to single precision (0.1 um) changes one window in thirty. The noise of measured
positions differs between flights: of the 23 public ones no two share more than chance does, 0.3 % of all
windows.
"""

from base64 import b64decode, b64encode

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Mask

ROWS = 32
"""Steps of a window: 0.3 s at 100 Hz."""
STEP = 1e-4
"""Unit of a step [m]: the noise of motion capture, a thousand times the rounding of single precision."""
DISTINCT = 16
"""Fewest different steps of a window: one of rest or of constant velocity is the same in many flights."""
SPARSE = 128
"""One window of so many is kept: about three in 4 s of a vehicle at 100 Hz."""
MOST = 512
"""Most windows kept for a flight, those of the smallest hashes: 2 kB as text."""
SHARED = 0.25
"""Share of the windows of the shorter of two flights from which on they hold the same motion. Simulated
flights of one seed may begin with the same seconds."""
FEWEST_SHARED = 2
"""Fewest windows in common; one may be chance: hashes have 24 bits."""

Words = NDArray[np.uint64]
_AXES = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
_FACTOR = np.uint64(0x94D049BB133111EB)
_MIX = np.uint64(0xBF58476D1CE4E5B9)


def motion_windows(pos: Array) -> frozenset[int]:
    """Return the hashes of the windows kept of positions [m], (T, n, 3); NaN where a vehicle is not seen."""
    found = [one for k in range(pos.shape[1]) for one in _windows_of_vehicle(pos[:, k]).tolist()]
    return frozenset(sorted(set(found))[:MOST])


def hold_same_motion(one: frozenset[int], other: frozenset[int]) -> bool:
    """Return whether the windows of two flights show that one holds a large part of the other."""
    if not one or not other:
        return False
    known = min(max(one), max(other))  # beyond it, one of the two may have more windows than it keeps
    fewest = min(sum(value <= known for value in windows) for windows in (one, other))
    return len(one & other) >= max(FEWEST_SHARED, SHARED * fewest)


def as_text(windows: frozenset[int]) -> str:
    """Return windows as text."""
    return b64encode(b"".join(value.to_bytes(3) for value in sorted(windows))).decode()


def from_text(text: str) -> frozenset[int]:
    """Return the windows of `as_text`; none if the text is not such."""
    try:
        packed = b64decode(text, validate=True)
    except ValueError:
        return frozenset()
    return frozenset(int.from_bytes(packed[k : k + 3]) for k in range(0, len(packed) - 2, 3))


def _windows_of_vehicle(pos: Array) -> NDArray[np.int64]:
    """Return the hashes of the windows kept of one vehicle's positions [m], (T, 3)."""
    seen: Mask = np.asarray(np.isfinite(pos).all(axis=1))
    steps = np.rint(np.diff(np.where(seen[:, None], pos, 0.0), axis=0) / STEP).astype(np.int64)
    words = _mixed((steps.astype(np.uint64) * _AXES).sum(axis=1))
    count = words.size - ROWS + 1
    if count < 1:
        return np.empty(0, dtype=np.int64)
    total, factor = np.zeros(count, dtype=np.uint64), np.ones(1, dtype=np.uint64)
    for k in range(ROWS):
        total += factor * words[k : k + count]
        factor = factor * _FACTOR
    hashes = _mixed(total)
    unseen = np.concatenate([[0], np.cumsum(~seen)])
    whole = unseen[ROWS + 1 :] == unseen[:count]
    kept = np.flatnonzero(whole & (hashes % np.uint64(SPARSE) == 0))
    parts = np.sort(words[kept[:, None] + np.arange(ROWS)], axis=1)
    varied = (np.diff(parts, axis=1) != 0).sum(axis=1) >= DISTINCT - 1
    return np.asarray(hashes[kept[varied]] >> np.uint64(40), dtype=np.int64)


def _mixed(words: Words) -> Words:
    """Return words whose bits depend on all bits of the given."""
    words = (words ^ (words >> np.uint64(29))) * _MIX
    return words ^ (words >> np.uint64(32))
