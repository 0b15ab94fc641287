"""Time one tick of every block of a flight, in turn as `closed_loop` runs them: with caches as cold as there.

table6 and a swarm are flown aware of the downwash, in ideal rooms, without replanning. A block's figure is
the median over the flight's ticks, and the minimum. Lockstep adds up these and the transport. The
reference is the tick itself: how often a block could run within the 10 ms that a tick has in real time.
"""

from collections import defaultdict
from collections.abc import Callable
from time import perf_counter
from typing import ParamSpec, TypeVar

import numpy as np

from q2q_model.model_files.find_model import find_model
from q2q_model.signals.stamps import TICK_S
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_sim.loop.flight_blocks import BlockChoices, blocks_of
from q2q_sim.loop.room import Room
from q2q_sim.scenarios import library
from row import Row

P = ParamSpec("P")
T = TypeVar("T")

FLIGHTS = {"table6": 5000, "swarm100": 300}
"""Ticks flown of each scenario; table6 has its vehicles near each other in the middle third."""


def run() -> list[Row]:
    """Return microseconds a tick of every block."""
    rows = []
    for scenario, ticks in FLIGHTS.items():
        spent = _flown(scenario, ticks)
        for block, seconds in spent.items():
            rows += [
                _row(f"{scenario} {block}, median", float(np.median(seconds))),
                _row(f"{scenario} {block}, least", min(seconds)),
            ]
        rows.append(
            _row(f"{scenario} all blocks, median", float(np.median(np.sum(list(spent.values()), axis=0))))
        )
    return rows


def _row(name: str, seconds: float) -> Row:
    return Row(name, 1e6 * seconds, "us", "a tick of 10 ms", TICK_S / seconds)


def _flown(name: str, ticks: int) -> dict[str, list[float]]:
    """Return the seconds that every block took, tick by tick."""
    scenario = library.load(name)
    blocks, room = (
        blocks_of(scenario, BlockChoices("aware"), find_model(scenario.model).interaction),
        Room(scenario, 0),
    )
    spent: defaultdict[str, list[float]] = defaultdict(list)

    def timed(block: str, call: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
        start = perf_counter()
        made = call(*given, **named)
        spent[block].append(perf_counter() - start)
        return made

    for _ in range(ticks):
        tick = timed("room capture", room.capture)
        state = timed("mocap filter", blocks.mocap_filter.update, tick.frame)
        downwash = timed("interference", blocks.predictor.update, state)
        planned = timed("trajectory", setpoint_at, blocks.plan, tick.frame.t)
        given = timed("replanner", blocks.replanner.update, planned, state)
        command = timed("pid", blocks.controller.update, state, given, downwash)
        timed("room advance", room.advance, command)
    return dict(spent)
