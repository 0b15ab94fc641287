"""Physics step of a swarm: all vehicles, and the downwash between them, in one compiled loop.

Each physics step sorts the vehicles by x (insertion sort from the last order, which hardly changes), visits
pairs only while x_j - x_i is within the widest reach of the wake over the swarm's height range, adds their
downwash, then steps every vehicle (q2q_sim.plant.quadcopter). Positions and thrusts of the last 0.4 s are
kept in a ring buffer, one slot a step, for delayed downwash; between slots they are interpolated.
A test compares the kernel with a plain numpy implementation.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, SwarmState, TrackStatus
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.plant.quadcopter import (
    MASS_ROW,
    POS,
    QUAT,
    RATE,
    ROTORS,
    VEL,
    Four,
    advance,
    body_of,
    state_at_rest,
)
from q2q_sim.plant.wake import Wake, delay, max_delay, pair_eta, reach

PHYSICS_RATE = 500
"""Steps of physics and of the onboard attitude loop [1/s]: the Crazyflie firmware's loop rate."""

Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Air:
    """Past states of the sources, for delayed downwash."""

    kind: Wake
    ring: Array
    """x, y, z [m] and T / (m g) at each past step, (slots, n, 4)."""
    rows: Rows
    """Rows by rising x at the last step, then the number of steps taken, (n + 1,); the present is slot
    steps % slots."""


def _seen(ring: Array, steps: int, vehicle: int, late: float) -> Four:
    """Return x, y, z, T / (m g) of a vehicle `late` steps ago."""
    slots = ring.shape[0]
    whole = math.floor(late)
    share = late - whole
    a, b = (steps - whole) % slots, (steps - whole - 1) % slots
    keep = 1.0 - share
    return (
        keep * ring[a, vehicle, 0] + share * ring[b, vehicle, 0],
        keep * ring[a, vehicle, 1] + share * ring[b, vehicle, 1],
        keep * ring[a, vehicle, 2] + share * ring[b, vehicle, 2],
        keep * ring[a, vehicle, 3] + share * ring[b, vehicle, 3],
    )


def _late_downwash(state: Array, ring: Array, steps: int, pair: tuple[int, int], step: float) -> float:
    """Return the measured downwash eta_z [m/s^2] of vehicle j on vehicle i, `pair` = (i, j)."""
    i, j = pair
    late = delay(2, state[j, 2] - state[i, 2]) / step
    x, y, z, share = seen(ring, steps, j, late)
    dx, dy = x - state[i, 0], y - state[i, 1]
    return float(share * pair_eta(2, dx * dx + dy * dy, z - state[i, 2])[0])


def _sort_by_x(state: Array, rows: Rows) -> None:
    for a in range(1, state.shape[0]):
        row = rows[a]
        b = a - 1
        while b >= 0 and state[rows[b], 0] > state[row, 0]:
            rows[b + 1] = rows[b]
            b -= 1
        rows[b + 1] = row


def _downwash(state: Array, ring: Array, rows: Rows, kind: int, step: float) -> None:
    """Write eta_z of every vehicle into its state."""
    n = state.shape[0]
    lowest, highest = state[0, 2], state[0, 2]
    for i in range(n):
        state[i, 20] = 0.0
        lowest, highest = min(lowest, state[i, 2]), max(highest, state[i, 2])
    if kind == 0 or n < 2:
        return
    sort_by_x(state, rows)
    bound = reach(kind, highest - lowest)
    for a in range(n):
        i = rows[a]
        for b in range(a + 1, n):
            j = rows[b]
            dx, dy = state[j, 0] - state[i, 0], state[j, 1] - state[i, 1]
            if dx > bound:
                break
            dz = state[j, 2] - state[i, 2]
            if dx * dx + dy * dy > reach(kind, abs(dz)) ** 2:
                continue
            if kind == 1:
                on_i, on_j = pair_eta(kind, dx * dx + dy * dy, dz)
                state[i, 20] += on_i
                state[j, 20] += on_j
            else:
                state[i, 20] += late_downwash(state, ring, int(rows[n]), (i, j), step)
                state[j, 20] += late_downwash(state, ring, int(rows[n]), (j, i), step)


def _remember(state: Array, ring: Array, slot: int, weight: float) -> None:
    for i in range(state.shape[0]):
        ring[slot, i, 0], ring[slot, i, 1], ring[slot, i, 2] = state[i, 0], state[i, 1], state[i, 2]
        ring[slot, i, 3] = (state[i, 13] + state[i, 14] + state[i, 15] + state[i, 16]) / weight


def _run(state: Array, air: tuple[int, Array, Rows], commands: Array, drive: Array, body: Array) -> None:
    """Advance by one physics step for each row of commands."""
    kind, ring, rows = air
    n = state.shape[0]
    wanted = np.empty(4)
    for k in range(commands.shape[0]):
        downwash(state, ring, rows, kind, body[5, 2])
        for i in range(n):
            command = (commands[k, i, 0], commands[k, i, 1], commands[k, i, 2], commands[k, i, 3])
            advance(state[i], command, drive[i], body, wanted)
        rows[n] += 1
        remember(state, ring, rows[n] % ring.shape[0], body[5, 0] * GRAVITY)


def _downwash_of(state: Array, air: tuple[int, Array, Rows], step: float, eta: Array) -> None:
    kind, ring, rows = air
    downwash(state, ring, rows, kind, step)
    for i in range(state.shape[0]):
        eta[i, 0], eta[i, 1], eta[i, 2] = 0.0, 0.0, state[i, 20]


seen, late_downwash = compiled(_seen), compiled(_late_downwash)
sort_by_x, remember = compiled(_sort_by_x), compiled(_remember)
downwash = compiled(_downwash)
"""Write eta_z of every vehicle: (state, ring, rows, kind, step)."""
downwash_of = compiled(_downwash_of)
"""Write eta [m/s^2] (n, 3) of every vehicle now: (state, (kind, ring, rows), step, eta)."""
run = compiled(_run, nogil=True)
"""Advance by steps: (state, (kind, ring, rows), commands, drive, body); releases the GIL."""


def still_air(state: Array, kind: Wake, body: Array) -> Air:
    """Return the air around vehicles that have always hovered at their present positions."""
    mass, _, step = body[MASS_ROW]
    slots = math.ceil(max_delay(kind) / step) + 2
    now = np.column_stack([state[:, POS], state[:, ROTORS].sum(axis=1) / (mass * GRAVITY)])  # (n, 4)
    order = np.argsort(state[:, 0], kind="stable")
    return Air(kind, np.tile(now, (slots, 1, 1)), np.append(order, 0).astype(np.int64))


class Swarm:
    """Vehicles of a room and their states."""

    def __init__(self, names: Names, vehicle: Vehicle, start: Array, wake: Wake) -> None:
        """Place vehicles at rest at `start` (n, 4): x, y, z [m], yaw [rad]."""
        self.names = names
        self.body = body_of(vehicle, AttitudeParams(), 1.0 / PHYSICS_RATE)
        self.state = state_at_rest(start, vehicle.mass)
        self.air = still_air(self.state, wake, self.body)
        self._air = (int(wake), self.air.ring, self.air.rows)
        self._age = np.zeros(len(names))  # all states share these two
        self._tracked = np.full(len(names), int(TrackStatus.TRACKED), dtype=np.uint8)
        self._age.flags.writeable = self._tracked.flags.writeable = False

    def step(self, commands: Array, drive: Array) -> None:
        """Advance by one physics step for each row of `commands`.

        Args:
            commands: thrust [N], roll, pitch [rad], yaw rate [rad/s] of each vehicle, (steps, n, 4).
            drive: acceleration by moving air [m/s^2], world, then the gain of each rotor, (n, 7).
        """
        run(self.state, self._air, commands, drive, self.body)

    def downwash(self) -> Array:
        """Return eta of every vehicle now [m/s^2], world, (n, 3)."""
        eta = np.empty((len(self.names), 3))
        downwash_of(self.state, self._air, 1.0 / PHYSICS_RATE, eta)
        return eta

    def truth(self, t: float) -> SwarmState:
        """Return the true state, stamped t [s]."""
        now = self.state.copy()
        return SwarmState(
            t=t,
            names=self.names,
            pos=now[:, POS],
            vel=now[:, VEL],
            quat=now[:, QUAT],
            ang_vel_body=now[:, RATE],
            age=self._age,
            status=self._tracked,
        )
