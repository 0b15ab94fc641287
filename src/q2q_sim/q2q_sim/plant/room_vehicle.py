"""Vehicle of a room: what its air has learned of its vehicles, else the constants of the plant."""

import math
from dataclasses import replace

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.air.room_air import RoomAir
from q2q_sim.plant.body.quadcopter import Body, body_of


def vehicle_of_room(air: FlownAir, vehicle: Vehicle) -> Vehicle:
    """Return the vehicle with thrust lag and largest thrust of a room's vehicles."""
    if not isinstance(air, RoomAir) or air.vehicle is None:
        return vehicle
    own = air.vehicle
    return replace(vehicle, thrust_lag=own.thrust_lag_s, thrust_max=own.headroom * vehicle.hover_thrust)


def body_of_room(air: FlownAir, vehicle: Vehicle, step: float) -> Body:
    """Return the constants of a vehicle in an air, for steps of `step` [s].

    Each rotor of a room's vehicles is limited by its own largest thrust, and by nothing else.
    """
    body = body_of(vehicle_of_room(air, vehicle), attitude_loop_of_room(air), step)
    if not isinstance(air, RoomAir) or air.vehicle is None:
        return body
    lever, drag, _ = body.frame
    return body._replace(frame=(lever, drag, math.inf))


def attitude_loop_of_room(air: FlownAir) -> AttitudeParams:
    """Return the attitude loop of a room's vehicles, else that of the plant."""
    if not isinstance(air, RoomAir) or air.vehicle is None:
        return AttitudeParams()
    own = air.vehicle
    return AttitudeParams(
        frequency=own.attitude_frequency, damping=own.attitude_damping, lead_ratio=own.attitude_lead_ratio
    )
