"""Physics step of a swarm: all vehicles, and the downwash between them, in one compiled loop.

Each physics step sorts the vehicles by x (insertion sort from the last order, which hardly changes), visits
pairs only while x_j - x_i is within the widest reach of the wake over the swarm's height range, adds their
downwash, then steps every vehicle (q2q_sim.plant.quadcopter). Positions and thrusts of the last 0.4 s are
kept in a ring buffer, one slot a step, for delayed downwash; between slots they are interpolated.
A test compares the kernel with a plain numpy implementation.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, SwarmState, TrackStatus
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.air.wake_laws import MEASURED, NONE, PAPER, WakeLaw, delay, max_delay, pair_eta, reach
from q2q_sim.plant.quadcopter import (
    ETA,
    F1,
    F2,
    F3,
    F4,
    POS,
    QUAT,
    RATE,
    ROTORS,
    VEL,
    Body,
    Four,
    X,
    Y,
    Z,
    advance,
    body_of,
    state_at_rest,
)

PHYSICS_RATE = 500
"""Steps of physics and of the onboard attitude loop [1/s]: the Crazyflie firmware's loop rate."""

SHARE = 3
"""Column of T / (m g) in a slot of the ring, after x, y, z [m]."""

Rows = NDArray[np.int64]


class Air(NamedTuple):
    """Past states of the sources, for delayed downwash."""

    kind: int
    """WakeLaw."""
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
        keep * ring[a, vehicle, X] + share * ring[b, vehicle, X],
        keep * ring[a, vehicle, Y] + share * ring[b, vehicle, Y],
        keep * ring[a, vehicle, Z] + share * ring[b, vehicle, Z],
        keep * ring[a, vehicle, SHARE] + share * ring[b, vehicle, SHARE],
    )


def _late_downwash(state: Array, ring: Array, steps: int, pair: tuple[int, int], step: float) -> float:
    """Return the measured downwash eta_z [m/s^2] of vehicle j on vehicle i, `pair` = (i, j)."""
    i, j = pair
    late = delay(MEASURED, state[j, Z] - state[i, Z]) / step
    x, y, z, share = seen(ring, steps, j, late)
    dx, dy = x - state[i, X], y - state[i, Y]
    return float(share * pair_eta(MEASURED, dx * dx + dy * dy, z - state[i, Z])[0])


def _sort_by_x(state: Array, rows: Rows) -> None:
    for a in range(1, state.shape[0]):
        row = rows[a]
        b = a - 1
        while b >= 0 and state[rows[b], X] > state[row, X]:
            rows[b + 1] = rows[b]
            b -= 1
        rows[b + 1] = row


def _downwash(state: Array, ring: Array, rows: Rows, kind: int, step: float) -> None:
    """Write eta_z of every vehicle into its state."""
    n = state.shape[0]
    lowest, highest = state[0, Z], state[0, Z]
    for i in range(n):
        state[i, ETA] = 0.0
        lowest, highest = min(lowest, state[i, Z]), max(highest, state[i, Z])
    if kind == NONE or n < 2:
        return
    sort_by_x(state, rows)
    bound = reach(kind, highest - lowest)
    for a in range(n):
        i = rows[a]
        for b in range(a + 1, n):
            j = rows[b]
            dx, dy = state[j, X] - state[i, X], state[j, Y] - state[i, Y]
            if dx > bound:
                break
            dz = state[j, Z] - state[i, Z]
            if dx * dx + dy * dy > reach(kind, abs(dz)) ** 2:
                continue
            if kind == PAPER:
                on_i, on_j = pair_eta(kind, dx * dx + dy * dy, dz)
                state[i, ETA] += on_i
                state[j, ETA] += on_j
            else:
                state[i, ETA] += late_downwash(state, ring, int(rows[n]), (i, j), step)
                state[j, ETA] += late_downwash(state, ring, int(rows[n]), (j, i), step)


def _remember(state: Array, ring: Array, slot: int, weight: float) -> None:
    for i in range(state.shape[0]):
        ring[slot, i, X], ring[slot, i, Y], ring[slot, i, Z] = state[i, X], state[i, Y], state[i, Z]
        ring[slot, i, SHARE] = (state[i, F1] + state[i, F2] + state[i, F3] + state[i, F4]) / weight


def _run(state: Array, air: Air, commands: Array, drive: Array, body: Body) -> None:
    """Advance by one physics step for each row of commands."""
    kind, ring, rows = air
    n = state.shape[0]
    wanted = np.empty(4)
    for k in range(commands.shape[0]):
        downwash(state, ring, rows, kind, body.step)
        for i in range(n):
            command = (commands[k, i, 0], commands[k, i, 1], commands[k, i, 2], commands[k, i, 3])
            advance(state[i], command, drive[i], body, wanted)
        rows[n] += 1
        remember(state, ring, rows[n] % ring.shape[0], body.mass * GRAVITY)


def _downwash_of(state: Array, air: Air, step: float, eta: Array) -> None:
    kind, ring, rows = air
    downwash(state, ring, rows, kind, step)
    for i in range(state.shape[0]):
        eta[i, 0], eta[i, 1], eta[i, 2] = 0.0, 0.0, state[i, ETA]


seen, late_downwash = compiled(_seen), compiled(_late_downwash)
sort_by_x, remember = compiled(_sort_by_x), compiled(_remember)
downwash = compiled(_downwash)
"""Write eta_z of every vehicle: (state, ring, rows, kind, step)."""
downwash_of = compiled(_downwash_of)
"""Write eta [m/s^2] (n, 3) of every vehicle now: (state, air, step, eta)."""
run = compiled(_run, nogil=True)
"""Advance by steps: (state, air, commands, drive, body); releases the GIL."""


def still_air(state: Array, kind: WakeLaw, body: Body) -> Air:
    """Return the air around vehicles that have always hovered at their present positions."""
    slots = math.ceil(max_delay(kind) / body.step) + 2
    now = np.column_stack([state[:, POS], state[:, ROTORS].sum(axis=1) / (body.mass * GRAVITY)])  # (n, 4)
    order = np.argsort(state[:, X], kind="stable")
    return Air(int(kind), np.tile(now, (slots, 1, 1)), np.append(order, 0).astype(np.int64))


class Swarm:
    """Vehicles of a room and their states."""

    def __init__(self, names: Names, vehicle: Vehicle, start: Array, wake: WakeLaw) -> None:
        """Place vehicles at rest at `start` (n, 4): x, y, z [m], yaw [rad]."""
        self.names = names
        self.body = body_of(vehicle, AttitudeParams(), 1.0 / PHYSICS_RATE)
        self.state = state_at_rest(start, vehicle.mass)
        self.air = still_air(self.state, wake, self.body)
        self._age = np.zeros(len(names))  # all states share these two
        self._tracked = np.full(len(names), int(TrackStatus.TRACKED), dtype=np.uint8)
        self._age.flags.writeable = self._tracked.flags.writeable = False

    def step(self, commands: Array, drive: Array) -> None:
        """Advance by one physics step for each row of `commands`.

        Args:
            commands: thrust [N], roll, pitch [rad], yaw rate [rad/s] of each vehicle, (steps, n, 4).
            drive: acceleration by moving air [m/s^2], world, then the gain of each rotor, (n, 7).
        """
        run(self.state, self.air, commands, drive, self.body)

    def downwash(self) -> Array:
        """Return eta of every vehicle now [m/s^2], world, (n, 3)."""
        eta = np.empty((len(self.names), 3))
        downwash_of(self.state, self.air, 1.0 / PHYSICS_RATE, eta)
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
