"""A long flight of many vehicles through nodes, with samples of what its processes hold.

Vehicles fly in pairs on a grid of 2 m: lower ones hover, upper ones pass over them and come back, for as long
as the flight takes. Every node is a process of its own unless it is in the stack; all topics are recorded.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from q2q_model.documents.written_file import write_text
from q2q_model.signals.stamps import TICK_S
from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.node_flights.running_nodes import running_nodes
from q2q_sim.node_flights.unfinished_bag import why_unfinished
from q2q_sim.processes.usage import ProcessUsage, usage_of
from q2q_sim.simulator.flight_clock import FlightTiming

PASS_S = 10.0
"""Time from one side of the lower vehicle to the other [s]."""
SAMPLE_S = 0.2
"""Wall time between samples [s]."""


@dataclass(frozen=True, slots=True)
class Sample:
    """State of the flight's processes at one moment."""

    wall: float
    """[s]"""
    flown: float
    """Time of the flight [s]."""
    usage: Mapping[str, ProcessUsage]
    """By process."""
    bag: int
    """Size of the bag [bytes]."""


@dataclass(frozen=True, slots=True)
class LongFlight:
    """Finished long flight."""

    vehicles: int
    live: bool
    samples: Sequence[Sample]
    timing: FlightTiming
    unfinished: str = ""
    """Why the recorder did not finish the bag; empty if it did."""


def scenario_of_pairs(vehicles: int, duration: float) -> dict[str, object]:
    """Return the scenario file of a flight that takes `duration` [s]."""
    points: dict[str, object] = {}
    passes = max(round(duration / PASS_S), 1)
    for index in range(vehicles):
        pair, upper = divmod(index, 2)
        x, y, z = 2.0 * (pair % 10), 2.0 * (pair // 10), 1.0 + 0.5 * upper
        points[f"cf{index + 1}"] = [
            {"t": k * duration / passes, "pos": [x + 0.6 * upper * (-1) ** k, y, z]}
            for k in range(passes + 1)
        ]
    return {
        "description": "Pairs on a grid, the upper one passes over the lower again and again",
        "duration": duration,
        "wake": "measured",
        "model": "measured_law",
        "room": "capture",
        "vehicles": points,
    }


def fly_long(
    request: FlightRequest, vehicles: int, folder: Path, progress: Callable[[float], float]
) -> LongFlight:
    """Fly into `folder`; `progress` takes the flown share and returns the wall time [s].

    Raises:
        NodeDiedError, TimeoutError: a node did not start or ended early.
    """
    scenario = load_scenario(request)
    specs = node_specs(scenario, request, folder, folder / "bag")
    samples: list[Sample] = []
    with running_nodes(specs, folder) as running:
        pids = {spec.label: running.processes.pid(spec.label) for spec in specs}

        def look(ticks: int) -> None:
            flown = ticks * TICK_S
            wall = progress(flown / scenario.duration)
            last = samples[-1] if samples else None
            if ticks and (last is None or (wall - last.wall >= SAMPLE_S and flown > last.flown)):
                usage = {name: usage_of(pid) for name, pid in pids.items()}
                samples.append(Sample(wall, flown, usage, folder_size(folder / "bag")))

        running.director.follow_clock()
        running.director.start()
        timing = running.director.wait_summary(look)
    unfinished = why_unfinished(folder / "bag", folder)
    return LongFlight(vehicles, request.live, samples, timing, unfinished)


def folder_size(folder: Path) -> int:
    """Return the size of a folder's files [bytes]."""
    return sum(one.stat().st_size for one in folder.glob("*"))


def write_long_scenario(folder: Path, vehicles: int, duration: float) -> Path:
    """Write the scenario of a long flight; return its file."""
    file = folder / "endurance.yaml"
    write_text(yaml.safe_dump(scenario_of_pairs(vehicles, duration)), file)
    return file
