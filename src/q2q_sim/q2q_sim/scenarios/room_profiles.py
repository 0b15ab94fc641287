"""Profiles of rooms: quality of motion capture, radio and inertial sensors, and disturbances.

| name | meaning |
|---|---|
| ideal | the paper's simulations: perfect sensing, no latency, still air |
| capture | the paper's experiments (section 2.2): VICON with noise, dropouts and outliers, IMU noise |
| real | a Crazyswarm room: 26 ms from camera to actuator, noise, losses, outliers, dropouts, thrust offset |
| rough | real, with axis flips, marker swaps, absences and stale bursts |

Sources: 26 ms in total and sub-millimetre noise: Preiss et al., Crazyswarm, ICRA 2017; dropouts,
outliers, flips, swaps: reports of Crazyswarm users; IMU: Bosch BMI088 data sheet at 80 Hz bandwidth.
Air and thrust of `real`: see CLEAR_AIR.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from q2q_model.tunable import ParameterValue
from q2q_sim.link.radio import RadioParams
from q2q_sim.plant.disturbance import DisturbanceParams
from q2q_sim.sensors.imu import ImuParams
from q2q_sim.sensors.vicon_params import ViconParams

Overrides = Mapping[str, Mapping[str, ParameterValue]]


@dataclass(frozen=True, slots=True)
class RoomProfile:
    """Parameters of a room, with those that the blocks know."""

    vicon: ViconParams = field(default_factory=ViconParams)
    radio: RadioParams = field(default_factory=RadioParams)
    imu: ImuParams = field(default_factory=ImuParams)
    disturbance: DisturbanceParams = field(default_factory=DisturbanceParams)
    overrides: Overrides = field(default_factory=dict)


IDEAL = RoomProfile(overrides={"mocap_filter": {"position_noise": 0.0, "rate_filter_s": 0.0}})

_SEEN = ViconParams(
    pos_noise=0.00015,  # VICON, static
    angle_noise=0.003,  # 0.15 mm at markers 5 cm apart
    outlier_rate=0.2,  # the paper's data "did contain outliers"; a few in each flight
    dropout_rate=0.1,  # a few a minute, 0.1-0.3 s each
)
_SENSED = ImuParams(acc_noise=0.02, acc_bias=0.05, gyro_noise=0.002, gyro_bias=0.005)

CAPTURE = RoomProfile(
    vicon=_SEEN,
    imu=_SENSED,
    disturbance=DisturbanceParams(air_std=0.005),  # 1 cm of drift in the paper's soft loop
)

CLEAR_AIR = DisturbanceParams(air_std=0.09, air_time=1.0, thrust_gain_min=1.008, thrust_gain_max=1.028)
"""Fit to real flights away from other vehicles: two Crazyflies 2.1 that exchange places (dc21_swap_ss),
loop K_p 10, K_d 5. Their z error is 1.87 cm rms: 1.7 cm upwards in the mean of a vehicle and flight, 0.6 to
1 cm about it, with an autocorrelation of .93, .80 and .56 after 0.2, 0.4 and 0.8 s. These values, simulated
with that loop, 0.07 s of thrust lag and 26 ms of delay, give 1.88 cm: 1.7, 0.74, and .95, .83, .55."""

REAL = RoomProfile(
    vicon=replace(_SEEN, latency=0.010),
    radio=RadioParams(latency=0.016, loss=0.02, quantised=True),
    imu=_SENSED,
    disturbance=CLEAR_AIR,
)

ROUGH = replace(
    REAL,
    vicon=replace(REAL.vicon, flip_rate=0.05, swap_rate=0.02, missing_rate=0.01, stale_rate=0.05),
    radio=replace(REAL.radio, jitter=0.005, loss=0.05),
)

PROFILES = {"ideal": IDEAL, "capture": CAPTURE, "real": REAL, "rough": ROUGH}


def profile_by_name(name: str) -> RoomProfile:
    """Return the profile of a named room; raise ValueError with the known names."""
    if name not in PROFILES:
        raise ValueError(f"unknown room {name!r}; choose one of {', '.join(PROFILES)}")
    return PROFILES[name]
