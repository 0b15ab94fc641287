"""Air of a room, as learned from its recorded flights: a value of each term (q2q_sim.air.air_terms).

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

from q2q_sim.air.air_names import AirError
from q2q_sim.air.air_terms import (
    AbsorptionTerm,
    EdgeTorqueTerm,
    GroundTerm,
    JetTerm,
    MeanderTerm,
    RateLoadTerm,
    ResidualTerm,
    RotorDragTerm,
    VehicleTerm,
    WindTerm,
)
from q2q_sim.air.term_bounds import check_term


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
    """Their digests, by which copies of other names are known (q2q_model.flights.duplicates.same_flight)."""
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
            raise AirError(f"unknown term {term!r} of an air; choose one of {', '.join(TERMS)}")
    kept = {name: None if name in terms else getattr(air, name) for name in TERMS}
    return RoomAir(**kept, flights=air.flights, digests=air.digests, intervals=air.intervals)
