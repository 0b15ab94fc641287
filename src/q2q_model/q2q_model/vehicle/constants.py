"""Physical constants of each vehicle, with their sources.

| symbol | name | meaning [unit] |
|---|---|---|
| m | mass | take-off mass [kg] |
| Ixx Iyy Izz | inertia | principal moments of inertia [kg m^2] |
| l | arm | centre to motor [m] |
| | drag_to_thrust | rotor drag torque over thrust [m] |
| | thrust_max | largest collective thrust [N] |
| | full_pwm_thrust | collective thrust with every motor at 65535 PWM, under battery compensation [N] |
| | thrust_lag | time constant of thrust behind its command [s] |
"""

from dataclasses import dataclass, fields, replace
from math import inf, nextafter

from q2q_model.vehicle.thrust_map import (
    BRUSHED_MOTOR,
    BRUSHLESS_MOTOR,
    MOTOR_THRUST,
    PWM_FULL,
    RPYT_PWM_MAX,
    STOCK,
    motor_thrust,
)

GRAVITY = 9.81
"""Standard gravity as the paper rounds it [m/s^2]."""

CONTACT = 0.14
"""Distance at which two Crazyflies 2 touch [m]: twice 46 mm of arm and 23 mm of propeller."""

ROTOR_RADIUS = 0.0225
"""Radius of a rotor of the Crazyflie 2.0 and 2.1 [m]: propellers of 45 mm (Bitcraze)."""

NEURAL_SWARM_MASS = 0.032
"""Mass of the Crazyflies 2.1 of the public flights of Neural-Swarm2 (T-RO 2021), with a marker and a micro-SD
deck [kg]."""

SMALLEST = nextafter(0.0, 1.0)
"""Smallest number above 0."""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """Physical constants of one vehicle."""

    name: str
    mass: float
    """[kg]"""
    inertia: tuple[float, float, float]
    """Ixx, Iyy, Izz [kg m^2]."""
    arm: float
    """Centre to motor [m]."""
    drag_to_thrust: float
    """[m]"""
    thrust_max: float
    """Collective [N]."""
    full_pwm_thrust: float
    """[N]"""
    thrust_lag: float
    """Time constant [s]; 0 is none."""

    def __post_init__(self) -> None:
        """Check the numbers; raise ValueError with the field, its value and what is allowed."""
        for one in fields(self)[1:]:
            given = getattr(self, one.name)
            least, bound = (0.0, "at least 0") if one.name == "thrust_lag" else (SMALLEST, "above 0")
            numbers = given if isinstance(given, tuple) else (given,)
            if not all(least <= number < inf for number in numbers):
                raise ValueError(f"vehicle {self.name}: {one.name} = {given}; must be finite and {bound}")

    @property
    def hover_thrust(self) -> float:
        """Return the thrust that balances the weight [N]."""
        return self.mass * GRAVITY

    @property
    def rpyt_thrust_max(self) -> float:
        """Return the largest collective thrust of an RPYT setpoint [N]."""
        return min(self.thrust_max, self.full_pwm_thrust * RPYT_PWM_MAX / PWM_FULL)


CRAZYFLIE_2_0 = Vehicle(
    name="crazyflie_2_0",
    mass=0.034,  # the paper, Table 1 (with rotor guards)
    inertia=(3.14e-5, 3.15e-5, 7.06e-5),  # Table 1, diagonal: its off-diagonals lost their exponents
    arm=0.046,  # half the 92 mm motor diagonal, the paper, section 3.1
    drag_to_thrust=0.00596,  # Foerster, System Identification of the Crazyflie 2.0, 2015, section 3.2
    thrust_max=4.0 * BRUSHED_MOTOR,
    full_pwm_thrust=4.0 * BRUSHED_MOTOR,
    thrust_lag=0.07,  # 0.06-0.08 s measured on real flights (thrust against its command)
)

CRAZYFLIE_2_1 = replace(
    CRAZYFLIE_2_0,
    name="crazyflie_2_1",
    mass=0.027,  # Bitcraze's data sheet: take-off weight 27 g, no deck
    inertia=(
        1.657e-5,
        1.666e-5,
        2.926e-5,
    ),  # Foerster 2015 (a 2.0 of 28 g), and the firmware's Lee controller
    drag_to_thrust=0.00735,  # firmware, platform_defaults_cf2.h: THRUST2TORQUE, legacy propellers
    thrust_lag=0.086,  # utiasDSL/drone-models, so_rpy_rotor, cf2x_L250 (identified in flight)
)

CRAZYFLIE_2_1_PLUS = replace(
    CRAZYFLIE_2_0,
    name="crazyflie_2_1_plus",
    mass=0.029,  # firmware, platform_defaults_cf2.h: CF_MASS
    inertia=(1.68e-5, 1.68e-5, 2.98e-5),  # estimate: drone-models, cf2x_P250, copied there from the 2.1
    drag_to_thrust=0.00699,  # firmware, the same: THRUST2TORQUE, 2.1+ propellers
    thrust_lag=0.058,  # drone-models, so_rpy_rotor, cf2x_P250
)

CRAZYFLIE_BRUSHLESS = Vehicle(
    name="crazyflie_brushless",
    mass=0.0393,  # firmware, platform_defaults_cf21bl.h: guards, 350 mAh battery and Lighthouse deck
    inertia=(2.5e-5, 2.8e-5, 4.9e-5),  # estimate: drone-models, cf21B_500, which weighs 43.4 g
    arm=0.050,  # firmware, the same: ARM_LENGTH
    drag_to_thrust=0.00569,  # firmware, the same: THRUST2TORQUE
    thrust_max=4.0 * BRUSHLESS_MOTOR,
    full_pwm_thrust=4.0 * BRUSHLESS_MOTOR,
    thrust_lag=0.021,  # drone-models, so_rpy_rotor, cf21B_500
)

TEXTBOOK_THRUST = 12.753
"""Largest thrust of the textbook vehicle [N]: twice its weight, OS4's thrust-to-weight ratio."""
TEXTBOOK_065 = Vehicle(
    name="textbook_065",
    mass=0.65,  # matches the hover energy of the paper's Tables 6 and 7
    inertia=(7.5e-3, 7.5e-3, 1.3e-2),  # Bouabdallah, PhD thesis EPFL 2007, OS4 vehicle
    arm=0.23,  # the same
    drag_to_thrust=0.024,  # the same: 7.5e-7 / 3.13e-5
    thrust_max=TEXTBOOK_THRUST,
    full_pwm_thrust=TEXTBOOK_THRUST * PWM_FULL / RPYT_PWM_MAX,  # the largest RPYT setpoint gives thrust_max
    thrust_lag=0.0,  # none in the paper's simulation
)

VEHICLES = {
    vehicle.name: vehicle
    for vehicle in (
        CRAZYFLIE_2_0, CRAZYFLIE_2_1, CRAZYFLIE_2_1_PLUS, CRAZYFLIE_BRUSHLESS, TEXTBOOK_065,
    )
}  # fmt: skip
"""Vehicles on stock firmware; `estimate` marks values that were not measured on that vehicle."""


DEFAULT_VEHICLE = CRAZYFLIE_2_0.name
"""Vehicle that tools assume by default: the paper's."""
VEHICLE_OPTION = "--vehicle (in Python vehicle=)"
"""What names the vehicle of recorded flights, in notes and errors of commands and functions."""


def vehicle_by_name(name: str, firmware: str = STOCK) -> Vehicle:
    """Return the named vehicle on a firmware of `thrust_map`; raise ValueError for an unknown name."""
    if name not in VEHICLES:
        raise ValueError(f"unknown vehicle {name!r}; choose one of {', '.join(VEHICLES)}")
    return on_firmware(VEHICLES[name], firmware)


def on_firmware(vehicle: Vehicle, firmware: str) -> Vehicle:
    """Return the vehicle with the maximum thrust of a firmware.

    Raises:
        ValueError: a firmware that the vehicle does not have.
    """
    motor = motor_thrust(vehicle.name, firmware)
    if motor is None:
        return vehicle
    return replace(vehicle, thrust_max=4.0 * motor, full_pwm_thrust=4.0 * motor)


def firmware_of(vehicle: Vehicle) -> str:
    """Return the firmware that matches a vehicle's maximum thrust; empty if there is none."""
    known = MOTOR_THRUST.get(vehicle.name, ())
    return next((name for name in known if on_firmware(vehicle, name) == vehicle), "")


def is_named(vehicle: Vehicle) -> bool:
    """Return whether a vehicle is the one of its name, on one of its firmwares."""
    known = vehicle.name in VEHICLES
    return known and vehicle == vehicle_by_name(vehicle.name, firmware_of(vehicle) or STOCK)
