"""Faults drawn at random: the lengths and sizes of each kind, and faults at random times of a flight."""

from collections.abc import Iterable, Mapping

import numpy as np

from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Names
from q2q_sim.faults.faults import KINDS, Fault
from q2q_sim.random_streams import stream

LENGTHS: Mapping[str, tuple[float, float]] = {
    "outlier": (0.0, 0.1), "jump": (0.5, 3.0), "flip": (0.0, 0.1), "swap": (0.02, 0.2),
    "dropout": (0.1, 1.0), "nan": (0.0, 0.2), "stale": (0.02, 0.2), "repeated": (0.02, 0.2),
    "late": (0.05, 1.0), "reordered": (0.1, 1.0), "clock_jump": (0.05, 1.0), "radio_loss": (0.05, 0.4),
    "battery_sag": (2.0, 10.0), "weak_rotor": (0.1, 5.0),
}  # fmt: skip
"""Durations of random faults [s]: from reports of rooms, up to what a vehicle should survive."""
SIZES: Mapping[str, tuple[float, float]] = {
    "outlier": (0.05, 5.0), "jump": (0.05, 0.5), "late": (0.02, 0.1), "clock_jump": (-0.5, 0.5),
    "radio_loss": (0.3, 1.0), "battery_sag": (0.02, 0.15), "weak_rotor": (0.02, 0.1),
}  # fmt: skip
"""Sizes of random faults, in the units of their kinds."""


def earliest_start(kind: str) -> float:
    """Return the earliest start of a random fault [s]: the first frame says which vehicle is which."""
    return TICK_S if kind == "swap" else 0.0


def kinds_among(kinds: Iterable[str], names: Names) -> list[str]:
    """Return those of some kinds that may act on vehicles `names`: a swap takes two."""
    return [kind for kind in kinds if kind != "swap" or len(names) > 1]


def random_faults(seed: int, names: Names, duration: float, count: int) -> tuple[Fault, ...]:
    """Return `count` faults of random kinds at random times of a flight of `duration` [s]."""
    rng = stream(seed, "random faults")
    kinds = kinds_among(KINDS, names)
    return tuple(_random_fault(str(rng.choice(kinds)), names, duration, rng) for _ in range(count))


def _random_fault(kind: str, names: Names, duration: float, rng: np.random.Generator) -> Fault:
    chosen = rng.permutation(len(names))[: 2 if kind == "swap" else 1]
    return Fault(
        kind=kind,
        start=max(float(rng.uniform(0.0, duration)), earliest_start(kind)),
        duration=float(rng.uniform(*LENGTHS[kind])),
        vehicles=() if KINDS[kind].whole_frame else tuple(names[i] for i in chosen),
        size=float(rng.uniform(*SIZES[kind])) if kind in SIZES else 0.0,
    )
