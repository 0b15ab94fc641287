"""Violations of the policies: the worst of each vehicle or pair."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace

WORDS: Mapping[str, str] = {
    "separation": "{0.value:.4g} m apart (minimum {0.limit:.4g} m)",
    "zone": "{0.value:.4g} m outside the zone, negative inside (minimum {0.limit:.4g} m)",
    "setpoint_error": "{0.value:.4g} m from its setpoint (maximum {0.limit:.4g} m)",
    "floor": "at a height of {0.value:.4g} m (minimum {0.limit:.4g} m)",
    "thrust": "{0.value:.4g} N commanded (allowed 0 to {0.limit:.4g} N)",
    "tilt": "{0.value:.4g} rad of commanded tilt (maximum {0.limit:.4g} rad)",
    "state_age": "flown on a state {0.value:.4g} s old (maximum {0.limit:.4g} s)",
    "fallback_latency": "flown normally {0.value:.4g} s after its last sample (maximum {0.limit:.4g} s)",
    "silence": "no command for {0.value:.4g} s (maximum {0.limit:.4g} s)",
    "state_error": "tracked {0.value:.4g} m off its true position (maximum {0.limit:.4g} m)",
    "return": "still {0.value:.4g} m from its setpoint (maximum {0.limit:.4g} m)",
    "mode_agreement": "{0.value:.4g} m apart between nodes and closed_loop (maximum {0.limit:.4g} m)",
    "lost_moving": "LOST at {0.value:.4g} m/s (maximum {0.limit:.4g} m/s)",
    "swap_moved_track": "moved by {0.value:.4g} m (maximum {0.limit:.4g} m)",
    "stale_reported_ok": "OK on a state {0.value:.4g} s old (maximum {0.limit:.4g} s)",
    "hold_too_long": "held or level for {0.value:.4g} s (maximum {0.limit:.4g} s)",
    "evasion": "evades by {0.value:.4g} m/s^2 (minimum {0.limit:.4g} m/s^2)",
    "promise": "setpoints {0.value:.4g} m outside the zone (minimum {0.limit:.4g} m)",
    "stop_enters_zone": "stops {0.value:.4g} m outside the zone (minimum {0.limit:.4g} m)",
    "off_path_unreported": "{0.value:.4g} m from its setpoint (maximum {0.limit:.4g} m)",
}
"""Value and limit of a violation (0) of each policy or postcondition, with unit and meaning."""
PLAIN = "{0.value:.4g} (limit {0.limit:.4g})"
"""The same of properties whose values are counts or shares."""


@dataclass(frozen=True, slots=True)
class Violation:
    """Worst violation of one policy by one vehicle or pair."""

    policy: str
    who: str
    t: float
    """Time of the worst value [s]."""
    value: float
    """How bad."""
    limit: float
    """Limit, in the same unit."""

    def __str__(self) -> str:
        """Return one line; without time and value if there is none."""
        at = "" if np.isnan(self.t) else f" at {self.t:.2f} s"
        found = "" if np.isnan(self.value) else ": " + WORDS.get(self.policy, PLAIN).format(self)
        return f"{self.policy}: {self.who}{at}{found}"


Policy = Callable[[FlightTrace, Circumstances], list[Violation]]


def worst_violations(
    policy: str, trace: FlightTrace, excess: NDArray[np.float64], about: tuple[NDArray[np.float64], float]
) -> list[Violation]:
    """Return a violation for each vehicle with an excess (T, n) above 0; `about` is value and limit."""
    value, limit = about
    found = []
    for row, name in enumerate(trace.names):
        bad = np.where(np.isnan(excess[:, row]), -np.inf, excess[:, row])
        if len(bad) and bad.max() > 0.0:
            k = int(bad.argmax())
            found.append(Violation(policy, name, float(trace.t[k]), float(value[k, row]), limit))
    return found
