"""Peak arithmetic and memory traffic of this machine, measured, and what one drone-step needs of both.

Peak arithmetic is a product of two square matrices in BLAS, peak traffic a copy between arrays beyond the
caches, each on all cores at once. The operations of a drone-step are counted by running the plain form of the
kernels on numbers that count: `NUMBA_DISABLE_JIT=1 python benchmarks/roofline.py 10` prints additions,
multiplications, divisions and roots of a drone-step among 10 vehicles in the air of a room; atan2, asin, exp
and comparisons are not in it. Its bytes are the state read and written, command, drive, a random number, and
the slot of the past states: the traffic if nothing stayed in a cache, without what pairs read.
"""

import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter

import numpy as np

from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.plant.body.quadcopter import advance
from q2q_sim.plant.body.state_row import STATE_WIDTH
from q2q_sim.plant.body.vectorised_step import COMMAND_WIDTH, DRIVE_WIDTH
from q2q_sim.plant.push.push_table import PushTable
from q2q_sim.plant.push.state_history_ring import ROOM_WIDTH, remember
from q2q_sim.plant.swarm import Swarm
from q2q_sim.plant.swarm_air import air_push
from simulated_swarms import swarm_flight

CORES = len(os.sched_getaffinity(0))
SIDE = 1500
"""Rows of the matrices; one product takes about 0.1 s."""
COPIED = 1 << 28
"""Bytes of an array that is copied: more than a core's share of any cache."""
ROUNDS = 5
BYTES = 8 * (2 * STATE_WIDTH + COMMAND_WIDTH + DRIVE_WIDTH + 1 + ROOM_WIDTH)
"""Of a drone-step."""


def peak_flops() -> float:
    """Return additions and multiplications a second of all cores in double precision."""
    pairs = [np.random.default_rng(k).random((2, SIDE, SIDE)) for k in range(CORES)]
    outs = [np.empty((SIDE, SIDE)) for _ in pairs]
    return CORES * 2.0 * SIDE**3 / _fastest(lambda k: np.matmul(pairs[k][0], pairs[k][1], out=outs[k]))


def peak_traffic() -> float:
    """Return bytes per second, read and written, of all cores."""
    arrays = [np.ones((2, COPIED // 8)) for _ in range(CORES)]
    return CORES * 2.0 * COPIED / _fastest(lambda k: np.copyto(arrays[k][0], arrays[k][1]))


def flops_of_a_step(vehicles: int) -> float:
    """Return the operations of a drone-step among `vehicles` vehicles in the air of a room."""
    command = [sys.executable, __file__, str(vehicles)]
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    return float(done.stdout)


def _fastest(work: Callable[[int], object]) -> float:
    """Return the shortest time in which all cores do their work once [s]."""
    best = np.inf
    with ThreadPoolExecutor(CORES) as pool:
        for _ in range(ROUNDS):
            start = perf_counter()
            list(pool.map(work, range(CORES)))
            best = min(best, perf_counter() - start)
    return float(best)


class Counted(np.float64):
    """Number that counts the operations made with it."""

    made = 0


def _counting(name: str) -> Callable[[Counted, float], Counted]:
    """Return an operation of two numbers that counts."""
    plain = getattr(float, name)

    def operation(one: Counted, other: float) -> Counted:
        Counted.made += 1
        return Counted(plain(float(one), float(other)))

    return operation


for _name in ("add", "sub", "mul", "truediv", "pow"):
    setattr(Counted, f"__{_name}__", _counting(f"__{_name}__"))
    setattr(Counted, f"__r{_name}__", _counting(f"__r{_name}__"))
Counted.__neg__ = lambda one: Counted(-float(one))  # type: ignore[method-assign,assignment]  # not counted
Counted.__abs__ = lambda one: Counted(abs(float(one)))  # type: ignore[method-assign,assignment]


def _counted(array: np.ndarray) -> np.ndarray:
    """Return an array of counting numbers; arrays of other things unchanged."""
    return np.vectorize(Counted, otypes=[object])(array) if array.dtype == np.float64 else array


def _count(swarm: Swarm, commands: np.ndarray, drive: np.ndarray) -> float:
    """Return the operations of a drone-step."""
    law = swarm.air.room
    gaps, radii, push, ends = law.table
    gaps, radii = (one._replace(at=_counted(one.at)) for one in (gaps, radii))
    near = law.near._replace(at=_counted(law.near.at), limits=_counted(law.near.limits))
    columns = {name: _counted(getattr(law, name)) for name in ("extremes", "places", "jet_rows")}
    law = law._replace(table=PushTable(gaps, radii, _counted(push), _counted(ends)), near=near, **columns)
    air = swarm.air._replace(ring=_counted(swarm.air.ring), room=law)
    state, rotors = _counted(swarm.state), _counted(np.zeros(4))
    air_push(state, air, swarm.body)  # lists who is near, as one step of many does
    Counted.made = 0
    air_push(state, air, swarm.body)
    for row, command, around in zip(state, _counted(commands[0]), _counted(drive), strict=True):
        advance(row, tuple(command), around, swarm.body, rotors)
    remember(state, air.ring, air.rows, 1.0)
    return Counted.made / len(state)


if __name__ == "__main__":
    print(_count(*swarm_flight(int(sys.argv[1]), find_air("room"))))
