"""Many swarms in one call, of one kind, each in air of its own, stepped together.

A batch of small swarms costs as little per vehicle as one large swarm: the call is made once, and the
vehicles of neighbouring swarms share the blocks of plant.body.vectorised_step. Each moves as a Swarm of the
same start and seed does, to the last bit. Swarms do not meet, so threads share them; by default there is one
thread, the caller's.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import BORROWING, HOT, compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.unit_processes import RESIDUAL, UnitProcesses
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.body.quadcopter import Body
from q2q_sim.plant.body.state_row import STATE_WIDTH, state_at_rest
from q2q_sim.plant.body.vectorised_step import BLOCK_WIDTH, LANES, StepMemory, advance_rows
from q2q_sim.plant.push.compiled_room_air import CompiledRoomAir
from q2q_sim.plant.push.neighbour_list import NeighbourList
from q2q_sim.plant.push.prefetch import prefetch
from q2q_sim.plant.push.state_history_ring import empty_ring, remember
from q2q_sim.plant.room_vehicle import body_of_room
from q2q_sim.plant.swarm import PHYSICS_RATE
from q2q_sim.plant.swarm_air import Air, air_push, still_air

AT_ONCE = 64
"""Vehicles whose swarms take all steps of a call together: their states stay in the first-level cache."""

Share = tuple[int, int]
"""First swarm of a thread, and the one after its last."""


@dataclass(frozen=True, slots=True)
class SwarmBatchSetup:
    """Vehicles and air of all swarms."""

    vehicle: Vehicle
    start: Array
    """x, y, z [m], yaw [rad], (swarms, n, 4)."""
    air: WakeLaw | RoomAir = WakeLaw.NONE
    seeds: Sequence[int] = ()
    """Seed of each swarm; empty for 0, 1, 2 and so on."""


@compiled(**HOT)
def neighbours_of_swarm(near: NeighbourList, s: int) -> NeighbourList:
    """Return the list of swarm s, of lists with a leading axis of swarms."""
    return NeighbourList(near.begin[s], near.end[s], near.found[s], near.rank[s], near.at[s], near.limits[s])


@compiled(**HOT)
def air_of_swarm(airs: Air, s: int, work: int) -> Air:
    """Return the air of swarm s in airs of `stack_airs`, with the workspace of the swarm `work`."""
    kind, ring, rows, rooms = airs
    room = CompiledRoomAir(
        rooms.table,
        rooms.numbers,
        rooms.bound,
        rooms.unit[s],
        rooms.extremes[s],
        rooms.rotor_max[s],
        rooms.gains[s],
        neighbours_of_swarm(rooms.near, s),
        rooms.places[work],
        rooms.jet_rows[work],
        rooms.receiver[work],
        rooms.source[work],
    )
    return Air(kind, ring[s], rows[s], room)


@compiled(**HOT)
def prefetch_swarms(airs: Air, first: int, end: int) -> None:
    """Ask memory for what swarms from `first` to `end` read at once: their present, and random numbers."""
    n, slots, steps = airs.rows.shape[1] - 1, airs.ring.shape[1], airs.room.unit.shape[2]
    for s in range(first, end):
        prefetch(airs.room.unit[s], RESIDUAL, airs.rows[s, n] % steps)
        for i in range(n):
            prefetch(airs.ring[s], airs.rows[s, n] % slots, i)


class SwarmBatchInputs(NamedTuple):
    """Air and inputs of all swarms; vehicles swarm after swarm."""

    airs: Air
    commands: Array
    """Thrust [N], roll, pitch [rad], yaw rate [rad/s], (steps, swarms * n, 4)."""
    drive: Array
    """Acceleration by wind [m/s^2], world, then the gain of each rotor, (swarms * n, 7)."""
    body: Body


@compiled(nogil=True, **BORROWING)
def run_swarm_batch(state: Array, inputs: SwarmBatchInputs, share: Share, work: StepMemory) -> None:
    """Advance the swarms of a share by one physics step for each row of commands; releases the GIL.

    Args:
        state: rows of all vehicles, swarm after swarm, (swarms * n, STATE_WIDTH), changed in place.
        inputs: of all swarms.
        share: swarms to advance.
        work: workspace.
    """
    airs, commands, drive, body = inputs
    n, weight = airs.rows.shape[1] - 1, body.mass * GRAVITY
    together = max(AT_ONCE // n, 1)
    for first in range(share[0], share[1], together):
        end = min(first + together, share[1])
        low, high = first * n, end * n
        prefetch_swarms(airs, first, end)
        for k in range(commands.shape[0]):
            for s in range(first, end):
                air_push(state[s * n : (s + 1) * n], air_of_swarm(airs, s, share[0]), body)
            advance_rows(state[low:high], commands[k, low:high], drive[low:high], body, work)
            for s in range(first, end):
                remember(state[s * n : (s + 1) * n], airs.ring[s], airs.rows[s], weight)


class SwarmBatch:
    """Many swarms and their states."""

    def __init__(self, setup: SwarmBatchSetup, threads: int = 1) -> None:
        """Place all vehicles at rest; `threads` threads share the swarms.

        Raises:
            TypeError: an air that a batch cannot step.
            ValueError: `start` of another shape, no swarms, no vehicles, no threads, or not one seed for each
                swarm.
        """
        _check_air(setup.air)
        start = np.asarray(setup.start, dtype=np.float64)
        if start.ndim != 3 or start.shape[2] != 4:
            raise ValueError(
                f"start of shape {start.shape} is given; must be (swarms, vehicles, 4): x, y, z, yaw"
            )
        swarms, count = start.shape[:2]
        seeds = setup.seeds or range(swarms)
        if swarms * count == 0 or len(seeds) != swarms or threads < 1:
            raise ValueError(
                f"{swarms} swarms of {count} vehicles with {len(seeds)} seeds on {threads} threads; must be "
                "a seed for each swarm, and at least one of each"
            )
        step = 1.0 / PHYSICS_RATE
        self.body = body_of_room(setup.air, setup.vehicle, step)
        states = [state_at_rest(places, setup.vehicle.mass) for places in start]
        self.state = np.stack(states)
        """Rows of each swarm, (swarms, n, STATE_WIDTH)."""
        pairs = zip(states, seeds, strict=True)
        self.airs = stack_airs([still_air(state, setup.air, self.body, seed) for state, seed in pairs])
        self._processes = [
            UnitProcesses(setup.air, count, step, seed) for seed in seeds if isinstance(setup.air, RoomAir)
        ]
        edges = np.linspace(0, swarms, threads + 1).round().astype(int).tolist()
        self._shares: list[Share] = list(pairwise(edges))
        self._work = [(np.zeros(BLOCK_WIDTH * LANES), np.zeros(4)) for _ in self._shares]
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None

    def step(self, commands: Array, drive: Array) -> None:
        """Advance all swarms by one physics step for each row of `commands`.

        Args:
            commands: thrust [N], roll, pitch [rad], yaw rate [rad/s] of each vehicle, (steps, swarms, n, 4).
            drive: acceleration by wind [m/s^2], world, then the gain of each rotor, (swarms, n, 7).

        Raises:
            ValueError: an array of another shape.
        """
        vehicles = self.state.shape[:2]
        if commands.shape[1:] != (*vehicles, 4) or drive.shape != (*vehicles, 7):
            raise ValueError(
                f"commands {commands.shape} and drive {drive.shape} for (swarms, vehicles) = {vehicles}; "
                "must be (steps, swarms, vehicles, 4) and (swarms, vehicles, 7)"
            )
        count = vehicles[0] * vehicles[1]
        flat = (commands.reshape(len(commands), count, 4), drive.reshape(count, 7))
        others = range(1, len(self._shares))
        running = [self._pool.submit(self._advance, k, *flat) for k in others] if self._pool else []
        self._advance(0, *flat)
        for one in running:
            one.result()

    def _advance(self, thread: int, commands: Array, drive: Array) -> None:
        """Advance the swarms of a thread."""
        first, end = share = self._shares[thread]
        state, done = self.state.reshape(-1, STATE_WIDTH), 0
        while done < len(commands) and end > first:
            until = min(done + self._prepare(share), len(commands))
            inputs = SwarmBatchInputs(self.airs, commands[done:until], drive, self.body)
            run_swarm_batch(state, inputs, share, self._work[thread])
            done = until

    def _prepare(self, share: Share) -> int:
        """Draw the next block of the unit processes where one begins; return the steps to its end."""
        blocks = self.airs.room.unit  # (swarms, KINDS, steps, n)
        steps: int = blocks.shape[2]
        passed = int(self.airs.rows[share[0], -1]) % steps
        if passed == 0 and self._processes:
            for swarm in range(*share):
                self._processes[swarm].fill(blocks[swarm])
        return steps - passed


def _check_air(air: object) -> None:
    """Raise TypeError for an air outside the compiled loop."""
    if not isinstance(air, WakeLaw | RoomAir):
        raise TypeError(
            f"air = {air!r}; must be a WakeLaw or a RoomAir: find_air returns that of a name; step your own "
            "class with Swarm"
        )


def stack_airs(airs: Sequence[Air]) -> Air:
    """Return the airs of many swarms in one: all arrays but the table with a leading axis of swarms."""
    first, rooms = airs[0], [air.room for air in airs]
    room = CompiledRoomAir(
        table=first.room.table,
        numbers=first.room.numbers,
        bound=first.room.bound,
        unit=np.stack([one.unit for one in rooms]),
        extremes=np.stack([one.extremes for one in rooms]),
        rotor_max=np.stack([one.rotor_max for one in rooms]),
        gains=np.stack([one.gains for one in rooms]),
        near=NeighbourList(*map(np.stack, zip(*(one.near for one in rooms), strict=True))),
        places=np.stack([one.places for one in rooms]),
        jet_rows=np.stack([one.jet_rows for one in rooms]),
        receiver=np.stack([one.receiver for one in rooms]),
        source=np.stack([one.source for one in rooms]),
    )
    ring = np.stack([air.ring for air in airs], out=empty_ring((len(airs), *first.ring.shape)))
    return Air(first.kind, ring, np.stack([air.rows for air in airs]), room)
