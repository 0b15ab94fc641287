"""Terms of a room's air (q2q_sim.air.room_air has their equations), as learned from its recorded flights."""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array

SHORTEST = 300
"""Fewest samples of a recorded residual: 3 s."""
INSIDE = 0.25
"""e_0 [m/s^2]: |eta| from which on a vehicle is inside a wake: in both families the turbulence has its floor
from about there on."""
ON_THE_GROUND = 0.06
"""Height of a vehicle that stands, with its marker, and a margin [m]."""
ATTITUDE_FREQUENCY = 80.0
"""Attitude loop of the vehicles of a room whose file has none, critically damped [rad/s]."""


@dataclass(frozen=True, slots=True)
class JetTerm:
    """Mean downwash of one source, and how its air travels."""

    gaps_m: Array
    """Height differences of the table's rows, rising [m], (a,)."""
    radii_m: Array
    """Distances from the jet's axis of the table's columns, rising from 0 [m], (b,)."""
    push_mps2: Array
    """P [m/s^2], downwards, for a source whose thrust carries its weight, (a, b)."""
    upper_ratio: float
    """Share of P that the source feels, upwards [-]."""
    travel_speed_mps: float
    """Speed at which the air travels down [m/s]."""
    carried: float
    """Share of the source's horizontal velocity that the air keeps on its way [-]."""
    slope: float
    """Share of the source's tilt in the direction of the jet [-]."""
    bend: tuple[float, float] = (0.0, 0.0)
    """Slope of the axis by crosswind, world x and y [m/m]."""

    def __post_init__(self) -> None:
        """Check the table."""
        _check_knots("gaps_m", self.gaps_m)
        _check_knots("radii_m", self.radii_m)
        shape = (len(self.gaps_m), len(self.radii_m))
        if self.push_mps2.shape != shape:
            raise ValueError(
                f"push_mps2 has the shape {self.push_mps2.shape}; must be {shape}, by gaps and radii"
            )
        if not self.travel_speed_mps > 0.0:
            raise ValueError(f"travel_speed_mps = {self.travel_speed_mps}; must be above 0")


@dataclass(frozen=True, slots=True)
class AbsorptionTerm:
    """Part of a jet that a vehicle in it takes from those below."""

    share: float
    """Absorbed share on the axis [-]."""
    width_m: float
    """Standard deviation of the absorbing area across the axis [m]."""


@dataclass(frozen=True, slots=True)
class MeanderTerm:
    """Wandering of the axis of each jet."""

    std: float
    """Standard deviation of the axis's slope on x and on y [m/m]."""
    time_s: float
    """Correlation time [s]."""


@dataclass(frozen=True, slots=True)
class ResidualTerm:
    """Vertical turbulence under a wake."""

    floor_mps2: float
    """Standard deviation just inside a wake, without that of clear air [m/s^2]."""
    slope: float
    """Growth of the standard deviation with |eta| [-]."""
    time_s: float
    """Correlation time [s]."""
    gain_std: float = 0.0
    """Standard deviation of the gain on the mean downwash, drawn for each vehicle of a flight [-]."""
    recording: Array | None = None
    """n as recorded at 100 Hz, played back in pieces in place of the process, (k,)."""

    def __post_init__(self) -> None:
        """Check the recording."""
        if self.recording is not None and len(self.recording) < SHORTEST:
            raise ValueError(f"recording has {len(self.recording)} samples; must be at least {SHORTEST}")


@dataclass(frozen=True, slots=True)
class EdgeTorqueTerm:
    """Roll and pitch torque at the edge of a wake."""

    peak_nm: float
    """Largest torque under a source whose thrust carries its weight, positive towards the axis [N m]."""
    radius_m: float
    """Distance from the axis at which it is largest [m]."""


@dataclass(frozen=True, slots=True)
class GroundTerm:
    """Growth of thrust near the ground."""

    coefficient: float
    """b [-]."""
    rotor_radius_m: float
    """R [m]."""
    lowest_m: float = ON_THE_GROUND
    """z_0, height from which it grows no further: no vehicle was measured lower [m]."""

    def __post_init__(self) -> None:
        """Check the height."""
        if not self.lowest_m > 0.0:
            raise ValueError(f"lowest_m = {self.lowest_m}; must be above 0")


@dataclass(frozen=True, slots=True)
class WindTerm:
    """Wind and gusts, the same kind on each axis."""

    mean_mps2: tuple[float, float, float]
    """Acceleration by steady wind [m/s^2], world."""
    gust_std_mps2: float
    """Standard deviation of the acceleration by gusts [m/s^2]."""
    gust_time_s: float
    """Correlation time of gusts [s]."""


@dataclass(frozen=True, slots=True)
class VehicleTerm:
    """Differences between vehicles and flights."""

    offset_mean_mps2: float
    """Mean of the vertical offset a_0 [m/s^2]."""
    offset_std_mps2: float
    """Standard deviation of a_0 between vehicles and flights [m/s^2]."""
    thrust_lag_s: float
    """Time constant of thrust [s]."""
    headroom: float
    """Largest thrust over hover thrust at the start of a flight [-]."""
    headroom_per_volt: float
    """Its loss for each volt of battery [1/V]."""
    discharge_v_per_s: float
    """Fall of the battery's voltage in flight [V/s]."""
    attitude_frequency: float = ATTITUDE_FREQUENCY
    """Natural frequency of the onboard attitude loop [rad/s]."""
    headroom_std: float = 0.0
    """Standard deviation of the headroom between vehicles and flights [-]."""
    motor_std: float = 0.0
    """Standard deviation of what the motors of a vehicle work at hover, over their mean [-]."""
    attitude_damping: float = 1.0
    """Damping ratio of the onboard attitude loop [-]."""
    attitude_lead_ratio: float = 1.0
    """Lead of the onboard attitude loop over the thrust lag [-]."""


@dataclass(frozen=True, slots=True)
class RotorDragTerm:
    """Drag of the rotors, across the thrust."""

    per_s: float
    """Acceleration over speed [1/s]."""


@dataclass(frozen=True, slots=True)
class RateLoadTerm:
    """Work of the rotors in proportion to roll and pitch rate: it takes from their range and turns nothing.

    Rotors reach their largest thrust with it. It needs the vehicle's term, which has their headroom.
    """

    nms: float
    """Torque over rate [N m s]."""


def _check_knots(name: str, knots: Array) -> None:
    if knots.ndim != 1 or len(knots) < 2 or not (np.diff(knots) > 0.0).all() or knots[0] < 0.0:
        raise ValueError(f"{name} = {knots}; must be two or more increasing values of at least 0")
