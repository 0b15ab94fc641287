"""Say what to command when the inputs of a tick do not come: hold, then level, then nothing.

| age of the last answered tick | command | status |
|---|---|---|
| up to hold_s | none of ours: the tick is still expected | |
| hold_s to level_s | the last command again | HOLD |
| level_s to silent_s | level attitude, hover thrust | LEVEL |
| above | nothing: the firmware's watchdog levels out (0.5 s) and cuts the motors (2 s) | |
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.parameters import check_bounds, tunable
from q2q_model.signals import CommandStatus, SwarmCommand


@dataclass(frozen=True, slots=True)
class FallbackParams:
    """Hold the ages at which the fallback changes."""

    hold_s: float = tunable(0.03, "age from which the last command is repeated", unit="s", low=0.0, high=1.0)
    level_s: float = tunable(0.10, "age from which level hover is commanded", unit="s", low=0.0, high=1.0)
    silent_s: float = tunable(0.40, "age from which nothing is sent", unit="s", low=0.0, high=10.0)

    def __post_init__(self) -> None:
        """Refuse values out of bounds or out of order."""
        check_bounds(self)
        if not self.hold_s <= self.level_s <= self.silent_s:
            raise ValueError(
                f"hold_s {self.hold_s}, level_s {self.level_s}, silent_s {self.silent_s}: these must rise"
            )


def fallback_command(
    last: SwarmCommand, age: float, params: FallbackParams, hover_thrust: float
) -> SwarmCommand | None:
    """Return what to send `age` seconds after the last answered tick; None where nothing is due.

    Args:
        last: the last tick's command.
        age: time since that tick was answered [s].
        params: ages of the states.
        hover_thrust: thrust that carries one vehicle [N].
    """
    if age < params.hold_s or age >= params.silent_s:
        return None
    if age < params.level_s:
        return replace(last, t=last.t + age, status=_all(last, CommandStatus.HOLD))
    zero = np.zeros(len(last.names))
    return SwarmCommand(
        t=last.t + age,
        names=last.names,
        thrust=np.full(len(last.names), hover_thrust),
        roll=zero,
        pitch=zero,
        yaw_rate=zero,
        status=_all(last, CommandStatus.LEVEL),
    )


def _all(last: SwarmCommand, status: CommandStatus) -> np.ndarray[tuple[int], np.dtype[np.uint8]]:
    return np.full(len(last.names), status, dtype=np.uint8)
