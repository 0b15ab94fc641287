"""Signals of every kind, and bags of them."""

from pathlib import Path

import numpy as np

from q2q_model.bag import BagWriter
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.values import Names

PAIR = ("cf1", "cf2")
MOCAP = "q2q_msgs/msg/MocapFrame"
"""Type of frames in a bag."""
STEP_NS = 10_000_000


def random_signal(kind: type[Signal], tick: int, names: Names, rng: np.random.Generator) -> Signal:
    """Return a signal of a kind with random arrays at the tick's stamp."""
    n = len(names)
    arrays = {
        column.attribute: rng.integers(0, 3, n).astype(np.uint8)
        if column.attribute == "status"
        else rng.normal(size=(n,) if column.width == 1 else (n, column.width))
        for column in LAYOUTS[kind].columns
    }
    return kind(t=tick * STEP_NS * 1e-9, names=names, **arrays)


def same_signal(a: Signal, b: Signal) -> bool:
    """Return whether two signals are equal to the last digit, NaN equal to NaN."""
    if type(a) is not type(b) or a.t != b.t or a.names != b.names:
        return False
    pairs = [(getattr(a, c.attribute), getattr(b, c.attribute)) for c in LAYOUTS[type(a)].columns]
    return all(np.array_equal(one, two, equal_nan=one.dtype != np.uint8) for one, two in pairs)


def write_bag(
    path: Path, ticks: int, kinds: dict[str, type[Signal]], seed: int = 0
) -> dict[str, list[Signal]]:
    """Write a bag of random signals of two vehicles; return them by topic."""
    rng = np.random.default_rng(seed)
    written: dict[str, list[Signal]] = {topic: [] for topic in kinds}
    with BagWriter(path) as bag:
        for tick in range(ticks):
            for topic, kind in kinds.items():
                written[topic].append(random_signal(kind, tick, PAIR, rng))
                bag.write_signal(topic, tick * STEP_NS, written[topic][-1])
    return written
