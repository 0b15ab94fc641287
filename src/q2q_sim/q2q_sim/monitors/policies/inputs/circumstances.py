"""Circumstances of a flight: vehicle, zone, faults, and the limits by which it is judged."""

from dataclasses import dataclass, field

from q2q_model.geometry.zone import Cylinder
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, Vehicle
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies.inputs.limits import Limits


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
    """Whether vehicles with too little thrust, or lost in an unpredicted downwash, are not judged."""
