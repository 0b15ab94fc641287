"""Hold the numbers of each vehicle, each with its source.

| symbol | name | meaning [unit] |
|---|---|---|
| m | mass | take-off mass [kg] |
| Ixx Iyy Izz | inertia | principal moments of inertia [kg m^2] |
| l | arm | centre to motor [m] |
| J_r | rotor_inertia | one rotor's inertia about its axis [kg m^2] |
| | drag_to_thrust | rotor drag torque over thrust [m] |
| | thrust_max | largest collective thrust [N] |
| | thrust_lag | time constant of thrust behind its command [s] |
"""

from dataclasses import dataclass

GRAVITY = 9.81
"""Standard gravity as the paper rounds it [m/s^2]."""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """Hold one vehicle's constants."""

    name: str
    mass: float
    """[kg]"""
    inertia: tuple[float, float, float]
    """Ixx, Iyy, Izz [kg m^2]."""
    arm: float
    """Centre to motor [m]."""
    rotor_inertia: float
    """J_r [kg m^2]."""
    drag_to_thrust: float
    """[m]"""
    thrust_max: float
    """Collective [N]."""
    thrust_lag: float
    """Time constant [s]; 0 means none."""

    @property
    def hover_thrust(self) -> float:
        """Return the thrust that carries the weight [N]."""
        return self.mass * GRAVITY


CRAZYFLIE_2_0 = Vehicle(
    name="crazyflie_2_0",
    mass=0.034,  # the paper, Table 1 (with rotor guards)
    inertia=(3.14e-5, 3.15e-5, 7.06e-5),  # Table 1, diagonal: its off-diagonals lost their exponents
    arm=0.046,  # half the 92 mm motor diagonal, the paper, section 3.1
    rotor_inertia=0.0,  # not given; gyroscopic torque of the rotors is left out, as Omega_r is near 0
    drag_to_thrust=0.00596,  # Foerster, System Identification of the Crazyflie 2.0, 2015, section 3.2
    thrust_max=0.60,  # about 15 g a motor, Bitcraze's thrust measurements of the Crazyflie 2.x
    thrust_lag=0.07,  # 0.06-0.08 s measured on real flights (thrust against its command)
)

TEXTBOOK_065 = Vehicle(
    name="textbook_065",
    mass=0.65,  # the mass whose hover energy the paper's Tables 6 and 7 show
    inertia=(7.5e-3, 7.5e-3, 1.3e-2),  # Bouabdallah, PhD thesis EPFL 2007, OS4 vehicle
    arm=0.23,  # the same
    rotor_inertia=6.0e-5,  # the same
    drag_to_thrust=0.024,  # the same: 7.5e-7 / 3.13e-5
    thrust_max=12.753,  # twice its weight: OS4's thrust ratio
    thrust_lag=0.0,  # the paper's simulation has none
)

VEHICLES = {vehicle.name: vehicle for vehicle in (CRAZYFLIE_2_0, TEXTBOOK_065)}


def vehicle_by_name(name: str) -> Vehicle:
    """Return the named vehicle; raise ValueError with the known names."""
    if name not in VEHICLES:
        raise ValueError(f"unknown vehicle {name!r}; known are {', '.join(VEHICLES)}")
    return VEHICLES[name]
