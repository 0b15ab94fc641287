"""Limits of the policies."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import CONTACT
from q2q_model.vehicle.setpoint_watchdog import LEVEL_AFTER_S


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
