"""What breaks a rule of a licence, and the tick at which it first did."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Mask
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.rules.licence_causes import failure_cause


@dataclass(frozen=True, slots=True)
class BrokenRule:
    """Broken rule."""

    rule: str
    t: float
    """[s]; 0 if nobody knows, as the process ended without a log."""
    what: str
    """What the vehicle or the program does."""
    why: str = ""
    remark: bool = False
    """It fails no flight: a vehicle that lost its link stays where it is, and others fly on as planned."""

    @property
    def sentence(self) -> str:
        """Return when, what, and why."""
        when = f"at {self.t:.2f} s " if self.t else ""
        why = f": {self.why}" if self.why else ""
        said = f"{when}{self.what}{why}"
        return f"remark: {said}" if self.remark else said


def first_tick(broken: Mask) -> int:
    """Return the first tick at which a condition (T,) holds; -1 if it never does."""
    return int(np.argmax(broken)) if broken.any() else -1


def first_lasting_tick(broken: Mask, ticks: int) -> int:
    """Return the first tick from which a condition (T,) holds for so many ticks; -1 if it never does."""
    if len(broken) < ticks:
        return -1
    return first_tick(np.asarray(np.convolve(broken, np.ones(ticks), mode="valid") >= ticks))


def broken_at(
    log: LicenceLog, row: int, rule: str, tick: int, what: Callable[[int], str]
) -> BrokenRule | None:
    """Return the rule that a vehicle breaks at a tick, and why; None if the tick is -1 (first_tick)."""
    if tick < 0:
        return None
    t = float(log.t[tick])
    return BrokenRule(rule, t, what(tick), failure_cause(log, row, t))
