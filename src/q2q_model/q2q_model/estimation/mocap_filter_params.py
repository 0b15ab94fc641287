"""Parameters of the mocap filter."""

from dataclasses import dataclass

from q2q_model.estimation.association.outlier_thresholds import OutlierThresholds
from q2q_model.estimation.attitude.attitude_steps import AttitudeGateParams
from q2q_model.estimation.position.track_columns import TrackParams
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.tunable import check_bounds, tunable

_LIMITS = OutlierThresholds()


@dataclass(frozen=True, slots=True)
class MocapFilterParams:
    """Parameters of the mocap filter."""

    pos_max: float = tunable(
        _LIMITS.pos_max, "largest |x|, |y|, |z| of an accepted position", unit="m", low=0.1
    )
    speed_max: float = tunable(
        _LIMITS.speed_max,
        "a position is rejected if it is farther from the last accepted one than at this speed, plus "
        "jump_max",
        unit="m/s",
        low=0.1,
        high=100.0,
    )
    jump_max: float = tunable(
        _LIMITS.jump_max,
        "a position is rejected if it is farther than this from its prediction, plus the prediction's"
        " uncertainty",
        unit="m",
        low=1e-4,
        high=10.0,
    )
    # VICON: 0.15 mm static, under 2 mm dynamic (Merriaux et al., Sensors 2017)
    position_noise: float = tunable(
        1e-3,
        "standard deviation of a position sample; larger values smooth more; 0: positions are not filtered",
        unit="m",
        low=0.0,
        high=0.1,
    )
    # on real flights (nanobench) the velocity error changes by 10 % from 4 to 16
    jerk_noise: float = tunable(
        8.0,
        "root of the power density of the vehicles' jerk; larger values follow samples faster",
        unit="m/s^2.5",
        low=1e-3,
        high=1e4,
    )
    # dropouts of motion capture last 0.1 to 0.3 s
    coast_s: float = tunable(
        0.35,
        "time without accepted samples after which a vehicle is LOST instead of COASTING",
        unit="s",
        low=0.0,
        high=10.0,
    )
    reacquire_s: float = tunable(
        0.06,
        "time for which rejected positions must agree with each other to be accepted as a jump",
        unit="s",
        low=0.0,
        high=10.0,
    )
    # a vehicle that nobody sees lands 1 s after its last sample, at up to 1.1 m/s, and is cut after 5 s
    frozen_reacquire_s: float = tunable(
        4.0,
        "time for which a pose that repeats exactly is rejected, where poses have noise",
        unit="s",
        low=0.0,
        high=60.0,
    )
    turn_max: float = tunable(
        0.35,
        "largest accepted change of attitude, in addition to that at turn_rate_max",
        unit="rad",
        low=0.01,
        high=3.2,
    )
    # the Crazyflie's gyroscope saturates at 2000 deg/s; in flight it stays below a third of that
    turn_rate_max: float = tunable(12.0, "largest accepted body rate", unit="rad/s", low=0.1, high=100.0)
    rate_filter_s: float = tunable(
        0.02, "time constant of the low-pass filter of body rates; 0: no filter", unit="s", low=0.0, high=1.0
    )
    attitude_reacquire_s: float = tunable(
        0.3, "time after which a rejected attitude that persists is accepted", unit="s", low=0.0, high=10.0
    )
    # by then a vehicle that lies upside down has been cut by its firmware
    flip_reacquire_s: float = tunable(
        4.0,
        "time after which a sudden turn to upside down that persists is accepted",
        unit="s",
        low=0.0,
        high=60.0,
    )
    clock_jump_s: float = tunable(
        SET_BACK_S, "the filter is reset if stamps go back by more than this", unit="s", low=0.0, high=1e6
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def track_params(params: MocapFilterParams) -> TrackParams:
    """Return the parameters of the position tracks."""
    return TrackParams(*(getattr(params, name) for name in TrackParams._fields))


def attitude_params(params: MocapFilterParams) -> AttitudeGateParams:
    """Return the parameters of the attitude tracks."""
    turn = params.turn_max, params.turn_rate_max
    patience = params.attitude_reacquire_s, params.flip_reacquire_s
    return AttitudeGateParams(*turn, params.rate_filter_s, *patience, params.coast_s)
