"""Description of vehicles whose motors are locked, by what commands have come for them."""

from q2q_model.counted import listed
from q2q_model.signals.values import Names

_LOCKED = "motors locked (at the start, or after 2 s without a command) until a command has no thrust"
_TOO_EARLY = (
    'start the simulator with -p starts_after:="[mocap_filter, pid]", the nodes to wait for, or with '
    "autostart:=false and call ~/start"
)


class LockedMotors:
    """Vehicles that commands have named."""

    def __init__(self) -> None:
        self._commanded: set[str] = set()

    def take(self, names: Names) -> None:
        """Take the vehicles of a command."""
        self._commanded.update(names)

    def note(self, locked: Names) -> str:
        """Return which motors are locked, why, and what to do; empty for none."""
        if not locked:
            return ""
        if not self._commanded:
            return f"{listed(locked)}: {_LOCKED}: no command has come: {_TOO_EARLY}"
        unnamed = tuple(name for name in locked if name not in self._commanded)
        named = tuple(name for name in locked if name in self._commanded)
        late = f"restart this node for another flight; if commands came too late, {_TOO_EARLY}"
        found = (
            f"no command names {listed(unnamed)}: check that the plan and the controller's `vehicles` do",
            f"{listed(named)}: {_LOCKED}: {late}",
        )
        return "; ".join(text for text, names in zip(found, (unnamed, named), strict=True) if names)
