"""Limits and circumstances of the policies, and their violations."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from q2q_model.geometry.zone import Cylinder
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import CONTACT, CRAZYFLIE_2_0, Vehicle
from q2q_model.vehicle.setpoint_watchdog import LEVEL_AFTER_S
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies.flight_trace import FlightTrace


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of the policies."""

    separation: float = tunable(CONTACT, "smallest distance of two vehicles", unit="m", low=0.0)
    # a Crazyflie's legs reach 20 mm below its rotors
    floor: float = tunable(0.02, "height of a vehicle on the floor", unit="m", low=0.0)
    take_off: float = tunable(
        0.1, "height of setpoints above which floor contact is a fall", unit="m", low=0.0
    )
    stray: float = tunable(
        0.3, "clearance of setpoints from the zone for which vehicles must stay out of it", unit="m", low=0.0
    )
    setpoint_error_max: float = tunable(1.5, "largest distance from the setpoint", unit="m", low=0.0)
    # DisturbanceParams: real rotors give up to 1.03 of the commanded thrust; commands are exact
    thrust_slack: float = tunable(1e-9, "thrust beyond its bounds", unit="N", low=0.0)
    tilt_max: float = tunable(0.36, "largest commanded angle to the vertical", unit="rad", low=0.0)
    state_age_max: float = tunable(
        0.05, "largest age of the state behind a computed command", unit="s", low=0.0
    )
    # requirement: fallback within 60 ms of the fault; the firmware's watchdog waits LEVEL_AFTER_S
    fallback_latency_max: float = tunable(0.06, "from the fault to the fallback", unit="s", low=0.0)
    # nodes and recorder of a flight that is ended do not end together
    ended: float = tunable(
        LEVEL_AFTER_S, "without commands up to the end of the recording", unit="s", low=0.0
    )
    state_error_max: float = tunable(0.10, "error of a state with status tracked", unit="m", low=0.0)
    settle: float = tunable(3.5, "from the last fault to the return", unit="s", low=0.0)
    back: float = tunable(0.25, "distance from the reference after the return", unit="m", low=0.0)
    # a vehicle that turns at 3 m/s^2 and 1.5 m/s has changed its direction
    passing: float = tunable(0.5, "time for which it may be further away", unit="s", low=0.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class Circumstances:
    """Circumstances of a flight that the trace does not contain."""

    vehicle: Vehicle = CRAZYFLIE_2_0
    zone: Cylinder = field(default_factory=Cylinder)
    faults: tuple[Fault, ...] = ()
    """Injected faults, if known."""
    limits: Limits = field(default_factory=Limits)
    aware: bool = True
    """Whether controllers are given the predicted downwash."""
    exempts_uncontrollable: bool = True
    """Whether vehicles with too little thrust, or blind in an unpredicted downwash, are not judged."""


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
