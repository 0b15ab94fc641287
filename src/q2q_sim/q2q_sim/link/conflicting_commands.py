"""Vehicles that two controllers command: for one tick they get commands that differ.

A controller answers a tick once, or again with the same numbers. The exceptions are single: an emergency cuts
what its tick has commanded. So a vehicle has two controllers from TWICE such ticks between two looks on.
"""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from q2q_model.counted import listed
from q2q_model.signals.values import Names, SwarmCommand

RECENT = 32
"""Ticks whose commands are remembered: one controller may answer some ticks later than the other."""
TWICE = 2
"""Ticks with commands that differ."""


class ConflictingCommands:
    """Commands of the recent ticks, and in how many of them each vehicle got two since the last look."""

    def __init__(self) -> None:
        self._recent: dict[int, dict[Names, SwarmCommand]] = {}  # by stamp [ns] and vehicles
        self._conflicts: Counter[str] = Counter()

    @property
    def commanded(self) -> Names:
        """Return the vehicles that the commands of the recent ticks name, sorted."""
        return tuple(sorted({name for tick in self._recent.values() for names in tick for name in names}))

    def take(self, stamp_ns: int, command: SwarmCommand) -> None:
        """Take the command of a stamp [ns]."""
        earlier = self._recent.setdefault(stamp_ns, {})
        for one in earlier.values():
            self._conflicts.update(_at_odds(one, command))
        earlier[command.names] = command
        if len(self._recent) > RECENT:
            del self._recent[next(iter(self._recent))]

    def take_conflicts(self) -> Names:
        """Return the vehicles that two controllers have commanded since the last call, sorted."""
        conflicts = tuple(sorted(name for name, ticks in self._conflicts.items() if ticks >= TWICE))
        self._conflicts.clear()
        return conflicts


def conflict_note(vehicles: Names, writers: Sequence[str]) -> str:
    """Return what to do about vehicles that two writers of `command` fly; empty for fewer writers."""
    if len(writers) < 2:
        return ""
    what = f"command: two nodes fly {listed(vehicles)}: stop one, or give each its own `vehicles`"
    return f"{what} ({listed(writers)} write it)"


def _at_odds(one: SwarmCommand, other: SwarmCommand) -> list[str]:
    """Return the vehicles to which two commands give different orders."""
    if set(one.names).isdisjoint(other.names):
        return []
    these, those = _orders(one), _orders(other)
    return [name for name in these.keys() & those.keys() if these[name] != those[name]]


def _orders(command: SwarmCommand) -> dict[str, tuple[float, ...]]:
    """Return what a command orders each vehicle: thrust, roll, pitch, yaw rate."""
    values = np.stack([command.thrust, command.roll, command.pitch, command.yaw_rate], axis=1)  # (n, 4)
    return dict(zip(command.names, map(tuple, values.tolist()), strict=True))
