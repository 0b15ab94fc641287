"""Air of other families than the models that controllers may know (q2q_model.downwash: a Gaussian jet).

Each has the measured law's largest push at every height difference (q2q_sim.air.wake_laws), 2.5 m/s^2 at
0.4 m, its travel at 7.5 m/s and its 2 % for the upper vehicle.

| name | differs in |
|---|---|
| heavy_tailed | profile (1 + r^2 / w^2)^-2, w = 2 s: the Gaussian's curvature on the axis, slower decay |
| ring | jets of four rotors, each of standard deviation 3 cm, 46 mm from the centre, averaged over the yaw |
| bent | a crosswind carries the axis by 5 cm at dz = 0.5 m, towards +x |
| meandering | the axis wanders: 2 cm rms at dz = 0.5 m, correlation time 0.3 s |
"""

from collections.abc import Callable

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air import wake_laws as law
from q2q_sim.air.air_terms import JetTerm, MeanderTerm
from q2q_sim.air.room_air import RoomAir

GAPS = np.linspace(0.1, 1.5, 29)
"""[m]: every 5 cm."""
RADII = np.concatenate([np.linspace(0.0, 0.2, 41), np.linspace(0.21, 0.6, 40)])
"""[m]: every 5 mm, farther out every 1 cm."""
ROTOR_STD = 0.03
"""Width of the jet of one rotor [m]."""
YAWS = np.linspace(0.0, 0.5 * np.pi, 32, endpoint=False)
"""[rad]; four rotors repeat after a quarter of a turn."""
BEND = 0.05 / 0.5
"""[m/m]"""
MEANDER = MeanderTerm(std=0.02 / 0.5, time_s=0.3)


def synthetic_air(name: str) -> RoomAir:
    """Return one of air_names.SYNTHETIC."""
    return _MADERS[name]()


def _width(gap: Array) -> Array:
    """Return s [m] of the measured law."""
    return np.asarray(np.maximum(law.MEASURED_S + law.MEASURED_KS * (gap - law.MEASURED_DZ), law.NARROWEST))


def _jet(profile: Array, bend: tuple[float, float] = (0.0, 0.0)) -> JetTerm:
    """Return a jet whose profile (a, b) is scaled to the measured peak at every gap."""
    peak = law.MEASURED_A * np.exp(-law.MEASURED_BETA * (GAPS - law.MEASURED_DZ))
    push = peak[:, None] * profile / profile.max(axis=1, keepdims=True)
    push[:, -1] = 0.0
    return JetTerm(
        gaps_m=GAPS,
        radii_m=RADII,
        push_mps2=push,
        upper_ratio=law.MEASURED_UPPER,
        travel_speed_mps=law.MEASURED_SPEED,
        carried=0.0,
        slope=0.0,
        bend=bend,
    )


def _gaussian() -> Array:
    return np.asarray(np.exp(-0.5 * (RADII / _width(GAPS)[:, None]) ** 2))


def _heavy_tailed() -> RoomAir:
    width = 2.0 * _width(GAPS)[:, None]
    return RoomAir(jet=_jet((1.0 + (RADII / width) ** 2) ** -2.0))


def _ring() -> RoomAir:
    arm = CRAZYFLIE_2_0.arm
    squared = RADII[:, None] ** 2 + arm**2 - 2.0 * RADII[:, None] * arm * np.cos(YAWS)  # (b, yaws)
    profile = np.exp(-0.5 * squared / ROTOR_STD**2).mean(axis=1)
    return RoomAir(jet=_jet(np.tile(profile, (len(GAPS), 1))))


def _bent() -> RoomAir:
    return RoomAir(jet=_jet(_gaussian(), (BEND, 0.0)))


def _meandering() -> RoomAir:
    return RoomAir(jet=_jet(_gaussian()), meander=MEANDER)


_MADERS: dict[str, Callable[[], RoomAir]] = {
    "heavy_tailed": _heavy_tailed,
    "ring": _ring,
    "bent": _bent,
    "meandering": _meandering,
}
