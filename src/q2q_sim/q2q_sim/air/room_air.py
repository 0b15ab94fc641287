"""Air of a room, as learned from its recorded flights: one dataclass for each term.

    eta_i   = - sum_j K_ij T_j / (m g) P(dz_ij, r_ij)             downwash of the sources j above i
    K_ij    = prod_k (1 - c_kj)                                   left by the vehicles k between j and i
    c_kj    = max(share exp(-r_kj^2 / 2 w^2), P(dz_kj, r_kj) / g)
    e_i     = sigma n_i(t),  sigma = floor min(|eta_i| / e_0, 1) + slope |eta_i|           residual
    tau_i   = sum_j K_ij T_j / (m g) peak (r / r_0) exp((1 - r^2 / r_0^2) / 2)     edge torque
    k_g     = 1 + b (R / max(z, z_0))^2                           thrust over that away from the ground
    a_wind  = mean + gust                                         wind
    a_0     = offset_mean + offset_std n                          of each vehicle, drawn for each flight
    a_drag  = - k (v - (v . b) b)                                 drag of its rotors, b: body z
    f_load  = c (+-(p + T p') +-(q + T q')) / 4 h                 of each rotor, at body rates p and q

(dz, r) are measured from the axis of the jet at the vehicle's height. Its air left the source at t - tau,
tau = dz / travel_speed, and has moved since:

    axis = pos_j + carried vel_j tau + (bend + meander m_j(t) - slope s_j) dz,   s_j: slope of body z

with position, velocity and slope of the source at t - tau. n, m and the gusts are Ornstein-Uhlenbeck
processes of unit variance. The edge torque acts about the horizontal axis across the line from the jet's axis
to the vehicle; a positive one tips the vehicle towards the axis, as the push on its inner rotors does.

Momentum: a vehicle that hovers in a jet carries its weight and the push m P; the jet has lost at least that
much, c >= P / g, so that below a stack of three no more than 2 m g arrives, whatever was fitted.

P is a table: it has neither form nor parameters of a model that controllers may know (q2q_model.downwash). It
is bilinear between its nodes, zero beyond its last radius, and constant above its first gap; below the last
gap g the jet is self-similar, P(dz, r) = (g / dz)^2 P(g, r g / dz). Where two vehicles change roles,
|dz| < 0.1 m, both parts are blended by a cubic as in q2q_sim.air.wake_laws.

A vehicle is in a jet where a node of the table outside of its radius has a push, or where it would absorb
more than 0.1 % of the jet; others neither feel nor absorb it.

A rotor gives no more than its largest thrust, less its load; what rotors are asked for beyond that, all lose
alike (q2q_sim.plant.body.rotors.excess_share), but together they give no more than each by itself
(`share_given`). h: lever of the rotors, T: thrust lag.

A term that is None is switched off; the residual and the edge torque act under a jet, and are zero without
one. `intervals` holds the 95 % interval of each fitted value by its path, such as "residual.time_s".
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.air.air_names import AirError
from q2q_sim.air.term_bounds import check_term

SHORTEST = 300
"""Fewest samples of a recorded residual: 3 s."""
LEAST_ABSORBED = 1e-3
"""Share of a jet below which nothing is absorbed by a vehicle that feels none of it [-]."""
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
            raise ValueError(f"push_mps2 has the shape {self.push_mps2.shape}: gaps and radii need {shape}")
        if not self.travel_speed_mps > 0.0:
            raise ValueError(f"travel_speed_mps = {self.travel_speed_mps}: above 0 is allowed")


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
            raise ValueError(f"recording has {len(self.recording)} samples: {SHORTEST} or more are needed")


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
            raise ValueError(f"lowest_m = {self.lowest_m}: above 0 is allowed")


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


@dataclass(frozen=True, slots=True)
class RoomAir:
    """Air of a room; a term that is None is absent."""

    jet: JetTerm | None = None
    absorption: AbsorptionTerm | None = None
    meander: MeanderTerm | None = None
    residual: ResidualTerm | None = None
    edge_torque: EdgeTorqueTerm | None = None
    ground: GroundTerm | None = None
    wind: WindTerm | None = None
    vehicle: VehicleTerm | None = None
    rotor_drag: RotorDragTerm | None = None
    rate_load: RateLoadTerm | None = None
    flights: tuple[str, ...] = ()
    """Flights it was learned from."""
    digests: tuple[str, ...] = ()
    """Their digests, by which copies of other names are known (q2q_model.flights.same_flight)."""
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """95 % interval of each fitted value, by its path, e.g. "residual.time_s"."""

    def __post_init__(self) -> None:
        """Check the numbers of the terms."""
        for name in TERMS:
            if (term := getattr(self, name)) is not None:
                check_term(name, term)


TERMS = tuple(one.name for one in fields(RoomAir) if one.name not in ("flights", "digests", "intervals"))
"""Fields of RoomAir that can be switched off."""


def without_terms(air: RoomAir, terms: tuple[str, ...]) -> RoomAir:
    """Return the air with some terms switched off.

    Raises:
        AirError: an unknown term.
    """
    for term in terms:
        if term not in TERMS:
            raise AirError(f"unknown term {term!r} of an air: terms are {', '.join(TERMS)}")
    kept = {name: None if name in terms else getattr(air, name) for name in TERMS}
    return RoomAir(**kept, flights=air.flights, digests=air.digests, intervals=air.intervals)


def ends_of_jet(jet: JetTerm, absorption: AbsorptionTerm | None) -> Array:
    """Return the radius within which a vehicle is in the jet between two gaps of the table [m], (a - 1,)."""
    radii = np.append(0.0, jet.radii_m[1:])
    felt = [np.flatnonzero(row)[-1] + 1 if row.any() else 0 for row in jet.push_mps2]
    ends = radii[np.minimum(felt, len(radii) - 1)]
    absorbing = 0.0
    if absorption is not None and absorption.share > LEAST_ABSORBED:
        absorbing = absorption.width_m * np.sqrt(2.0 * np.log(absorption.share / LEAST_ABSORBED))
    return np.asarray(np.clip(np.maximum(ends[:-1], ends[1:]), absorbing, radii[-1]))


def _check_knots(name: str, knots: Array) -> None:
    if knots.ndim != 1 or len(knots) < 2 or not (np.diff(knots) > 0.0).all() or knots[0] < 0.0:
        raise ValueError(f"{name} = {knots}: two or more rising values, 0 or above, are needed")
