"""Jet of a vehicle that was never flown, from that of another by momentum theory.

A rotor that carries T draws air through its disk A at the induced velocity v, and the jet under it has the
momentum flux T:

    v = sqrt(m g / (2 rho A)),   A = 4 pi R^2

Lengths of the jet (width, gap, decay) scale with the radius of the disk of the four rotors together, 2 R, and
speeds with v. A vehicle in the jet loses lift in proportion to its own disk and to the dynamic pressure of
the air, so that between vehicles of the same kind its acceleration at the same gap / R does not change:

    F = rho v_j^2 A_i,   F / m_i = g (m_j / A_j) / (m_i / A_i)

The residual's deviation keeps its share, plus that by which such jets have missed the flights of a vehicle
they were not fitted to, `SCALING_STD` (docs/real_flights.md).

| symbol | name | meaning [unit] |
|---|---|---|
| m | mass | take-off mass [kg] |
| R | rotor_radius | [m] |
| A | | area of the four disks [m^2] |
| v | induced_velocity | in hover [m/s] |
"""

import math
from dataclasses import dataclass, replace

from q2q_model.downwash.jet import Jet
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import GRAVITY, NEURAL_SWARM_MASS, ROTOR_RADIUS

AIR_DENSITY = 1.2
"""rho [kg/m^3], at 20 degrees and sea level."""
SCALING_STD = 0.2
"""Deviation of a scaled jet, as a share of its downwash [-]: with it, 96 % of the samples of vehicles of
67 g lie within 1.96 deviations."""


@dataclass(frozen=True, slots=True)
class QuadrotorSize:
    """Mass of a quadrotor and the size of its rotors."""

    mass: float = tunable(NEURAL_SWARM_MASS, "take-off mass", unit="kg", low=1e-3, high=100.0)
    rotor_radius: float = tunable(ROTOR_RADIUS, "radius of a rotor", unit="m", low=1e-3, high=1.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)

    @property
    def disk_loading(self) -> float:
        """Return m / A [kg/m^2]."""
        return self.mass / (4.0 * math.pi * self.rotor_radius**2)

    @property
    def induced_velocity(self) -> float:
        """Return v in hover [m/s]."""
        return math.sqrt(self.disk_loading * GRAVITY / (2.0 * AIR_DENSITY))


CRAZYFLIE = QuadrotorSize()
"""Crazyflie 2.1 of the flights of Neural-Swarm2."""


def scaled_jet(jet: Jet, known: QuadrotorSize, new: QuadrotorSize, below: QuadrotorSize | None = None) -> Jet:
    """Return the jet of an airframe from that of a known one, fitted to pairs of that.

    Args:
        jet: Jet of the known airframe.
        known: Size of both vehicles of the pairs that the jet was fitted to.
        new: Size of the source.
        below: Size of the vehicle that feels the jet; that of the source by default.

    Raises:
        ValueError: a scaled value is out of a jet's bounds.
    """
    length, speed = new.rotor_radius / known.rotor_radius, new.induced_velocity / known.induced_velocity
    return replace(
        jet,
        strength=jet.strength * new.disk_loading / (below or new).disk_loading,
        reference_gap=length * jet.reference_gap,
        virtual_origin=length * jet.virtual_origin,
        decay_rate=jet.decay_rate / length,
        width=length * jet.width,
        range=length * jet.range,
        travel_speed=speed * jet.travel_speed,
        relative_std=math.hypot(jet.relative_std, SCALING_STD),
    )
