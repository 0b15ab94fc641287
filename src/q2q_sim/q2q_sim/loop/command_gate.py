"""Commands of a tick, joined from one controller for all vehicles or from several for some each."""

from collections.abc import Sequence

import numpy as np

from q2q_model.counted import listed
from q2q_model.signals.values import Names, SwarmCommand


class CommandGate:
    """Collector of a tick's commands: from one controller for all vehicles, or from one for each."""

    def __init__(self, names: Names, *, exact: bool = True) -> None:
        """Take the vehicles; `exact` accepts only the awaited tick's commands, else all newer ones."""
        self._names, self._known = names, frozenset(names)
        self._exact = exact
        self._stamp_ns = 0
        self._done_ns: dict[str, int] = {}
        self._rows: dict[str, tuple[SwarmCommand, int]] = {}

    def expect(self, stamp_ns: int) -> None:
        """Wait for the commands of this tick; drop those collected for others.

        A command that was stamped ahead of its tick, by a controller whose clock went on while the room
        stood, counts as stamped at the tick: those of the following ticks are newer.
        """
        past_ns = min(self._stamp_ns, stamp_ns)  # stamps of frames may be set back
        if max(self._done_ns.values(), default=past_ns) > past_ns:
            self._done_ns = {name: min(done_ns, past_ns) for name, done_ns in self._done_ns.items()}
        self._stamp_ns = stamp_ns
        self._rows.clear()

    def offer(self, stamp_ns: int, command: SwarmCommand) -> SwarmCommand | None:
        """Add a command; return the swarm's command when complete, None before that and for other ticks.

        Rows of vehicles that do not exist are left out, as `radio` and `crazyswarm` do.

        Raises:
            ValueError: the command names only vehicles that do not exist.
        """
        if self._exact and command.names == self._names:
            return command if stamp_ns == self._stamp_ns else None
        known = {name: row for row, name in enumerate(command.names) if name in self._known}
        if command.names and not known:
            raise ValueError(unknown_vehicles(command.names, self._names))
        rows = {name: row for name, row in known.items() if self._accepts(name, stamp_ns)}
        self._rows |= {name: (command, row) for name, row in rows.items()}
        self._done_ns |= dict.fromkeys(rows, stamp_ns)
        return self.arrived() if rows and len(self._rows) == len(self._names) else None

    def stamp_of(self, command: SwarmCommand, stamp_ns: int) -> int:
        """Return the oldest stamp in a complete command that one of `stamp_ns` completed [ns]."""
        return min((self._done_ns.get(name, stamp_ns) for name in command.names), default=stamp_ns)

    def arrived(self) -> SwarmCommand | None:
        """Return the commands collected since `expect`, of some vehicles or all; None if there are none."""
        names = tuple(name for name in self._names if name in self._rows)
        return _gathered(names, self._rows) if names else None

    def missing(self) -> Names:
        """Return the vehicles without a command since `expect`."""
        return tuple(name for name in self._names if name not in self._rows)

    def _accepts(self, name: str, stamp_ns: int) -> bool:
        return stamp_ns == self._stamp_ns if self._exact else stamp_ns > self._done_ns.get(name, -1)


def joined_command(names: Names, commands: Sequence[SwarmCommand]) -> SwarmCommand:
    """Return the command of the vehicles `names` from those of controllers of some vehicles each."""
    return _gathered(
        names, {name: (one, row) for one in commands for row, name in enumerate(one.names) if name in names}
    )


def unknown_vehicles(commanded: Names, names: Names) -> str:
    """Return which commanded vehicles do not exist, and which do; empty if all exist."""
    unknown = sorted(set(commanded).difference(names))
    return (
        f"command for unknown vehicle {listed(unknown)}; the vehicles are {listed(names)}" if unknown else ""
    )


def _gathered(names: Names, rows: dict[str, tuple[SwarmCommand, int]]) -> SwarmCommand:
    first = rows[names[0]][0]
    if first.names == names:
        return first
    picked = [rows[name] for name in names]
    return SwarmCommand(
        t=first.t,
        names=names,
        thrust=np.array([command.thrust[row] for command, row in picked]),
        roll=np.array([command.roll[row] for command, row in picked]),
        pitch=np.array([command.pitch[row] for command, row in picked]),
        yaw_rate=np.array([command.yaw_rate[row] for command, row in picked]),
        status=np.array([command.status[row] for command, row in picked], dtype=np.uint8),
    )
