"""Disturbances of a real room: wind, and rotors that give slightly less thrust than commanded.

Wind: a steady one, and gusts, an Ornstein-Uhlenbeck acceleration a on each axis (q2q_sim.ornstein_uhlenbeck).

Rotors: each vehicle gives a fraction k of its thrust, drawn once per flight. Real flights show k of 0.97 to
0.99, a constant offset of (1 - k) g = 0.1 to 0.3 m/s^2.

| symbol | name | meaning [unit] |
|---|---|---|
| sigma | air_std | standard deviation of a [m/s^2] |
| T | air_time | correlation time [s] |
| k | thrust_gain | [-] |
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Three
from q2q_model.tunable import check_bounds, tunable
from q2q_sim.ornstein_uhlenbeck import ExactStep, advance_processes, exact_step
from q2q_sim.random_streams import DrawnAhead, stream

STILL = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class DisturbanceParams:
    """Size of gusts and rotor errors; the defaults are still air and perfect rotors."""

    air_std: float = tunable(
        0.0, "standard deviation of the acceleration by gusts", unit="m/s^2", low=0.0, high=10.0
    )
    air_time: float = tunable(
        1.0, "correlation time of the acceleration by gusts", unit="s", low=1e-3, high=100.0
    )
    thrust_gain_min: float = tunable(1.0, "smallest rotor gain", low=0.5, high=1.5)
    thrust_gain_max: float = tunable(1.0, "largest rotor gain", low=0.5, high=1.5)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)
        if self.thrust_gain_min > self.thrust_gain_max:
            raise ValueError(
                f"DisturbanceParams.thrust_gain_min = {self.thrust_gain_min} is above "
                f"thrust_gain_max = {self.thrust_gain_max}"
            )


class Disturbance:
    """Wind and rotor gains of the vehicles of a flight."""

    def __init__(
        self, params: DisturbanceParams, vehicles: int, tick: float, seed: int, mean: Three = STILL
    ) -> None:
        """Draw the rotor gains of `vehicles` vehicles.

        Args:
            params: size of the disturbances.
            vehicles: their number.
            tick: sample time [s].
            seed: seed of the flight.
            mean: acceleration by steady wind [m/s^2], world.
        """
        self._normal = DrawnAhead(stream(seed, "air").standard_normal, (vehicles, 3)).next
        self._std = params.air_std
        self._mean, self._steady = np.array(mean), any(mean)
        self._weights = exact_step(tick, params.air_time, params.air_std)
        gain = stream(seed, "thrust gain").uniform(
            params.thrust_gain_min, params.thrust_gain_max, (vehicles, 1)
        )
        air = self._std * self._normal()
        self.drive = np.hstack([air, np.repeat(gain, 4, axis=1)])
        """Acceleration by gusts [m/s^2], world, then the gain of each rotor, (n, 7)."""

    @property
    def wind(self) -> Array:
        """Return the acceleration by wind now [m/s^2], world, (n, 3)."""
        return np.asarray(self.drive[:, :3] + self._mean)

    def step(self) -> Array:
        """Return the drive of this tick, (n, 7), and advance the gusts by one tick."""
        now = self.drive.copy()
        if self._std > 0.0:
            advance_gusts(self.drive, self._normal(), self._weights)
        if self._steady:
            now[:, :3] += self._mean
        return now


@compiled
def advance_gusts(drive: Array, normal: Array, weights: ExactStep) -> None:
    """Advance the gusts of a drive (n, 7) by one tick, by standard normal deviates (n, 3)."""
    for i in range(len(drive)):
        advance_processes(drive[i, :3], normal[i], weights)
