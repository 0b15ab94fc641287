"""An air as the draws of a recorded flight meet it.

Downwash, residual, edge torque, ground effect, headroom and lag act as in any flight, gusts as moving air.
What differs from flight to flight is that of the recording: the offset of each vehicle, with steady wind in
it (onboard_law), because the recorded commands contain what the integral had learned of it, and the headroom
of the motors at the flight's voltage.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.find_air import FlownAir
from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.validation.tracked_flight import TrackedFlight
from q2q_sim.plant.disturbance import Disturbance, DisturbanceParams
from q2q_sim.plant.swarm import Swarm


@dataclass(frozen=True, slots=True)
class Draw:
    """Vehicles and moving air of one draw."""

    swarm: Swarm
    gusts: Disturbance


MakeDraw = Callable[[int, Array], Draw]
"""Draw of a seed, with the vehicles at rest at x, y, z [m], yaw [rad], (n, 4)."""


def draws_in(air: FlownAir, flight: TrackedFlight, vehicle: Vehicle) -> MakeDraw:
    """Return what makes the draws of a flight in an air."""
    names, dt = flight.names, flight.dt
    if flight.headroom is not None:
        vehicle = replace(vehicle, thrust_max=flight.headroom * vehicle.hover_thrust)
        if isinstance(air, RoomAir) and air.vehicle is not None:
            air = replace(air, vehicle=replace(air.vehicle, headroom=flight.headroom))
    wind = air.wind if isinstance(air, RoomAir) else None
    params = DisturbanceParams()
    if wind is not None:
        params = DisturbanceParams(air_std=wind.gust_std_mps2, air_time=wind.gust_time_s)

    def make(seed: int, start: Array) -> Draw:
        return Draw(Swarm(names, vehicle, start, air, seed), Disturbance(params, len(names), dt, seed))

    return make
