"""Ages at which the fallback phases change (q2q_control.failsafe.fallback_phases)."""

from dataclasses import dataclass

from q2q_model.signals.clock_resets import CONFIRM_S
from q2q_model.tunable import check_bounds, tunable

LONGEST_HOLD_S = CONFIRM_S
"""Time for which a vehicle's last command is repeated before it levels [s], unless set otherwise: until old
stamps are known to be of a clock that was set back."""


@dataclass(frozen=True, slots=True)
class FallbackParams:
    """Ages at which the fallback phases change."""

    degraded_after_s: float = tunable(
        0.05,
        "age from which a state counts as predicted (DEGRADED)",
        unit="s",
        low=0.0,
        high=1.0,
        read_only=True,
    )
    hold_after_s: float = tunable(
        0.03,
        "live: time without a tick after which the last command is repeated (HOLD)",
        unit="s",
        low=0.0,
        high=1.0,
        read_only=True,
    )
    level_after_s: float = tunable(
        LONGEST_HOLD_S,
        "live: time without a tick after which vehicles brake, then hover level (LEVEL)",
        unit="s",
        low=0.0,
        high=1.0,
        read_only=True,
    )
    land_after_s: float = tunable(
        1.0,
        "age of a vehicle's state from which it is landed without measurements (LAND)",
        unit="s",
        low=0.1,
        high=60.0,
        read_only=True,
    )
    cut_after_s: float = tunable(
        5.0,
        "age of a vehicle's state from which its motors are off, until a new flight (CUT)",
        unit="s",
        low=0.1,
        high=120.0,
        read_only=True,
    )
    land_share: float = tunable(
        0.94,
        "thrust of a landing without measurements, as a fraction of hover thrust",
        low=0.5,
        high=1.0,
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Refuse values out of bounds or out of order."""
        check_bounds(self)
        if not self.hold_after_s <= self.level_after_s <= self.land_after_s <= self.cut_after_s:
            raise ValueError(
                f"hold_after_s {self.hold_after_s}, level_after_s {self.level_after_s}, "
                f"land_after_s {self.land_after_s}, cut_after_s {self.cut_after_s}; "
                "must satisfy hold_after_s <= level_after_s <= land_after_s <= cut_after_s"
            )
