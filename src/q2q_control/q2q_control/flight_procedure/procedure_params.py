"""Say when a flight is refused, and when a step is done: the parameters of the flight procedure."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable


@dataclass(frozen=True, slots=True)
class LandingParams:
    """What a state is worth, and how long a landing takes."""

    stale_s: float = tunable(0.1, "a state older than this is none", unit="s", low=0.01, high=2.0)
    land_s: float = tunable(3.0, "least duration of a landing", unit="s", low=0.5, high=60.0)
    # a landing's polynomial peaks at 2.19 times its mean, and the firmware's PID falls no faster than 1 m/s
    land_speed: float = tunable(0.4, "largest mean speed of a landing", unit="m/s", low=0.05, high=5.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)

    def duration(self, height: float) -> float:
        """Return how long a landing from a height [m] takes [s]."""
        return max(self.land_s, height / self.land_speed)


@dataclass(frozen=True, slots=True)
class FlightProcedureParams:
    """Limits and durations of the procedure."""

    dry_run: bool = tunable(default=False, description="check and say what would be sent; send nothing")
    take_off_height: float = tunable(
        0.5, "where a take-off ends, above the ground", unit="m", low=0.1, high=5.0
    )
    take_off_s: float = tunable(2.0, "duration of a take-off", unit="s", low=0.5, high=60.0)
    land_home: bool = tunable(
        default=True, description="from a hold, glide to the plan's first points before landing"
    )
    start_near: float = tunable(
        0.3, "largest distance of a vehicle from where it should start", unit="m", low=0.01, high=5.0
    )
    apart: float = tunable(0.3, "least distance of two vehicles from above", unit="m", low=0.0, high=5.0)
    room: tuple[float, ...] = tunable(
        (-3.0, -3.0, 0.0, 3.0, 3.0, 3.0), "lowest x, y, z, then highest x, y, z of the room", unit="m"
    )
    ground: float = tunable(0.0, "height of a vehicle on the ground", unit="m", low=-5.0, high=5.0)
    near_ground: float = tunable(
        0.1, "a vehicle that rests this near to the ground stands on it", unit="m", low=0.01, high=0.5
    )
    still_speed: float = tunable(0.1, "a vehicle slower than this rests", unit="m/s", low=0.005, high=1.0)
    reached: float = tunable(
        0.15, "a vehicle this near to its setpoint has reached it", unit="m", low=0.01, high=1.0
    )
    settle_s: float = tunable(0.5, "for how long, until a step is done", unit="s", low=0.0, high=10.0)
    patience_s: float = tunable(
        5.0, "time beyond its duration after which a step has failed", unit="s", low=0.1, high=60.0
    )
    volt_start: float = tunable(
        3.6, "least battery to start with; 0 asks for none", unit="V", low=0.0, high=20.0
    )
    estimator_error: float = tunable(
        0.1, "largest distance of a vehicle's own estimate from its state", unit="m", low=0.001, high=5.0
    )
    hover_mismatch: float = tunable(
        0.15, "largest mismatch of the thrust sent at hover and the vehicle's own", low=0.01, high=1.0
    )
    jump: float = tunable(
        0.3, "a setpoint that moves farther in one tick is not flown", unit="m", low=0.01, high=5.0
    )
    lost_s: float = tunable(
        2.0, "time without a setpoint in flight until all land", unit="s", low=0.1, high=60.0
    )

    def __post_init__(self) -> None:
        """Check the bounds and the room.

        Raises:
            ValueError: naming the value and what is allowed.
        """
        check_bounds(self)
        if len(self.room) != 6 or any(self.room[k] >= self.room[k + 3] for k in range(3)):
            raise ValueError(f"room = {self.room}: lowest x, y, z and highest x, y, z [m] are expected")
