"""Fingerprint of a flight's motion, by which parts of it are recognised in other flights.

Each window of ROWS successive steps of a vehicle's position, in units of STEP, has a hash; one of ONE_KEPT_IN
is kept, 0 modulo that number (Manber, Finding similar files in a large file system, USENIX 1994), so that the
same motion gives the same hashes wherever it begins. Stamps, names, the origin and the order of vehicles are
not in them. The noise of measured positions differs between flights: of the 23 public ones, which have
decimals of 0.1 mm, no two share a window.
"""

from base64 import b64decode, b64encode

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Mask

ROWS = 32
"""Steps of a window: 0.3 s at 100 Hz."""
STEP = 1e-4
"""Unit of a step [m]: the noise of motion capture. Of noise of 1 mm, rounding to single precision leaves
97 % of the windows and rounding to 1 um 61 %; with steps of 10 um 75 % and 1 %."""
DISTINCT = 16
"""Fewest different steps of a window: one of rest or of constant velocity is the same in many flights."""
ONE_KEPT_IN = 128
"""One window of so many is kept: about three in 4 s of a vehicle at 100 Hz."""
WINDOWS_MAX = 512
"""Most windows kept for a flight, those of the smallest hashes: 2 kB as text."""
SHARE_MIN = 0.25
"""Share of the windows of every vehicle of a flight from which on another flight holds its motion. One
vehicle of several is not enough: in a simulator that records no truth, some may fly alike."""
FEWEST_SHARED = 2
"""Fewest windows in common; one may be chance: hashes have 24 bits."""

Windows = tuple[frozenset[int], ...]
"""Hashes of the windows kept of every vehicle that has any."""
Words = NDArray[np.uint64]
_AXES = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
_FACTOR = np.uint64(0x94D049BB133111EB)
_MIX = np.uint64(0xBF58476D1CE4E5B9)
"""Odd numbers of random bits, of SplitMix64 (Steele, Lea, Flood, 2014) and, for y and z, xxHash (Collet)."""


def motion_windows(pos: Array) -> Windows:
    """Return the hashes of the windows kept of positions [m], (T, n, 3); NaN where a vehicle is not seen."""
    found = [frozenset(_windows_of_vehicle(pos[:, k]).tolist()) for k in range(pos.shape[1])]
    kept = frozenset(sorted(frozenset().union(*found))[:WINDOWS_MAX])
    return tuple(one & kept for one in found if one & kept)


def hold_same_motion(one: Windows, other: Windows) -> bool:
    """Return whether the windows of two flights show that one holds a large part of the other."""
    return _holds(one, other) or _holds(other, one)


def as_text(windows: Windows) -> str:
    """Return windows as text."""
    return ",".join(
        b64encode(b"".join(value.to_bytes(3) for value in sorted(one))).decode() for one in windows
    )


def from_text(text: str) -> Windows:
    """Return the windows of `as_text`; none if the text is not such."""
    try:
        packed = [b64decode(one, validate=True) for one in text.split(",") if one]
    except ValueError:
        return ()
    return tuple(
        frozenset(int.from_bytes(one[k : k + 3]) for k in range(0, len(one) - 2, 3)) for one in packed
    )


def _holds(whole: Windows, part: Windows) -> bool:
    """Return whether the motion of every vehicle of `part` is in `whole`, as far as both keep its windows."""
    there, here = frozenset().union(*whole), frozenset().union(*part)
    if not there or not here:
        return False
    known = min(max(there), max(here))  # beyond it, one of the two may have more windows than it keeps
    counts = [(len(one & there), sum(value <= known for value in one)) for one in part]
    enough = all(shared >= SHARE_MIN * count for shared, count in counts)
    return enough and sum(shared for shared, _ in counts) >= FEWEST_SHARED


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
    kept = np.flatnonzero(whole & (hashes % np.uint64(ONE_KEPT_IN) == 0))
    parts = np.sort(words[kept[:, None] + np.arange(ROWS)], axis=1)
    varied = (np.diff(parts, axis=1) != 0).sum(axis=1) >= DISTINCT - 1
    return np.asarray(hashes[kept[varied]] >> np.uint64(40), dtype=np.int64)


def _mixed(words: Words) -> Words:
    """Return words whose bits depend on all bits of the given."""
    words = (words ^ (words >> np.uint64(29))) * _MIX
    return words ^ (words >> np.uint64(32))
