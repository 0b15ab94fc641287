"""An air as the draws of a recorded flight meet it.

Downwash, residual, edge torque, ground effect, headroom and lag act as in any flight, and gusts.
What differs from flight to flight is that of the recording: the offset of each vehicle, with steady wind in
it (recorded_law), because the recorded commands contain what the integral had learned of it, the headroom
of each vehicle's motors at the flight's voltage, and the drag of the rotors (redrawn_flight).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight
from q2q_sim.loop.scenario_air import gusts_of
from q2q_sim.plant.disturbance import Disturbance
from q2q_sim.plant.swarm import Swarm


@dataclass(frozen=True, slots=True)
class Draw:
    """Vehicles and gusts of one draw."""

    swarm: Swarm
    gusts: Disturbance


MakeDraw = Callable[[int, Array], Draw]
"""Draw of a seed, with the vehicles at rest at x, y, z [m], yaw [rad], (n, 4)."""


def draws_in(air: FlownAir, flight: TrackedFlight, vehicle: Vehicle) -> MakeDraw:
    """Return what makes the draws of a flight in an air."""
    names, dt = flight.names, flight.dt
    if flight.headroom is not None:
        vehicle = replace(
            vehicle, thrust_max=float(flight.headroom.mean(axis=1).max()) * vehicle.hover_thrust
        )

    def make(seed: int, start: Array) -> Draw:
        drawn = replace(air, rotor_drag=None) if isinstance(air, RoomAir) else air
        swarm = Swarm(names, vehicle, start, drawn, seed)
        if flight.headroom is not None and isinstance(drawn, RoomAir):
            swarm.air.room.rotor_max[:] = 0.25 * vehicle.hover_thrust * flight.headroom
        return Draw(swarm, Disturbance(gusts_of(drawn), len(names), dt, seed))

    return make
