"""Physics of a swarm in plain numpy: reference of a test and of benchmarks for `q2q_sim.plant.swarm`.

Written apart from the compiled loop: all vehicles at once, all pairs dense, rotations by
q2q_model.geometry.rotations, rotors by q2q_control.attitude.allocation, the downwash from the equations of
q2q_sim.air.wake_laws.
"""

import numpy as np
from numpy.typing import NDArray

from q2q_control.attitude.allocation import RotorFrame, rotors_of, wrench_of
from q2q_control.attitude.attitude_law import attitude_torques
from q2q_model.geometry.rotations import euler_from_quat, integrate_quat, normalised, quat_from_euler, rotate
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air import wake_laws as law
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.body.quadcopter import Body
from q2q_sim.plant.body.state_row import ACC, ETA_Z, POS, QUAT, RATE, ROTORS, VEL, VZ, Z
from q2q_sim.plant.swarm_air import Air


def run_numpy(state: Array, air: Air, commands: Array, drive: Array, body: Body) -> None:
    """Advance by one physics step for each row of commands, changing state and air in place.

    Arguments as of Swarm.step; state (n, STATE_WIDTH) and body as of q2q_sim.plant.body.quadcopter.
    """
    mass, decay, h = body.mass, body.decay, body.step
    for command in commands:  # (n, 4)
        state[:, ETA_Z] = downwash_numpy(state, air, h)
        commanded = drive[:, 3:] * _commanded_rotors(state, command, body)
        state[:, ROTORS] = commanded + (state[:, ROTORS] - commanded) * decay
        before = state[:, POS].copy()
        _move(state, drive[:, :3], body)
        _stand(state, before, h)
        air.rows[-1] += 1
        thrust_ratio = state[:, ROTORS].sum(axis=1) / (mass * GRAVITY)
        air.ring[air.rows[-1] % len(air.ring)] = np.column_stack([state[:, POS], thrust_ratio])


def downwash_numpy(state: Array, air: Air, h: float) -> Array:
    """Return eta_z [m/s^2], (n,), from all pairs; `h` is the physics step [s]."""
    n = len(state)
    eta = np.zeros(n)
    if air.kind == WakeLaw.NONE or n < 2:
        return eta
    i, j = (rows[~np.eye(n, dtype=bool)] for rows in np.indices((n, n)))  # every i != j
    rel = state[j, POS] - state[i, POS]  # (pairs, 3)
    near = np.hypot(rel[:, 0], rel[:, 1]) <= _reach(WakeLaw(air.kind), np.abs(rel[:, 2]))
    thrust_ratio = np.ones(len(rel))
    if air.kind == WakeLaw.MEASURED:
        source = _seen(air, j, _delay(rel[:, 2]) / h)  # (pairs, 4)
        rel, thrust_ratio = source[:, :3] - state[i, POS], source[:, 3]
    np.add.at(eta, i, np.where(near, thrust_ratio * _eta_z(WakeLaw(air.kind), rel), 0.0))
    return eta


def _reach(kind: WakeLaw, gap: Array) -> Array:
    travel = law.FASTEST * _delay(gap) if kind == WakeLaw.MEASURED else 0.0
    return law.EDGE * _width(kind, gap) + travel


def _width(kind: WakeLaw, gap: Array) -> Array:
    if kind == WakeLaw.PAPER:
        return law.PAPER_S0 + law.PAPER_KS * gap
    return np.maximum(law.MEASURED_S + law.MEASURED_KS * (gap - law.MEASURED_DZ), law.NARROWEST)


def _delay(dz: Array) -> Array:
    return np.clip(dz / law.MEASURED_SPEED, 0.0, law.MAX_DELAY)


def _eta_z(kind: WakeLaw, rel: Array) -> Array:
    gap, squared = np.abs(rel[:, 2]), rel[:, 0] ** 2 + rel[:, 1] ** 2
    width = _width(kind, gap)
    profile = np.where(squared > (law.EDGE * width) ** 2, 0.0, np.exp(-squared / (2.0 * width * width)))
    if kind == WakeLaw.PAPER:
        axial = law.PAPER_A * ((law.PAPER_Z0 + law.PAPER_DZ) / (law.PAPER_Z0 + gap)) ** 2
    else:
        axial = law.MEASURED_A * np.exp(-law.MEASURED_BETA * (gap - law.MEASURED_DZ))
    upper = law.PAPER_UPPER if kind == WakeLaw.PAPER else law.MEASURED_UPPER
    along = np.clip(0.5 * (rel[:, 2] / law.BLEND + 1.0), 0.0, 1.0)
    lower_share = along**2 * (3.0 - 2.0 * along)
    return np.asarray(axial * profile * ((1.0 - lower_share) * upper - lower_share))


def _seen(air: Air, vehicle: NDArray[np.intp], late: Array) -> Array:
    whole = np.floor(late).astype(np.intp)
    share = (late - whole)[:, None]
    slots, now = len(air.ring), air.rows[-1]
    after, before = air.ring[(now - whole) % slots, vehicle], air.ring[(now - whole - 1) % slots, vehicle]
    return np.asarray((1.0 - share) * after + share * before)


def _commanded_rotors(state: Array, command: Array, body: Body) -> Array:
    frame = RotorFrame(*body.frame)
    torque_now = wrench_of(state[:, ROTORS], frame)[:, 1:]
    attitude = euler_from_quat(state[:, QUAT])
    torque = attitude_torques(attitude, state[:, RATE], torque_now, command[:, 1:], body.gains)
    commanded = rotors_of(np.column_stack([command[:, 0], torque]), frame)
    return np.where(command[:, :1] > 0.0, commanded, 0.0)


def _move(state: Array, moving_air: Array, body: Body) -> None:
    mass, h, inertia = body.mass, body.step, np.asarray(body.gains.inertia)
    wrench = wrench_of(state[:, ROTORS], RotorFrame(*body.frame))
    up = np.array([0.0, 0.0, 1.0])
    thrust_acc = rotate(state[:, QUAT], wrench[:, :1] / mass * up)
    state[:, ACC] = thrust_acc + moving_air + (state[:, ETA_Z, None] - GRAVITY) * up
    before = state[:, VEL].copy()
    state[:, VEL] += h * state[:, ACC]
    state[:, POS] += 0.5 * h * (before + state[:, VEL])
    rate = state[:, RATE].copy()
    state[:, RATE] += h * (wrench[:, 1:] - np.cross(rate, inertia * rate)) / inertia
    state[:, QUAT] = normalised(integrate_quat(state[:, QUAT], state[:, RATE], h))


def _stand(state: Array, before: Array, h: float) -> None:
    below = state[:, Z] < 0.0
    stood = below & (before[:, 2] == 0.0)
    state[stood, POS] = before[stood]
    after = np.zeros((len(state), 3))
    after[:, 2] = np.maximum(state[:, VZ], 0.0)
    state[below, ACC] += (after - state[:, VEL])[below] / h
    state[below, VEL] = after[below]
    state[below, RATE] = 0.0
    state[below, Z] = 0.0
    yaw = euler_from_quat(state[:, QUAT])[below, 2]
    state[below, QUAT] = quat_from_euler(np.zeros_like(yaw), np.zeros_like(yaw), yaw)
