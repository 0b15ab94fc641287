"""Injection of faults into frames, packets and rotors, tick by tick.

Frames pass two stages. Capture faults change rows (outliers, jumps, flips, swaps, dropouts, NaN) and stamps.
Delivery faults choose which frame arrives in this tick. One frame arrives each tick: a late frame is an older
one, and a missing frame is the last one repeated with its stamp. Outliers and lost packets draw random
numbers, each from a stream of its own.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.geometry.rotations import quat_multiply
from q2q_model.signals.stamps import time_from_stamp
from q2q_model.signals.values import Array, Mask, MocapFrame, Names
from q2q_sim.faults.affected_vehicles import affected_vehicles
from q2q_sim.faults.faults import Fault
from q2q_sim.random_streams import stream
from q2q_sim.sensors.vicon import Flags, Injected

HALF_TURN_ABOUT_X = np.array([1.0, 0.0, 0.0, 0.0])
MARKS = {
    "outlier": Injected.OUTLIER,
    "jump": Injected.OUTLIER,
    "flip": Injected.FLIP,
    "swap": Injected.SWAP,
    "dropout": Injected.DROPOUT,
    "nan": Injected.NAN,
    "stale": Injected.STALE,
    "repeated": Injected.STAMP,
    "late": Injected.STAMP,
    "reordered": Injected.STAMP,
    "clock_jump": Injected.STAMP,
}
"""Mark of an affected row in `Room.injected`."""


@dataclass(frozen=True, slots=True)
class Delivery:
    """Frame that arrives in a tick."""

    frame: MocapFrame
    stamp_ns: int
    captured_ns: int
    """Capture time, by a clock that does not jump."""


class FaultInjection:
    """Faults of a flight, with the past frames that may be repeated."""

    def __init__(self, faults: Sequence[Fault], names: Names, tick_ns: int, seed: int) -> None:
        """Take the faults and the vehicles `names`; `tick_ns` is the sample time [ns]."""
        self._faults = tuple(faults)
        self._windows = [(*fault.window(time_from_stamp(tick_ns)), fault) for fault in faults]
        self._weakening = [fault for fault in faults if fault.kind in ("battery_sag", "weak_rotor")]
        self._names = names
        self._tick_ns = tick_ns
        self._rng = stream(seed, "fault outlier")
        self._loss = stream(seed, "fault radio loss")
        self._no_loss = np.zeros(len(names), dtype=np.bool_)  # ticks share it
        self._rows = {fault: affected_vehicles(fault, names) for fault in faults}
        self._now: tuple[int, list[Fault]] = -1, []  # stamp of a tick [ns], and the faults that act on it
        longest = max((fault.size for fault in faults if fault.kind == "late"), default=0.0)
        self._past: deque[Delivery] = deque(maxlen=round(longest * 1e9 / tick_ns) + 3)
        self._sent: Delivery | None = None

    def deliver(self, frame: MocapFrame, stamp_ns: int, injected: Flags) -> Delivery:
        """Return the frame that arrives in the tick at stamp_ns and mark the faults in `injected` (n,)."""
        here = Delivery(frame, stamp_ns, stamp_ns)
        if not self._faults:
            return here
        acting = self._acting(stamp_ns)
        for fault in sorted(acting, key=_renames):
            if fault.kind in MARKS:
                injected[self._rows[fault]] |= np.uint8(MARKS[fault.kind])
            here = replace(self._stamped(here, fault), frame=self._with_rows(here.frame, fault))
        self._past.append(here)
        for fault in acting:
            here = self._arriving(here, fault)
        stamped = time_from_stamp(here.stamp_ns)
        if here.frame.t != stamped:
            here = replace(here, frame=replace(here.frame, t=stamped))
        if self._sent is None or all(fault.kind != "stale" for fault in acting):
            self._sent = here
        return here

    def jammed(self, stamp_ns: int) -> Mask:
        """Return which vehicles lose their packet of this tick, (n,)."""
        lost = self._no_loss
        for fault in self._acting(stamp_ns) if self._faults else ():
            if fault.kind == "radio_loss":
                lost = lost | self._rows[fault] & (self._loss.random(len(lost)) < fault.size)
        return lost

    def weakened(self, drive: Array, stamp_ns: int) -> Array:
        """Return the drive (n, 7) with the rotor gains reduced by battery sag and weak rotors."""
        for fault in self._weakening:
            if fault.kind == "battery_sag":
                drive[self._rows[fault], 3:] *= 1.0 - fault.size * self._elapsed(fault, stamp_ns)
            elif fault in self._acting(stamp_ns):
                drive[self._rows[fault], 3] *= 1.0 - fault.size
        return drive

    def _acting(self, stamp_ns: int) -> list[Fault]:
        if self._now[0] != stamp_ns:
            t = time_from_stamp(stamp_ns)
            self._now = stamp_ns, [fault for begin, end, fault in self._windows if begin <= t < end]
        return self._now[1]

    def _elapsed(self, fault: Fault, stamp_ns: int) -> float:
        """Return the elapsed fraction of the fault's duration, 0 to 1."""
        since = time_from_stamp(stamp_ns) - fault.start
        return min(max(since / max(fault.duration, time_from_stamp(self._tick_ns)), 0.0), 1.0)

    def _with_rows(self, frame: MocapFrame, fault: Fault) -> MocapFrame:
        rows = affected_vehicles(fault, frame.names)
        pos, quat = frame.pos.copy(), frame.quat.copy()
        if fault.kind == "outlier":
            away = self._rng.standard_normal((len(self._names), 3))[: len(rows)]
            away *= fault.size / np.linalg.norm(away, axis=1, keepdims=True)
            pos[rows] += away[rows]
        elif fault.kind == "jump":
            pos[rows, 0] += fault.size
        elif fault.kind == "nan":
            pos[rows] = np.nan
        elif fault.kind == "flip":
            quat[rows] = quat_multiply(quat[rows], HALF_TURN_ABOUT_X)
        elif fault.kind == "swap":
            other = dict(zip(fault.vehicles, reversed(fault.vehicles), strict=True))
            return replace(frame, names=tuple(other.get(name, name) for name in frame.names))
        elif fault.kind == "dropout":
            kept = tuple(name for name, gone in zip(frame.names, rows, strict=True) if not gone)
            return replace(frame, names=kept, pos=pos[~rows], quat=quat[~rows])
        return replace(frame, pos=pos, quat=quat)

    def _stamped(self, here: Delivery, fault: Fault) -> Delivery:
        if fault.kind != "clock_jump":
            return here
        return replace(here, stamp_ns=max(here.stamp_ns + round(fault.size * 1e9), 0))

    def _arriving(self, here: Delivery, fault: Fault) -> Delivery:
        """Return the frame that a delivery fault substitutes for `here`."""
        last = self._sent or here
        if fault.kind == "stale":
            return replace(here, frame=last.frame)
        if fault.kind == "repeated":
            return last
        if fault.kind == "late":
            old = self._past[-1 - min(round(fault.size * 1e9 / self._tick_ns), len(self._past) - 1)]
            return old if old.captured_ns > last.captured_ns else last
        if fault.kind == "reordered" and (here.captured_ns // self._tick_ns) % 2 == 0:
            return self._past[-3] if len(self._past) > 2 else last
        return here


def _renames(fault: Fault) -> bool:
    """Return whether a fault exchanges names, which it does after the others have displaced bodies."""
    return fault.kind == "swap"
