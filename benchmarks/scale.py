"""Time all nodes for swarms of many sizes: live and in lockstep, one process per node and `stack`.

Vehicles fly in pairs on a grid of 2 m, the upper half a metre over the lower, which feels its downwash.
CPU is that of all nodes, simulator and recorder among them, in cores (1 is one core fully used), between a
fifth of the flight and its end. A virtual machine's host may take the processor away for milliseconds, and
ticks are missed then: the time taken is reported. The reference of live latency is the tick of 10 ms, that of
lockstep the wall clock. `Q2Q_SCALE_S` sets how long live flights take [s].
"""

import os
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import yaml

from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun
from q2q_sim.node_flights.scenario_flight import fly_through_nodes
from row import Row

SIZES = (2, 10, 50, 100, 200, 400)
LIVE_S = float(os.environ.get("Q2Q_SCALE_S", "20"))
LOCKSTEP_S = 10.0
RECORDED = ("mocap", "state", "command", "truth", "truth_interference")
"""What metrics need; a recorder of all topics is a load of its own."""
SETTLED = 0.2
"""Share of the flight after which CPU is counted."""


def run() -> list[Row]:
    """Return latency, missed ticks, CPU and speed for every size."""
    rows: list[Row] = []
    for vehicles in SIZES:
        for stack in (False, True):
            rows += _live(vehicles, stack=stack) + _lockstep(vehicles, stack=stack)
    return rows


def _live(vehicles: int, *, stack: bool) -> list[Row]:
    before = stolen()
    flown, cores = _flown(vehicles, LIVE_S, live=True, stack=stack)
    taken = stolen() - before
    timing, name = flown.timing, f"live, {vehicles} vehicles, {_way(stack=stack)}"
    p50, p99 = timing.latency_p50_ms or float("nan"), timing.latency_p99_ms or float("nan")
    return [
        Row(f"{name}: latency p50", p50, "ms", "tick of 10 ms", 10.0 / p50),
        Row(f"{name}: latency p99", p99, "ms", "tick of 10 ms", 10.0 / p99),
        Row(f"{name}: missed ticks", timing.missed_ticks, f"of {timing.ticks}"),
        Row(f"{name}: taken by the host", taken, "s of CPU"),
        *_cpu(name, cores),
    ]


def _lockstep(vehicles: int, *, stack: bool) -> list[Row]:
    flown, cores = _flown(vehicles, LOCKSTEP_S, live=False, stack=stack)
    factor = flown.timing.real_time_factor or float("nan")
    wall, name = LOCKSTEP_S / factor, f"lockstep, {vehicles} vehicles, {_way(stack=stack)}"
    return [Row(name, wall, f"s for {LOCKSTEP_S:g} s", "real time", factor), *_cpu(name, cores)]


def _cpu(flight: str, cores: float | None) -> list[Row]:
    """Return the row of a flight's CPU; none if it was too short to measure."""
    return [] if cores is None else [Row(f"{flight}: CPU", cores, "cores")]


def _way(*, stack: bool) -> str:
    return "stack" if stack else "nodes"


def _flown(vehicles: int, duration: float, *, live: bool, stack: bool) -> tuple[FlightRun, float | None]:
    """Return the flight, and how many cores its nodes used; None if it was too short to measure."""
    readings: list[tuple[float, float]] = []

    def follow(share: float) -> None:
        if share >= SETTLED:
            readings.append((perf_counter(), nodes_cpu()))

    with TemporaryDirectory() as place:
        scenario = Path(place) / f"pairs_{vehicles}.yaml"
        scenario.write_text(yaml.safe_dump(passing_pairs(vehicles, duration)))
        request = FlightRequest(str(scenario), live=live, stack=stack, record=RECORDED)
        flown = fly_through_nodes(request, Path(place) / "nodes", Path(place) / "bag", follow)
    if len(readings) < 2:
        return flown, None
    (begin, cpu_before), (end, cpu_after) = readings[0], readings[-1]
    return flown, (cpu_after - cpu_before) / (end - begin)


def nodes_cpu() -> float:
    """Return the CPU time of this process's running descendants [s], from /proc: nodes are grandchildren."""
    parent, spent = {}, {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:  # ended meanwhile
            continue
        pid = int(stat.parent.name)
        parent[pid], spent[pid] = int(fields[1]), int(fields[11]) + int(fields[12])
    return sum(spent[pid] for pid in spent if _is_below(pid, parent)) / os.sysconf("SC_CLK_TCK")


def _is_below(pid: int, parent: dict[int, int]) -> bool:
    """Return whether a process is a child of this one, or of one that is."""
    while pid in parent:
        pid = parent[pid]
        if pid == os.getpid():
            return True
    return False


def stolen() -> float:
    """Return the CPU time that the host of this machine kept for others [s], from /proc."""
    return int(Path("/proc/stat").read_text().split()[8]) / os.sysconf("SC_CLK_TCK")


def passing_pairs(vehicles: int, duration: float, side: int = 10) -> dict[str, object]:
    """Return the scenario, `side` pairs a row: lower ones hover, upper ones pass over and come back."""
    points: dict[str, object] = {}
    for index in range(vehicles):
        pair, upper = divmod(index, 2)
        x, y = 2.0 * (pair % side), 2.0 * (pair // side)
        here = [x - 0.6 * upper, y, 1.0 + 0.5 * upper]
        there = [x + 0.6 * upper, y, 1.0 + 0.5 * upper]
        times = (0.0, 0.5 * duration, duration)
        points[f"cf{index + 1}"] = [
            {"t": t, "pos": pos} for t, pos in zip(times, (here, there, here), strict=True)
        ]
    return {
        "description": "Pairs on a grid, the upper one passes over the lower",
        "duration": duration,
        "wake": "measured",
        "model": "measured_law",
        "room": "capture",
        "vehicles": points,
    }
