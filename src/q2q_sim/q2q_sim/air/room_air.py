"""Air of a room, as learned from its recorded flights: one dataclass for each term.

    eta_i   = - sum_j (1 - c_ij) T_j / (m g) P(dz_ij, r_ij)      downwash of the sources j above i
    e_i     = sigma(|eta_i|) n_i(t),  sigma = floor + slope |eta|  residual, an Ornstein-Uhlenbeck process n
    tau_i   = edge torque about the horizontal axis across the line from the jet's axis to the vehicle
    k_g     = 1 + b (R / z)^2                                       thrust over that away from the ground
    a_wind  = mean + gust                                           wind
    a_0     constant offset of each vehicle, drawn for each flight

(dz, r) are measured from where the source was when its air left it, carried and tilted by the source's
motion. c_ij is the share of j's jet that vehicles between j and i absorb. P is a table, smoothed by splines:
it has neither form nor parameters of a model that controllers may know (q2q_model.downwash).

A term that is None is switched off. `intervals` holds the 95 % interval of each fitted value by its path,
such as "residual.time_s".
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from q2q_model.signals.values import Array


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


@dataclass(frozen=True, slots=True)
class AbsorptionTerm:
    """Part of a jet that a vehicle in it takes from those below."""

    share: float
    """Absorbed share on the axis [-]."""
    width_m: float
    """Standard deviation of the absorbing area across the axis [m]."""


@dataclass(frozen=True, slots=True)
class ResidualTerm:
    """Vertical turbulence under a wake."""

    floor_mps2: float
    """Standard deviation just inside a wake, without that of clear air [m/s^2]."""
    slope: float
    """Growth of the standard deviation with |eta| [-]."""
    time_s: float
    """Correlation time [s]."""


@dataclass(frozen=True, slots=True)
class EdgeTorqueTerm:
    """Roll and pitch torque at the edge of a wake."""

    peak_nm: float
    """Largest torque under a source whose thrust carries its weight [N m]."""
    radius_m: float
    """Distance from the axis at which it is largest [m]."""


@dataclass(frozen=True, slots=True)
class GroundTerm:
    """Growth of thrust near the ground."""

    coefficient: float
    """b [-]."""
    rotor_radius_m: float
    """R [m]."""


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
    """Largest thrust over hover thrust with a full battery [-]."""
    headroom_per_volt: float
    """Its loss for each volt of battery below full [1/V]."""
    discharge_v_per_s: float
    """Fall of the battery's voltage in flight [V/s]."""


@dataclass(frozen=True, slots=True)
class RoomAir:
    """Air of a room; a term that is None is absent."""

    jet: JetTerm | None = None
    absorption: AbsorptionTerm | None = None
    residual: ResidualTerm | None = None
    edge_torque: EdgeTorqueTerm | None = None
    ground: GroundTerm | None = None
    wind: WindTerm | None = None
    vehicle: VehicleTerm | None = None
    flights: tuple[str, ...] = ()
    """Flights it was learned from."""
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """95 % interval of each fitted value, by its path, e.g. "residual.time_s"."""


TERMS = ("jet", "absorption", "residual", "edge_torque", "ground", "wind", "vehicle")
"""Fields of RoomAir that can be switched off."""
