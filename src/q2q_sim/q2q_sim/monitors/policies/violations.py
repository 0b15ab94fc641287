"""Limits and circumstances of the policies, and their violations."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from q2q_model.geometry.zone import Cylinder
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, Vehicle
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies.evidence import Evidence


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of the policies."""

    # two Crazyflies touch at twice 46 mm of arm and 23 mm of propeller
    separation: float = tunable(0.14, "smallest distance of two vehicles", unit="m", low=0.0)
    # a Crazyflie's legs reach 20 mm below its rotors
    floor: float = tunable(0.02, "height of a vehicle on the floor", unit="m", low=0.0)
    take_off: float = tunable(
        0.1, "height of setpoints above which floor contact is a fall", unit="m", low=0.0
    )
    stray: float = tunable(
        0.3, "clearance of setpoints from the zone for which vehicles must stay out of it", unit="m", low=0.0
    )
    stray_room: float = tunable(1.5, "largest distance from the setpoint", unit="m", low=0.0)
    # DisturbanceParams: real rotors give up to 1.03 of the commanded thrust; commands are exact
    thrust_slack: float = tunable(1e-9, "thrust beyond its bounds", unit="N", low=0.0)
    tilt_max: float = tunable(0.36, "largest commanded angle to the vertical", unit="rad", low=0.0)
    fresh: float = tunable(0.05, "largest age of the state behind a computed command", unit="s", low=0.0)
    # requirement: fallback within 60 ms of the fault; the firmware's watchdog waits 500 ms
    action: float = tunable(0.06, "from the fault to the fallback", unit="s", low=0.0)
    belief: float = tunable(0.10, "error of a state with status tracked", unit="m", low=0.0)
    settle: float = tunable(3.5, "from the last fault to the return", unit="s", low=0.0)
    back: float = tunable(0.25, "distance from the reference after the return", unit="m", low=0.0)
    # a vehicle that turns at 3 m/s^2 and 1.5 m/s has changed its direction
    passing: float = tunable(0.5, "time for which it may be further away", unit="s", low=0.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class Circumstances:
    """Circumstances of a flight that the evidence does not contain."""

    vehicle: Vehicle = CRAZYFLIE_2_0
    zone: Cylinder = field(default_factory=Cylinder)
    faults: tuple[Fault, ...] = ()
    """Injected faults, if known."""
    limits: Limits = field(default_factory=Limits)
    aware: bool = True
    """Whether controllers are told the predicted downwash."""


LEAST, MOST = "at least", "at most"
BOUNDS: Mapping[str, tuple[str, str]] = {
    "separation": (LEAST, "m"), "zone": (LEAST, "m"), "room": (MOST, "m"), "floor": (LEAST, "m"),
    "thrust": ("0 to", "N"), "tilt": (MOST, "rad"), "age": (MOST, "s"), "action": (MOST, "s"),
    "silence": (MOST, "s"), "belief": (MOST, "m"), "return": (MOST, "m"), "twin": (MOST, "m"),
    "lost": (MOST, "m/s"), "swap": (MOST, "m"), "told": (MOST, "s"), "hold": (MOST, "s"),
    "evasion": (LEAST, "m/s^2"), "promise": (LEAST, "m"), "stop": (LEAST, "m"), "off_path": (MOST, "m"),
}  # fmt: skip
"""What the limit of a policy or property bounds its values to, and their unit; others are numbers."""


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
        """Return one line."""
        where = f"{self.policy}: {self.who}" + (f" at {self.t:.2f} s" if isfinite(self.t) else "")
        if not isfinite(self.value):
            return where
        bound, unit = BOUNDS.get(self.policy, ("", ""))
        value, limit = (f"{number:.4g} {unit}".strip() for number in (self.value, self.limit))
        return f"{where}: {value}, allowed is {bound} {limit}".replace("  ", " ")


Policy = Callable[[Evidence, Circumstances], list[Violation]]


def worst(
    policy: str, evidence: Evidence, excess: NDArray[np.float64], about: tuple[NDArray[np.float64], float]
) -> list[Violation]:
    """Return a violation for each vehicle with an excess (T, n) above 0; `about` is value and limit."""
    value, limit = about
    found = []
    for row, name in enumerate(evidence.names):
        bad = np.where(np.isnan(excess[:, row]), -np.inf, excess[:, row])
        if len(bad) and bad.max() > 0.0:
            k = int(bad.argmax())
            found.append(Violation(policy, name, float(evidence.t[k]), float(value[k, row]), limit))
    return found
