"""Parameters of the safe replanner (`safe_replanner`)."""

from dataclasses import dataclass, replace

from q2q_model.geometry.zone import Cylinder
from q2q_model.tunable import check_bounds, tunable
from q2q_planner.online.safe.stopping.approach_speed import LAG, followed_pole


@dataclass(frozen=True, slots=True)
class SafeReplannerParams:
    """Parameters of the safe replanner."""

    enabled: bool = tunable(
        default=True,
        description=("avoid other vehicles; false: every vehicle returns to its reference and follows it"),
    )
    eps: float = tunable(0.25, "radius of the zone around each vehicle", unit="m", low=1e-3, high=10.0)
    d: float = tunable(
        Cylinder().d, "half height of the zone around each vehicle", unit="m", low=1e-3, high=10.0
    )
    margin: float = tunable(
        0.02, "distance kept from the zones of other vehicles", unit="m", low=0.0, high=1.0
    )
    # controllers tilt by 0.35 rad, 3.6 m/s^2, of which the feedback needs a part
    acc_max: float = tunable(
        2.0,
        "largest acceleration of a replanned setpoint, also when braking",
        unit="m/s^2",
        low=0.1,
        high=50.0,
    )
    hold: float = tunable(
        0.02,
        "time for which an acceleration is assumed to act until the next one: two ticks, one of them lost",
        unit="s",
        low=1e-3,
        high=0.5,
    )
    k_p: float = tunable(
        5.0, "stiffness towards the reference; used if jerk_max is 0", unit="1/s^2", low=0.01, high=100.0
    )
    k_d: float = tunable(
        4.0, "damping towards the reference; used if jerk_max is 0", unit="1/s", low=0.01, high=100.0
    )
    approach: float = tunable(
        2.0,
        "rate of the approach to a zone, as a double pole; larger values approach faster and brake "
        "later; if jerk_max is above 0, also of the approach to the reference, and at most 0.4 / T "
        "and 1 / (T + 2 acc_max / jerk_max) with T = max(hold, 0.05 s)",
        unit="1/s",
        low=0.1,
        high=20.0,
    )
    around: float = tunable(
        0.5,
        "size of the sideways correction that leads around another vehicle, relative to the "
        "correction away from it; 0: none",
        low=0.0,
        high=2.0,
    )
    height: float = tunable(
        0.05,
        "weight of vertical corrections relative to horizontal ones; below 1, horizontal ones are preferred",
        low=1e-3,
        high=1.0,
    )
    tracking: float = tunable(
        0.05,
        "largest tracking error that is assumed of a vehicle; only the horizontal one if tracking_z "
        "is above 0",
        unit="m",
        low=0.0,
        high=1.0,
    )
    tracking_z: float = tunable(
        0.0,
        "largest vertical tracking error that is assumed; 0: tracking bounds the error in all directions",
        unit="m",
        low=0.0,
        high=1.0,
    )
    jerk_max: float = tunable(
        0.0,
        "largest jerk of a replanned setpoint along an axis; 0: no limit",
        unit="m/s^3",
        low=0.0,
        high=1000.0,
    )
    # the vertical tube of 0.17 m for alpha = 1 % (docs/promise.md), and legs of 0.02 m
    height_min: float = tunable(
        0.2,
        "height below which a vehicle is not led away from its reference, unless the reference is lower",
        unit="m",
        low=-100.0,
        high=100.0,
    )
    drift: float = tunable(
        0.2,
        "speed at which a vehicle that is not tracked is assumed to leave its trajectory",
        unit="m/s",
        low=0.0,
        high=10.0,
    )
    grace: float = tunable(
        0.1,
        "age of a measurement up to which the tracking error covers the drift; beyond it, the zone "
        "grows by drift",
        unit="s",
        low=0.0,
        high=10.0,
    )
    speed_max: float = tunable(
        2.0,
        "largest speed that is assumed of vehicles of other replanners; if jerk_max is above 0, also "
        "the largest speed of replanned setpoints",
        unit="m/s",
        low=0.1,
        high=100.0,
    )
    forget: float = tunable(
        2.0,
        "age from which the last known state of a vehicle of another replanner is not used",
        unit="s",
        low=0.1,
        high=600.0,
    )

    @property
    def lag(self) -> float:
        """Return the lag of the acceleration [s]: at least `hold`, so that none that is desired is passed."""
        return max(LAG, self.hold)

    @property
    def pole(self) -> float:
        """Return both poles of an approach [1/s]: where jerk is bounded, no faster than it is followed."""
        if self.jerk_max == 0.0:
            return self.approach
        return followed_pole(self.approach, self.lag, 2.0 * self.acc_max / self.jerk_max)

    @property
    def with_tube(self) -> "SafeReplannerParams":
        """Return the parameters with the tubes of a pair in the zone instead of in `tracking`.

        A zone I(eps, d) and two tubes of radius r and half height r_z add up to I(eps + 2 r, d + 2 r_z).
        """
        if self.tracking_z == 0.0:
            return self
        eps, d = self.eps + 2.0 * self.tracking, self.d + 2.0 * self.tracking_z
        return replace(self, eps=eps, d=d, tracking=0.0, tracking_z=0.0)

    def __post_init__(self) -> None:
        """Raise ValueError where a number is out of bounds."""
        check_bounds(self)
