"""Library of faults of a room and their times, for scenarios and campaigns.

| kind | effect on the named vehicles | size |
|---|---|---|
| outlier | position off in a new random direction each frame | distance [m] |
| jump | position off along x, the same each frame | distance [m] |
| flip | body turned half a turn about its x axis: a reflection | - |
| swap | the names of two vehicles exchanged | - |
| dropout | not in the frame (a long one: a vehicle silently missing) | - |
| nan | in the frame, position not a number | - |
| stale | the frame before the fault, under new stamps (all vehicles) | - |
| repeated | the frame before the fault, under its old stamp (all) | - |
| late | frames delayed, with their own stamps; the last one repeated until then (all) | delay [s] |
| reordered | every second frame arrives after its successor (all) | - |
| clock_jump | stamps shifted (all) | time [s] |
| radio_loss | packets lost | fraction of packets [-] |
| battery_sag | thrust falls linearly during the fault and stays low | fraction of thrust lost [-] |
| weak_rotor | rotor 1 gives less thrust | fraction of its thrust lost [-] |

A fault begins and ends at the ticks nearest to `start` and `start + duration`, half a tick early or late at
most, and acts on one at least; without named vehicles on all.
Faults of processes (a node killed or stopped) are not part of the room: test/process_faults.py.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Annotated

from q2q_model.nearest_name import name_hint
from q2q_model.signals.values import Names


@dataclass(frozen=True, slots=True)
class FaultKind:
    """Unit and bounds of the size of one kind of fault."""

    unit: str
    low: float = 0.0
    high: float = 0.0
    """Bounds of the size; both 0 if the kind has none."""
    whole_frame: bool = False
    """Acts on the whole frame, not on single vehicles."""


KINDS: Mapping[str, FaultKind] = {
    "outlier": FaultKind("m", 0.001, 100.0),
    "jump": FaultKind("m", -100.0, 100.0),
    "flip": FaultKind(""),
    "swap": FaultKind(""),
    "dropout": FaultKind(""),
    "nan": FaultKind(""),
    "stale": FaultKind("", whole_frame=True),
    "repeated": FaultKind("", whole_frame=True),
    "late": FaultKind("s", 0.01, 1.0, whole_frame=True),
    "reordered": FaultKind("", whole_frame=True),
    "clock_jump": FaultKind("s", -3600.0, 3600.0, whole_frame=True),
    "radio_loss": FaultKind("", 0.0, 1.0),
    "battery_sag": FaultKind("", 0.0, 1.0),
    "weak_rotor": FaultKind("", 0.0, 1.0),
}


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault."""

    kind: str
    start: float = 0.0
    """[s]"""
    duration: float = 0.0
    """[s]; 0 is one tick."""
    vehicles: Annotated[Names, "a list of names"] = ()
    """Empty for all."""
    size: float = 0.0
    """Meaning by kind, as in the table above."""

    def __post_init__(self) -> None:
        """Check the values; raise an error with the value and what is allowed."""
        if isinstance(self.vehicles, str):
            raise TypeError(f"fault {self.kind}: vehicles = {self.vehicles!r}; must be a list of names")
        object.__setattr__(self, "vehicles", tuple(self.vehicles))  # a list would have no hash
        if self.kind not in KINDS:
            raise ValueError(f"unknown fault {self.kind!r}; {name_hint(self.kind, KINDS)}")
        for name, value in (("start", self.start), ("duration", self.duration)):
            if not (isfinite(value) and value >= 0.0):
                raise ValueError(f"fault {self.kind}: {name} = {value}; must be at least 0 s")
        kind = KINDS[self.kind]
        if not kind.low <= self.size <= kind.high:
            bounds = f"in [{kind.low}, {kind.high}] {kind.unit}".rstrip()
            raise ValueError(f"fault {self.kind}: size = {self.size}; must be {bounds}")
        if self.kind == "swap" and not len(self.vehicles) == len({*self.vehicles}) == 2:
            raise ValueError(
                f"fault swap: vehicles = {list(self.vehicles)}: name exactly two different vehicles"
            )
        if kind.whole_frame and self.vehicles:
            raise ValueError(f"fault {self.kind} acts on whole frames: name no vehicles")

    def __str__(self) -> str:
        """Return kind, size with its unit, vehicles and time."""
        size = f" {self.size:.2g} {KINDS[self.kind].unit}".rstrip() if self.size else ""
        on = f" on {' '.join(self.vehicles)}" if self.vehicles else ""
        lasting = f" for {self.duration:.2f} s" if self.duration else ""
        return f"{self.kind}{size}{on} at {self.start:.1f} s{lasting}"

    def window(self, tick: float) -> tuple[float, float]:
        """Return begin and end of the times of the ticks on which the fault acts [s]; the end is outside."""
        early = 0.5 * tick  # stamps and starts are sums of floats
        return self.start - early, max(self.start + self.duration, self.start + tick) - early


def check_vehicles(faults: Sequence[Fault], names: Names) -> None:
    """Raise ValueError if a fault names a vehicle that is not in the flight."""
    for fault in faults:
        for name in fault.vehicles:
            if name not in names:
                raise ValueError(f"fault {fault.kind}: no vehicle {name!r}; choose one of {', '.join(names)}")


def check_sizes(faults: Sequence[Fault]) -> None:
    """Raise ValueError for a fault of size 0, whose kind has a size: it would do nothing."""
    for note in no_size_notes(faults):
        raise ValueError(note)


def no_size_notes(faults: Sequence[Fault]) -> list[str]:
    """Return notes on faults of size 0, whose kinds have a size."""
    sized = [(one.kind, KINDS[one.kind]) for one in faults if one.size == 0.0]
    return [
        f"fault {name}: size = 0 has no effect: give a size [{kind.unit or 'share'}]"
        for name, kind in sized
        if kind.low != kind.high
    ]


def late_fault_notes(faults: Sequence[Fault], duration: float) -> list[str]:
    """Return notes on faults that start after a flight of `duration` [s]."""
    late = [fault for fault in faults if fault.start >= duration]
    return [f"fault {one.kind} at {one.start:g} s is after the end, {duration:g} s" for one in late]
