"""Violations of the policies: the worst of each vehicle or pair."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace

WORDS: Mapping[str, str] = {
    "separation": "{0.value:.4g} m apart, at least {0.limit:.4g} m is allowed",
    "zone": "{0.value:.4g} m outside the zone (inside is negative), at least {0.limit:.4g} m is allowed",
    "setpoint_error": "{0.value:.4g} m from its setpoint, at most {0.limit:.4g} m is allowed",
    "floor": "at a height of {0.value:.4g} m, more than {0.limit:.4g} m is allowed",
    "thrust": "{0.value:.4g} N commanded, 0 to {0.limit:.4g} N is allowed",
    "tilt": "{0.value:.4g} rad of commanded tilt, at most {0.limit:.4g} rad is allowed",
    "state_age": "flown on a state {0.value:.4g} s old, at most {0.limit:.4g} s is allowed",
    "fallback_latency": "flown normally {0.value:.4g} s after its last sample, at most {0.limit:.4g} s "
    "is allowed",
    "silence": "no command for {0.value:.4g} s, at most {0.limit:.4g} s is allowed",
    "state_error": "tracked {0.value:.4g} m off its true position, at most {0.limit:.4g} m is allowed",
    "return": "still {0.value:.4g} m from its setpoint, at most {0.limit:.4g} m is allowed",
    "mode_agreement": "{0.value:.4g} m apart by nodes and by closed_loop, at most {0.limit:.4g} m is allowed",
    "lost_moving": "LOST at {0.value:.4g} m/s, at most {0.limit:.4g} m/s is allowed",
    "swap_moved_track": "moved by {0.value:.4g} m, at most {0.limit:.4g} m is allowed",
    "stale_reported_ok": "OK on a state {0.value:.4g} s old, at most {0.limit:.4g} s is allowed",
    "hold_too_long": "held or level for {0.value:.4g} s, at most {0.limit:.4g} s is allowed",
    "evasion": "evades by {0.value:.4g} m/s^2, at least {0.limit:.4g} m/s^2 is allowed",
    "promise": "setpoints {0.value:.4g} m outside the zone, at least {0.limit:.4g} m is allowed",
    "stop_enters_zone": "stops {0.value:.4g} m outside the zone, at least {0.limit:.4g} m is allowed",
    "off_path_unreported": "{0.value:.4g} m from its setpoint, at most {0.limit:.4g} m is allowed",
}
"""Value and limit of a violation (0) of each policy or postcondition, with unit and meaning."""
PLAIN = "{0.value:.4g}, allowed is {0.limit:.4g}"
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
