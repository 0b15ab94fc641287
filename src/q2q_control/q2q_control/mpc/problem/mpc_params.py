"""Parameters of the receding-horizon controller."""

from dataclasses import dataclass

from q2q_control.attitude.command_delay import LATENCY_S
from q2q_control.failsafe.fallback_params import LONGEST_HOLD_S
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.attitude_limits import TILT_MAX, YAW_RATE_MAX


@dataclass(frozen=True, slots=True)
class MpcParams:
    """Horizon, weights, limits and command path of the MPC."""

    horizon: float = tunable(2.0, "length of the horizon", unit="s", low=0.2, high=10.0, read_only=True)
    steps: int = tunable(40, "number of stages of the horizon", low=4, high=400, read_only=True)
    axes: str = tunable(
        "coupled_z",
        "altitude: MPC in z, and a PD law in x and y; coupled_z: MPC in all axes, vehicles coupled in"
        " z by downwash (with correct: as coupled_xyz); coupled_xyz: MPC in all axes, vehicles "
        "coupled in all of them by downwash",
        choices=("altitude", "coupled_z", "coupled_xyz"),
    )
    group_max: int = tunable(
        4,
        "maximum number of interacting vehicles that are solved jointly; 1: each vehicle separately",
        low=1,
        high=1000,
    )
    bandwidth_z: float = tunable(
        5.0,
        "bandwidth of the altitude loop; with correct, at least 12 rad/s is used",
        unit="rad/s",
        low=0.2,
        high=50.0,
    )
    bandwidth_xy: float = tunable(2.0, "bandwidth of the position loop", unit="rad/s", low=0.2, high=20.0)
    terminal_weight: float = tunable(
        0.45,
        "factor on the terminal weight of the infinite horizon, for vehicles solved jointly and for "
        "axes at a bound",
        low=0.0,
        high=10.0,
    )
    jerk_weight: float = tunable(
        0.2,
        "weight of jerk relative to that of control effort; larger values give smoother commands",
        low=0.0,
        high=100.0,
    )
    slope_max: float = tunable(
        10.0,
        "limit of the gradient of the predicted downwash with position",
        unit="1/s^2",
        low=0.0,
        high=100.0,
    )
    loading: float = tunable(
        0.0,
        "relative growth of a source's downwash over that of its thrust beyond hover: 0 as in the "
        "paper, 1 by momentum theory; above 0, the MPC itself predicts the present downwash, too",
        low=0.0,
        high=2.0,
    )
    latency: float = tunable(
        LATENCY_S, "delay from the stamp of a tick to the effect of its command", unit="s", low=0.0, high=0.3
    )
    attitude_lag: float = tunable(
        0.12, "lag of the tilt behind its command, without the lag of the rotors", unit="s", low=0.0, high=1.0
    )
    observe: bool = tunable(default=True, description="estimate and cancel disturbances")
    state_bandwidth: float = tunable(
        20.0,
        "bandwidth of the estimates of position and velocity; larger values follow measurements faster",
        unit="rad/s",
        low=0.1,
        high=100.0,
    )
    observer_bandwidth: float = tunable(
        3.0,
        "bandwidth of the disturbance estimate; larger values follow changes faster, and pass more noise",
        unit="rad/s",
        low=0.01,
        high=50.0,
    )
    disturbance_max: float = tunable(
        3.0, "limit of the estimated disturbance", unit="m/s^2", low=0.0, high=9.81
    )
    thrust_limited: bool = tunable(
        default=False, description="keep thrust U1 within thrust_max (section 5.2 of the paper)"
    )
    thrust_max: float = tunable(
        6.6,
        "upper limit of thrust U1 if thrust_limited is true; the default is the paper's, for 0.65 kg",
        unit="N",
        low=0.0,
        high=100.0,
    )
    thrust_rate_max: float = tunable(
        100.0, "largest rate of change of thrust over mass", unit="m/s^3", low=50.0, high=1e4
    )
    reserve: float = tunable(
        0.0,
        "with correct: thrust margin that later stages keep for errors of the predicted downwash, in "
        "standard deviations of that error; larger values keep more thrust free",
        low=0.0,
        high=4.0,
    )
    tilt_max: float = tunable(
        TILT_MAX, "largest angle between thrust and vertical", unit="rad", low=0.01, high=1.2
    )
    tilt_rate_max: float = tunable(
        3.0, "largest rate of change of the tilt", unit="rad/s", low=1.0, high=30.0
    )
    k_yaw: float = tunable(2.0, "gain from yaw error to yaw rate", unit="1/s", low=0.0, high=20.0)
    yaw_rate_max: float = tunable(
        YAW_RATE_MAX, "largest commanded yaw rate", unit="rad/s", low=0.0, high=20.0
    )
    iterations_max: int = tunable(12, "maximum number of Riccati recursions per solve", low=1, high=200)
    shift_time: float = tunable(
        0.2,
        "time for which the last solution, shifted in time, is used without a new one; then a PD law "
        "takes over",
        unit="s",
        low=0.0,
        high=2.0,
    )
    hold_duration: float = tunable(
        LONGEST_HOLD_S,
        "time for which the last command is repeated for a vehicle without a usable state",
        unit="s",
        low=0.0,
        high=1.0,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)

    @property
    def step(self) -> float:
        """Return the length of a stage [s]."""
        return self.horizon / self.steps
