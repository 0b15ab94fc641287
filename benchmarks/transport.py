"""Time the road through DDS: lockstep against real time, live latency and missed ticks.

The reference of lockstep is the wall clock: a ratio of 6 means six times faster than real time. The second
reference is the same flight without ROS (`closed_loop`), which shows what the transport costs.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from q2q_sim.flight.scenario_flight import FlightRequest, FlightRun
from q2q_sim.flight.scenario_flight import fly as fly_nodes
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios import library
from row import Row


def run() -> list[Row]:
    """Return lockstep and live figures of table6."""
    lockstep, live = _nodes(live=False), _nodes(live=True)
    duration = library.load("table6").duration
    wall = duration / (lockstep.timing.real_time_factor or 1.0)
    pure = _pure_wall()
    return [
        Row("lockstep, 2 vehicles", wall, "s", "real time", duration / wall),
        Row("lockstep, 2 vehicles, against no ROS", wall, "s", "closed_loop", pure / wall),
        Row("live latency p50", live.timing.latency_p50_ms or float("nan"), "ms"),
        Row("live latency p99", live.timing.latency_p99_ms or float("nan"), "ms"),
        Row("live ticks missed in 50 s", live.timing.missed_ticks, "ticks"),
    ]


def _nodes(*, live: bool) -> FlightRun:
    with TemporaryDirectory() as folder:
        request = FlightRequest("table6", live=live)
        return fly_nodes(request, Path(folder) / "nodes", Path(folder) / "bag", lambda _: None)


def _pure_wall() -> float:
    scenario = library.load("table6")
    fly(scenario, FlightOptions(mode="aware"))
    before = perf_counter()
    fly(scenario, FlightOptions(mode="aware"))
    return perf_counter() - before
