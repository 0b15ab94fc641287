"""Downwash on vehicles without measurements: how much of the last known one is left.

Others above vehicle i were at offsets d_ij, horizontally, when its downwash was last known: predicted at its
place, or without a prediction part of its measured balance. What is left of it, as those move:

    share_i = mean_j exp(-|d_ij - d_ij(0)|^2 / W^2)       1 if nobody was above

A downwash is narrow, and an offset is dead-reckoned to a few centimetres: a vehicle that leaves it must not
be lifted any longer, as one that rises hits those above. Who comes above later is not known to push.

| symbol | name | meaning [unit] |
|---|---|---|
| W | WIDTH | width of a downwash [m] |
"""

from collections.abc import Collection, Mapping

import numpy as np

from q2q_model.signals.values import Array

WIDTH = 0.076
"""Offset that leaves 1/e of a downwash [m]: sqrt(2) of the 54 mm of the measured jet (q2q_model.downwash)."""
REACH = 0.3
"""Horizontal distance within which a vehicle above counts [m]: four widths."""


class FadingDownwash:
    """Offsets of those above vehicles without measurements, when their downwash was last known."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all offsets."""
        self._above: dict[str, dict[str, Array]] = {}

    def shares(
        self, blind: Collection[str], known: Collection[str], pos: Mapping[str, Array]
    ) -> dict[str, float]:
        """Return what is left of the downwash of the `blind` vehicles, from 0 to 1 by name.

        Args:
            blind: vehicles without measurements.
            known: those of them whose downwash is predicted where they are.
            pos: dead-reckoned and measured positions [m], world, (3,) by name.
        """
        above = {}
        for name in blind:
            now = _above(name, pos)
            above[name] = now if name in known else self._above.get(name, now)
        self._above = above
        return {name: _share(offsets, name, pos) for name, offsets in above.items()}


def _above(name: str, pos: Mapping[str, Array]) -> dict[str, Array]:
    """Return the horizontal offsets of those that may push a vehicle down [m], (2,) by name."""
    apart = {other: at - pos[name] for other, at in pos.items()}
    return {other: d[:2] for other, d in apart.items() if d[2] > 0.0 and np.hypot(d[0], d[1]) < REACH}


def _share(offsets: Mapping[str, Array], name: str, pos: Mapping[str, Array]) -> float:
    """Return what is left of the downwash on a vehicle, from 0 to 1."""
    if not offsets:
        return 1.0
    moved = [
        np.linalg.norm(pos[other][:2] - pos[name][:2] - offset) if other in pos else np.inf
        for other, offset in offsets.items()
    ]
    return float(np.exp(-np.square(np.array(moved) / WIDTH)).mean())
