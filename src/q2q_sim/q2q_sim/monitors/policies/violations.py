"""Say what a policy is given besides the evidence, and what it answers."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from q2q_model.geometry.zone import Cylinder, Zone
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, Vehicle
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies.evidence import Evidence


@dataclass(frozen=True, slots=True)
class Limits:
    """Hold how much is allowed."""

    # two Crazyflies touch at twice 46 mm of arm and 23 mm of propeller
    separation: float = tunable(0.14, "least distance of two vehicles", unit="m", low=0.0)
    # a Crazyflie's legs reach 20 mm below its rotors
    floor: float = tunable(0.02, "height at which a vehicle touches the floor", unit="m", low=0.0)
    take_off: float = tunable(0.1, "height of setpoints from which on a touch is a fall", unit="m", low=0.0)
    stray: float = tunable(
        0.3, "how clear setpoints are of the zone where vehicles must not be in it", unit="m", low=0.0
    )
    stray_room: float = tunable(1.5, "farthest from its setpoint", unit="m", low=0.0)
    # DisturbanceParams: rotors of real vehicles give up to 1.03 of what is asked; commands are exact
    thrust_slack: float = tunable(1e-9, "thrust beyond its bounds", unit="N", low=0.0)
    tilt_max: float = tunable(0.36, "largest commanded angle to the vertical", unit="rad", low=0.0)
    fresh: float = tunable(0.05, "oldest state of a command that calls itself computed", unit="s", low=0.0)
    # the issue: the safe action within 60 ms of the fault; the firmware's watchdog waits 500 ms
    action: float = tunable(0.06, "fault to action", unit="s", low=0.0)
    belief: float = tunable(0.10, "error of a state said to be tracked", unit="m", low=0.0)
    settle: float = tunable(3.5, "from the last trouble to the return", unit="s", low=0.0)
    back: float = tunable(0.25, "distance from the reference after the return", unit="m", low=0.0)

    def __post_init__(self) -> None:
        """Refuse values out of bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class Circumstances:
    """Hold what the evidence itself cannot say."""

    vehicle: Vehicle = CRAZYFLIE_2_0
    zone: Zone = field(default_factory=Cylinder)
    faults: tuple[Fault, ...] = ()
    """Those that were injected, where known."""
    limits: Limits = field(default_factory=Limits)


@dataclass(frozen=True, slots=True)
class Violation:
    """Hold the worst moment of one policy's breach by one vehicle or pair."""

    policy: str
    who: str
    t: float
    """When it was worst [s]."""
    value: float
    """How bad."""
    limit: float
    """What is allowed, in the same unit."""

    def __str__(self) -> str:
        """Return one line."""
        return f"{self.policy}: {self.who} at {self.t:.2f} s: {self.value:.4g}, allowed is {self.limit:.4g}"


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
