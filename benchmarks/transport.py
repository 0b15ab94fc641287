"""Time the control loop through DDS: lockstep against real time, live latency and missed ticks.

The reference of lockstep is the wall clock: a ratio of 6 means six times faster than real time. The second
reference is the same flight without ROS (`closed_loop`), which shows what the transport costs. Flights named
`fly` are those of `scripts/fly SCENARIO` and `scripts/fly SCENARIO --no-stack`, whose bags are not kept; the
others write a bag of all topics.
"""

from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun
from q2q_sim.node_flights.scenario_flight import MEASURED
from q2q_sim.node_flights.scenario_flight import fly as fly_nodes
from q2q_sim.scenarios import library
from row import Row

FLOWN = ("table6", "swarm10", "swarm100")
"""Scenarios flown in lockstep, in a stack and in processes."""
REPEATS = 3
"""Flights of each, of which the middle one counts: the slowest takes up to 1.8 times the fastest."""


def run() -> list[Row]:
    """Return lockstep and live figures of table6, and lockstep figures of FLOWN."""
    table6 = FlightRequest("table6")
    lockstep, live = _nodes(table6), _nodes(replace(table6, live=True))
    duration = library.load("table6").duration
    wall = duration / (lockstep.timing.real_time_factor or 1.0)
    pure = _pure_wall()
    return [
        Row("lockstep, 2 vehicles", wall, "s", "real time", duration / wall),
        Row("lockstep, 2 vehicles, against no ROS", wall, "s", "closed_loop", pure / wall),
        Row("live latency p50", live.timing.latency_p50_ms or float("nan"), "ms"),
        Row("live latency p99", live.timing.latency_p99_ms or float("nan"), "ms"),
        Row("live ticks missed in 50 s", live.timing.missed_ticks, "ticks"),
        *(_flown(name, stack=stack) for name in FLOWN for stack in (True, False)),
    ]


def _flown(name: str, *, stack: bool) -> Row:
    request = FlightRequest(name, stack=stack, record=MEASURED, temporary=True)
    factor = median(_nodes(request).timing.real_time_factor or float("nan") for _ in range(REPEATS))
    duration, way = library.load(name).duration, "stack" if stack else "processes"
    return Row(f"fly {name}, {way}", duration / factor, f"s for {duration:g} s", "real time", factor)


def _nodes(request: FlightRequest) -> FlightRun:
    with TemporaryDirectory() as folder:
        return fly_nodes(request, Path(folder) / "nodes", Path(folder) / "bag", lambda _: None)


def _pure_wall() -> float:
    scenario = library.load("table6")
    fly(scenario, FlightOptions(mode="aware"))
    before = perf_counter()
    fly(scenario, FlightOptions(mode="aware"))
    return perf_counter() - before
