"""Limits of the flight procedure's checks and steps."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable

DRY_RUN = (
    "check and log calls without executing them: no arming, take-off, setpoint or landing; an emergency "
    "stop is executed, and radio sends poses and firmware parameters to vehicles that do not fly"
)
"""Description of the parameter and of `--dry-run`."""
ROUNDING = 1e-9
"""Rounding of a difference of heights [m]."""
FULL_STATE_RANGE = 32.767
"""Largest number of a full state, in 16-bit millimetres, mm/s, mm/s^2 and mrad/s [m, m/s, m/s^2, rad/s]."""


@dataclass(frozen=True, slots=True)
class LandingParams:
    """Age at which a state is stale, and duration of a landing."""

    stale_s: float = tunable(
        0.1,
        "age from which a vehicle's state is stale, and a take-off is refused",
        unit="s",
        low=0.01,
        high=2.0,
    )
    landing_duration_min: float = tunable(3.0, "minimum duration of a landing", unit="s", low=0.5, high=60.0)
    # a landing's polynomial peaks at 2.19 times its mean; the firmware's PID descends at 1 m/s at most
    land_speed: float = tunable(
        0.4,
        "largest mean speed of a landing, which lasts longer than landing_duration_min from greater heights",
        unit="m/s",
        low=0.05,
        high=5.0,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)

    def duration(self, height: float) -> float:
        """Return the duration of a landing from a height [m] [s]."""
        return max(self.landing_duration_min, height / self.land_speed)


@dataclass(frozen=True, slots=True)
class FlightProcedureParams:
    """Limits and durations of the procedure."""

    dry_run: bool = tunable(default=False, description=DRY_RUN)
    take_off_height: float = tunable(
        0.5, "height above the ground at the end of a take-off", unit="m", low=0.1, high=5.0
    )
    take_off_s: float = tunable(2.0, "duration of a take-off", unit="s", low=0.5, high=60.0)
    land_home: bool = tunable(
        default=True, description="transit to the plan's first points before a landing from a hold"
    )
    start_tolerance: float = tunable(
        0.3,
        "largest horizontal distance of a vehicle from its first point at a take-off",
        unit="m",
        low=0.01,
        high=5.0,
    )
    horizontal_separation_min: float = tunable(
        0.3, "smallest horizontal distance between vehicles at a take-off", unit="m", low=0.0, high=5.0
    )
    room: tuple[float, ...] = tunable(
        (-3.0, -3.0, 0.0, 3.0, 3.0, 3.0),
        "volume that plans must not leave: lowest x, y, z, then highest x, y, z",
        unit="m",
    )
    ground_height: float = tunable(
        0.0, "height of a vehicle that stands on the ground", unit="m", low=-5.0, high=5.0
    )
    near_ground: float = tunable(
        0.1,
        "height above ground_height below which a vehicle at rest is on the ground; at least six "
        "times the noise of motion capture",
        unit="m",
        low=0.03,
        high=0.5,
    )
    still_speed: float = tunable(
        0.1,
        "largest speed of a vehicle that stands still on the ground; in the air, a vehicle is at rest"
        " below 2.5 times this speed, and within this speed times settle_s of one place",
        unit="m/s",
        low=0.005,
        high=1.0,
    )
    goal_tolerance: float = tunable(
        0.15, "largest distance from its target at which a vehicle has arrived", unit="m", low=0.01, high=1.0
    )
    settle_s: float = tunable(
        1.0,  # a vehicle that swings about its point is slow for 0.5 s where it turns
        "time for which each vehicle must be at rest before a step is complete",
        unit="s",
        low=0.5,
        high=10.0,
    )
    step_timeout_s: float = tunable(
        5.0, "time after the planned end of a step at which the step has failed", unit="s", low=0.1, high=60.0
    )
    voltage_start: float = tunable(
        3.6, "smallest battery voltage for a take-off; 0 disables the check", unit="V", low=0.0, high=20.0
    )
    estimator_error: float = tunable(
        0.1,
        "largest distance between a vehicle's onboard position estimate and its state at a take-off",
        unit="m",
        low=0.001,
        high=5.0,
    )
    hover_mismatch: float = tunable(
        0.15,
        "largest relative difference between the hover thrust computed from `vehicle` and `firmware` "
        "and that of the vehicle's own parameters",
        low=0.01,
        high=1.0,
    )
    setpoint_step_max: float = tunable(
        0.3,
        "largest change of a setpoint in one tick; after a larger one all vehicles land",
        unit="m",
        low=0.01,
        high=5.0,
    )
    # the firmware levels after 0.5 s and cuts after 2 s (COMMANDER_WDT_TIMEOUT_STABILIZE, _SHUTDOWN): half is
    # left for the services that stop the stream and land
    setpoint_timeout_s: float = tunable(
        1.0,
        "time in flight without a setpoint (crazyswarm: without one sent) after which all vehicles land",
        unit="s",
        low=0.1,
        high=60.0,
    )

    def __post_init__(self) -> None:
        """Check the bounds, the time to rest, the room, and that a take-off stays below its ceiling.

        Raises:
            ValueError: naming the value and what is allowed.
        """
        check_bounds(self)
        if self.settle_s >= self.step_timeout_s:
            allowed = f"must be less than step_timeout_s = {self.step_timeout_s:g} s"
            raise ValueError(f"settle_s = {self.settle_s:g}; {allowed}, or no transit completes in time")
        if len(self.room) != 6 or any(self.room[k] >= self.room[k + 3] for k in range(3)):
            raise ValueError(f"room = {self.room}; must be lowest x, y, z and highest x, y, z [m]")
        if max(abs(wall) for wall in self.room) > FULL_STATE_RANGE:
            allowed = f"setpoints reach up to {FULL_STATE_RANGE} m from the origin along an axis"
            raise ValueError(f"room = {self.room}: {allowed}; move the origin to the middle of the room")
        ceiling = self.room[5] - self.ground_height
        if self.take_off_height > ceiling + ROUNDING:
            allowed = f"must be at most {ceiling:g} m, the top of room"
            raise ValueError(f"take_off_height = {self.take_off_height:g}; {allowed}")
