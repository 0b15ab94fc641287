"""Physics step of a swarm: all vehicles, and the air between them, in one compiled loop.

Each physics step finds the push of the air on every vehicle (swarm_air.py), then steps every vehicle
(body/vectorised_step.py). A test compares the kernel with plain numpy (benchmarks/swarm_numpy.py).
"""

import sys

import numpy as np

from q2q_control.attitude.attitude_law import AttitudeGains, AttitudeParams, AxisValues, attitude_gains
from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array, Names, Rows, SwarmState, Three, TrackStatus
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.unit_processes import UnitProcesses
from q2q_sim.air.wake import AirSetup
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.body.quadcopter import Body
from q2q_sim.plant.body.state_row import ETA_X, ETA_Y, ETA_Z, POS, QUAT, RATE, VEL, state_at_rest
from q2q_sim.plant.body.vectorised_step import BLOCK_WIDTH, LANES, advance_rows
from q2q_sim.plant.push.state_history_ring import remember
from q2q_sim.plant.push.uncompiled_wake import UncompiledWake
from q2q_sim.plant.push.wake_law_push import wake_law_push
from q2q_sim.plant.room_vehicle import body_of_room, vehicle_of_room
from q2q_sim.plant.swarm_air import Air, air_push, still_air

PHYSICS_RATE = 500
"""Steps of physics and of the onboard attitude loop [1/s]: the Crazyflie firmware's loop rate."""

LawAir = tuple[int, Array, Rows]
"""Kind, ring and rows of an Air: all that a wake law needs, as numba looks at every number in each call."""
PlainBody = tuple[tuple[AxisValues, AxisValues, AxisValues, float], Three, float, float, float]
"""Fields of a Body, which numba takes in a third of the time."""


@compiled(nogil=True)
def run_steps(state: Array, air: Air, commands: Array, drive: Array, body: Body) -> None:
    """Advance by one physics step for each row of commands; releases the GIL.

    `state` (n, STATE_WIDTH) changes in place; commands and drive are as in Swarm.step.
    """
    work = (np.zeros(BLOCK_WIDTH * LANES), np.zeros(4))
    for k in range(commands.shape[0]):
        air_push(state, air, body)
        advance_rows(state, commands[k], drive, body, work)
        remember(state, air.ring, air.rows, body.mass * GRAVITY)


@compiled(nogil=True)
def run_in_law(state: Array, air: LawAir, commands: Array, drive: Array, body: PlainBody) -> None:
    """Do as `run_steps` in the air of a wake law: for ten vehicles in two thirds of the time."""
    work = (np.zeros(BLOCK_WIDTH * LANES), np.zeros(4))
    (kind, ring, rows), (gains, frame, mass, decay, step) = air, body
    whole = Body(AttitudeGains(*gains), frame, mass, decay, step)
    for k in range(commands.shape[0]):
        wake_law_push(state, ring, rows, kind, step)
        advance_rows(state, commands[k], drive, whole, work)
        remember(state, ring, rows, mass * GRAVITY)


@compiled(**BORROWING)
def write_wake_law_push(state: Array, air: LawAir, step: float, push: Array) -> None:
    """Write the push of a wake law on the vehicles of `state` [m/s^2], world, (n, 3), into `push`.

    `step` is physics' [s].
    """
    kind, ring, rows = air
    wake_law_push(state, ring, rows, kind, step)
    for i in range(state.shape[0]):
        push[i, 0], push[i, 1], push[i, 2] = state[i, ETA_X], state[i, ETA_Y], state[i, ETA_Z]


@compiled(**BORROWING)
def write_push(state: Array, air: Air, body: Body, push: Array) -> None:
    """Write the push of the air on the vehicles of `state` [m/s^2], world, (n, 3), into `push`."""
    air_push(state, air, body)
    for i in range(state.shape[0]):
        push[i, 0], push[i, 1], push[i, 2] = state[i, ETA_X], state[i, ETA_Y], state[i, ETA_Z]


class Swarm:
    """Vehicles of a room and their states."""

    def __init__(
        self, names: Names, vehicle: Vehicle, start: Array, air: FlownAir = WakeLaw.NONE, seed: int = 0
    ) -> None:
        """Place vehicles at rest at `start` (n, 4): x, y, z [m], yaw [rad].

        Raises:
            AirError: the air's own class gives no valid push.
        """
        self.names = names
        step = 1.0 / PHYSICS_RATE
        self._use(body_of_room(air, vehicle, step))
        self._flown = vehicle_of_room(air, vehicle)
        self.state = state_at_rest(start, vehicle.mass)
        self.air = still_air(self.state, air, self.body, seed)
        self._law: LawAir | None = self.air[:3] if isinstance(air, WakeLaw) else None
        self._block = -1
        self._processes = UnitProcesses(air, len(names), step, seed) if isinstance(air, RoomAir) else None
        setup = AirSetup(vehicle, len(names), step, seed)
        self._uncompiled = None if isinstance(air, WakeLaw | RoomAir) else UncompiledWake(air, setup)
        self._age = np.zeros(len(names))  # all states share these two
        self._tracked = np.full(len(names), int(TrackStatus.TRACKED), dtype=np.uint8)
        self._age.flags.writeable = self._tracked.flags.writeable = False

    def step(self, commands: Array, drive: Array) -> None:
        """Advance by one physics step for each row of `commands`.

        Args:
            commands: thrust [N], roll, pitch [rad], yaw rate [rad/s] of each vehicle, (steps, n, 4).
            drive: acceleration by wind [m/s^2], world, then the gain of each rotor, (n, 7).

        Raises:
            AirError: the air's own class gives no valid push.
        """
        if self._law is not None:
            run_in_law(self.state, self._law, commands, drive, self._plain_body)
            return
        done = 0
        while done < len(commands):
            end = done + self.prepare()
            run_steps(self.state, self.air, commands[done:end], drive, self.body)
            done = end

    def use_attitude_loop(self, attitude: AttitudeParams) -> None:
        """Replace the onboard attitude loop."""
        self._use(self.body._replace(gains=attitude_gains(attitude, self._flown)))

    def _use(self, body: Body) -> None:
        """Use the constants of a vehicle from now on."""
        self.body = body
        self._plain_body: PlainBody = (*body.gains,), *body[1:]

    def prepare(self) -> int:
        """Prepare what the compiled loop cannot; return for how many steps that lasts.

        Raises:
            AirError: the air's own class gives no valid push.
        """
        taken = int(self.air.rows[-1])
        if self._uncompiled is not None:
            self._uncompiled.act(self.state, taken)
            return 1
        if self._processes is None:
            return sys.maxsize
        block = self.air.room.unit  # (KINDS, steps, n)
        steps: int = block.shape[1]
        if taken // steps != self._block:
            self._block = taken // steps
            self._processes.fill(block)
        return steps - taken % steps

    def downwash(self) -> Array:
        """Return the push of the air on every vehicle now [m/s^2], world, (n, 3)."""
        push = np.empty((len(self.names), 3))
        if self._law is not None:
            write_wake_law_push(self.state, self._law, self.body.step, push)
            return push
        self.prepare()
        write_push(self.state, self.air, self.body, push)
        return push

    def truth(self, t: float) -> SwarmState:
        """Return the true state, stamped t [s], in arrays of one layout, also of a single vehicle."""
        now = self.state
        return SwarmState(
            t=t,
            names=self.names,
            pos=now[:, POS].copy(),
            vel=now[:, VEL].copy(),
            quat=now[:, QUAT].copy(),
            ang_vel_body=now[:, RATE].copy(),
            age=self._age,
            status=self._tracked,
        )
