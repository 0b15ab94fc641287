"""Push and torque of a room's air on every vehicle, compiled: the equations of q2q_sim.air.room_air.

After the jets (jet_push.py), each vehicle feels the residual, the ground and the drag of its rotors, whose
largest thrusts the load of its rates lowers. `state` is (n, STATE_WIDTH) of state_row.py; `ring` and `rows`
are those of an Air (swarm_air.py).
"""

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Rows
from q2q_sim.air.air_terms import INSIDE
from q2q_sim.air.unit_processes import RESIDUAL
from q2q_sim.plant.body.rotors import rotor_torque
from q2q_sim.plant.body.state_row import (
    ETA_X,
    ETA_Y,
    ETA_Z,
    F1,
    F2,
    F3,
    F4,
    QW,
    QX,
    QY,
    QZ,
    ROTOR_MAX1,
    ROTOR_MAX2,
    ROTOR_MAX3,
    ROTOR_MAX4,
    TX,
    TY,
    VX,
    VY,
    VZ,
    P,
    Q,
    Z,
)
from q2q_sim.plant.push.compiled_room_air import CompiledRoomAir, RoomNumbers
from q2q_sim.plant.push.jet_push import add_jets


@compiled(**HOT)
def add_residual(state: Array, i: int, unit: float, one: RoomNumbers) -> None:
    """Add the turbulence of the jets, `unit` its process [-], to the push on vehicle i [m/s^2]."""
    eta = abs(state[i, ETA_Z])
    state[i, ETA_Z] += (one.floor * min(eta / INSIDE, 1.0) + one.growth * eta) * unit


@compiled(**HOT)
def add_ground_effect(state: Array, i: int, one: RoomNumbers, mass: float) -> None:
    """Add the ground effect to the push on vehicle i [m/s^2]; no jet pushes along x and y."""
    near = one.rotor_radius / max(state[i, Z], one.ground_from)
    lift = one.ground * near * near * (state[i, F1] + state[i, F2] + state[i, F3] + state[i, F4]) / mass
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    state[i, ETA_X] = lift * 2.0 * (x * z + w * y)
    state[i, ETA_Y] = lift * 2.0 * (y * z - w * x)
    state[i, ETA_Z] += lift * (1.0 - 2.0 * (x * x + y * y))


@compiled(**HOT)
def add_rotor_drag(state: Array, i: int, per_s: float) -> None:
    """Add the drag of the rotors, k = `per_s` [1/s], to the push on vehicle i [m/s^2].

    It acts against its velocity across its thrust.
    """
    x, y, z, w = state[i, QX], state[i, QY], state[i, QZ], state[i, QW]
    bx, by, bz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    vx, vy, vz = state[i, VX], state[i, VY], state[i, VZ]
    along = vx * bx + vy * by + vz * bz
    state[i, ETA_X] -= per_s * (vx - along * bx)
    state[i, ETA_Y] -= per_s * (vy - along * by)
    state[i, ETA_Z] -= per_s * (vz - along * bz)


@compiled(**HOT)
def subtract_rate_load(state: Array, i: int, one: RoomNumbers) -> None:
    """Subtract the load of vehicle i's rates, ahead by the lag of thrust, from its largest thrusts [N]."""
    rotors = state[i, F1], state[i, F2], state[i, F3], state[i, F4]
    tx, ty, _ = rotor_torque(rotors, one.lever, 0.0)
    roll = one.rate_load * (state[i, P] + one.roll_lead * (tx + state[i, TX]))
    pitch = one.rate_load * (state[i, Q] + one.pitch_lead * (ty + state[i, TY]))
    state[i, ROTOR_MAX1] += roll + pitch
    state[i, ROTOR_MAX2] += roll - pitch
    state[i, ROTOR_MAX3] -= roll + pitch
    state[i, ROTOR_MAX4] -= roll - pitch


@compiled(**HOT)
def clear_push(state: Array, rotor_max: Array, faded: float) -> None:
    """Write no push, no torque and `rotor_max` (n, 4) [N], less what `faded` [N], into every state."""
    for i in range(state.shape[0]):
        for column in range(ETA_Z, ROTOR_MAX1):
            state[i, column] = 0.0
        for rotor in range(4):
            state[i, ROTOR_MAX1 + rotor] = max(rotor_max[i, rotor] - faded, 0.0)


@compiled(**HOT)
def room_air_push(state: Array, ring: Array, rows: Rows, room: CompiledRoomAir, mass: float) -> None:
    """Write push, torque and largest rotor thrust of every vehicle; `mass` in [kg]."""
    n, one, unit = state.shape[0], room.numbers, room.unit
    clear_push(state, room.rotor_max, one.fading * one.step * float(rows[n]))
    if n > 1 and room.bound.near > 0.0:
        add_jets(state, ring, rows, room)
    tick = rows[n] % unit.shape[1]
    for i in range(n):
        add_residual(state, i, unit[RESIDUAL, tick, i], one)
        add_ground_effect(state, i, one, mass)
        if one.drag != 0.0:
            add_rotor_drag(state, i, one.drag)
        if one.rate_load != 0.0:
            subtract_rate_load(state, i, one)
