"""Degradations of motion capture: which samples an estimator is given in a replay.

| condition | given |
|---|---|
| 100 Hz | all |
| 10 Hz | every tenth; which of ten is drawn |
| 30 % lost | each with a probability of 0.7 |
| 1 s away | none for 1 s in every 4 s, from a drawn time on |

Degradations begin SETTLED after take-off.
"""

from collections.abc import Callable, Mapping

import numpy as np

from q2q_model.signals.values import Mask
from q2q_sim.experiments.estimators.recorded_motion import RecordedMotion
from q2q_sim.firmware.estimator import DT
from q2q_sim.random_streams import stream

SETTLED = 1.0
"""[s]"""
AWAY, EVERY = 1.0, 4.0
"""Length and period of absences [s]."""
LOST = 0.3
"""Share of lost samples."""
UNDEGRADED = "100 Hz"

Pattern = Callable[[int, np.random.Generator], Mask]


def _all(ticks: int, _: np.random.Generator) -> Mask:
    return np.ones(ticks, dtype=np.bool_)


def _tenth(ticks: int, draw: np.random.Generator) -> Mask:
    return np.asarray((np.arange(ticks) + draw.integers(10)) % 10 == 0)


def _lost(ticks: int, draw: np.random.Generator) -> Mask:
    return np.asarray(draw.random(ticks) >= LOST)


def _away(ticks: int, draw: np.random.Generator) -> Mask:
    period = round(EVERY / DT)
    return np.asarray((np.arange(ticks) + draw.integers(period)) % period >= round(AWAY / DT))


CONDITIONS: Mapping[str, Pattern] = {UNDEGRADED: _all, "10 Hz": _tenth, "30 % lost": _lost, "1 s away": _away}
"""Condition -> given samples of a number of ticks."""


def given_samples(motion: RecordedMotion, condition: str, seed: int) -> Mask:
    """Return the samples given in a replay, (T,)."""
    ticks = len(motion.pos)
    degraded_from = int(np.argmax(motion.flying)) + round(SETTLED / DT)
    pattern = CONDITIONS[condition](ticks, stream(seed, f"{motion.name} {condition}"))
    return np.asarray(motion.seen & (pattern | (np.arange(ticks) < degraded_from)))
