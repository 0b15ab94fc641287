"""Gains and limits of the PID."""

from dataclasses import dataclass

from q2q_control.failsafe.fallback_params import LONGEST_HOLD_S
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.attitude_limits import TILT_MAX, YAW_RATE_MAX


@dataclass(frozen=True, slots=True)
class PidParams:
    """Gains and limits of the PID."""

    k_p_z: float = tunable(
        0.81073, "gain from altitude error to acceleration", unit="1/s^2", low=0.0, high=200.0
    )
    k_d_z: float = tunable(
        0.42952, "gain from climb rate error to acceleration", unit="1/s", low=0.0, high=50.0
    )
    k_i_z: float = tunable(
        0.0, "gain from the integral of the altitude error to acceleration", unit="1/s^3", low=0.0, high=100.0
    )
    k_p_xy: float = tunable(
        4.0, "gain from position error to acceleration", unit="1/s^2", low=0.0, high=200.0
    )
    k_d_xy: float = tunable(3.6, "gain from velocity error to acceleration", unit="1/s", low=0.0, high=50.0)
    k_i_xy: float = tunable(
        0.0, "gain from the integral of the position error to acceleration", unit="1/s^3", low=0.0, high=100.0
    )
    k_yaw: float = tunable(2.0, "gain from yaw error to yaw rate", unit="1/s", low=0.0, high=20.0)
    integral_max: float = tunable(
        2.0, "largest acceleration by the integral term on each axis", unit="m/s^2", low=0.0, high=9.81
    )
    return_speed_max: float = tunable(
        2.0,
        "largest speed, relative to the setpoint, at which a vehicle returns to its setpoint",
        unit="m/s",
        low=0.1,
        high=20.0,
    )
    thrust_limited: bool = tunable(
        default=False, description="keep thrust U1 within thrust_max (section 5.1 of the paper)"
    )
    thrust_max: float = tunable(
        6.6,
        "upper limit of thrust U1 if thrust_limited is true; the default is the paper's, for 0.65 kg",
        unit="N",
        low=0.0,
        high=100.0,
    )
    tilt_max: float = tunable(
        TILT_MAX, "largest angle between thrust and vertical", unit="rad", low=0.01, high=1.2
    )
    yaw_rate_max: float = tunable(
        YAW_RATE_MAX, "largest commanded yaw rate", unit="rad/s", low=0.0, high=20.0
    )
    exact_inverse: bool = tunable(
        default=False,
        description=(
            "compute the attitude from the demanded acceleration exactly, instead of for small angles"
        ),
    )
    stale_fade: float = tunable(
        0.5,
        "time constant with which the predicted downwash decays while its source is not tracked",
        unit="s",
        low=0.01,
        high=100.0,
        read_only=True,
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
