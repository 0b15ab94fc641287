"""Air of a scenario's flight: wake or air by name, wind, and offsets of the vehicles."""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array
from q2q_sim.air.lookup.find_air import FlownAir, find_air
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake_laws import wake_by_name
from q2q_sim.plant.disturbance import STILL, Disturbance, DisturbanceParams
from q2q_sim.random_streams import stream
from q2q_sim.scenarios.scenario import Scenario


def air_of(scenario: Scenario) -> FlownAir:
    """Return the scenario's air, else its wake.

    Raises:
        AirError: the air does not exist, or is not valid.
    """
    if scenario.air:
        return find_air(scenario.air, scenario.air_without)
    return wake_by_name(scenario.wake)


def air_description(scenario: Scenario) -> str:
    """Return the air and the terms that are off, for the metadata of a bag; empty if it flies in a wake."""
    off = "".join(f" without {term}" for term in scenario.air_without)
    return f"{scenario.air}{off}"


@dataclass(frozen=True, slots=True)
class AmbientDisturbance:
    """What the vehicles of a flight feel wherever they are."""

    disturbance: Disturbance
    offset: Array
    """Vertical acceleration of each vehicle by its own offset [m/s^2], (n,)."""
    recorded: bool
    """Whether the wind is part of the recorded push of the air."""

    def drive(self) -> Array:
        """Return the drive of this tick, (n, 7), and advance the wind by one tick."""
        drive = self.disturbance.step()
        if self.recorded:
            drive[:, 2] += self.offset
        return drive

    def push(self, downwash: Array) -> Array:
        """Return the whole push of the air now [m/s^2], world, (n, 3), given that of downwash and ground."""
        return downwash + self.disturbance.wind if self.recorded else downwash


def ambient_of_air(air: FlownAir, count: int, seed: int) -> AmbientDisturbance:
    """Return the disturbance of `count` vehicles in an air."""
    own, mean, params = None, STILL, gusts_of(air)
    if isinstance(air, RoomAir):
        own = air.vehicle
        if air.wind is not None:
            mean = air.wind.mean_mps2
    drawn = stream(seed, "vehicle offset").standard_normal(count)
    offset = np.zeros(count) if own is None else own.offset_mean_mps2 + own.offset_std_mps2 * drawn
    return AmbientDisturbance(Disturbance(params, count, TICK_S, seed, mean), offset, recorded=True)


def gusts_of(air: FlownAir) -> DisturbanceParams:
    """Return the gusts of an air, without its steady wind."""
    if not isinstance(air, RoomAir) or air.wind is None:
        return DisturbanceParams()
    return DisturbanceParams(air_std=air.wind.gust_std_mps2, air_time=air.wind.gust_time_s)


def ambient_of_scenario(scenario: Scenario, seed: int) -> AmbientDisturbance:
    """Return a scenario's own disturbance; it is not part of the recorded push."""
    n = len(scenario.names)
    return AmbientDisturbance(Disturbance(scenario.disturbance, n, TICK_S, seed), np.zeros(n), recorded=False)
