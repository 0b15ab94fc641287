"""Flight of a scenario through the real nodes: start, fly, end, measure from the bag."""

from collections.abc import Callable, Sequence
from pathlib import Path
from time import monotonic

from q2q_model.counted import first_of
from q2q_model.signals.stamps import TICK_S
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.flight_verdict import with_finding
from q2q_sim.monitors.metrics.flight_metrics import measure
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.monitors.recording_end import with_lost_ticks, with_planned_end
from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.node_flights.flight_run import FlightRun
from q2q_sim.node_flights.running_nodes import running_nodes
from q2q_sim.node_flights.unfinished_bag import end_of_bag, read_flown, why_unfinished
from q2q_sim.node_flights.waiting_note import WaitingNote, noted_if_late
from q2q_sim.simulator.flight_clock import FlightTiming

MEASURED = ("mocap", "truth", "truth_interference", "reference", "reference_safe", "command")
"""Topics that metrics and verdict need; a temporary bag has no others."""
MOST_NAMED = 6
"""Vehicles of another simulator that are named."""


def fly_through_nodes(
    request: FlightRequest,
    folder: Path,
    bag: Path,
    progress: Callable[[float], None],
    note: Callable[[str], None] = lambda _: None,
) -> FlightRun:
    """Fly a scenario and return its metrics and verdict.

    Args:
        request: scenario and options.
        folder: output folder for parameters, plan and logs.
        bag: output folder of the bag; must not exist.
        progress: called with the flown fraction, 0 to 1.
        note: called with what the flight waits for, if it begins late.

    Raises:
        ValueError: an unknown scenario, vehicle or parameter, or another simulator flew in this ROS domain.
        BagError: nothing can be read from the bag.
        NodeDiedError, TimeoutError: a node did not start or ended early.
    """
    scenario = load_scenario(request)
    if bag.exists():
        raise ValueError(f"bag {bag} exists: choose another folder or delete it")
    specs = node_specs(scenario, request, folder, bag)
    total = scenario.duration / TICK_S
    waits = WaitingNote(monotonic())

    with noted_if_late(note) as begun:

        def wait(waiting: Sequence[str]) -> None:
            begun()
            progress(0.0)
            if due := waits.update(waiting, monotonic()):
                note(due)

        with running_nodes(specs, folder, wait) as running:
            begun()
            running.director.start()
            timing = running.director.wait_summary(lambda ticks: progress(ticks / total))
    return recorded_run(request, timing, folder, bag)


def recorded_run(request: FlightRequest, timing: FlightTiming, folder: Path, bag: Path) -> FlightRun:
    """Return metrics and verdict of a flight from its bag; one that is not finished is not ok.

    Raises:
        BagError: nothing can be read from the bag.
        ValueError: vehicles of another simulator are in it.
    """
    scenario, unfinished = load_scenario(request), why_unfinished(bag, folder)
    flight = read_flown(bag, unfinished, temporary=request.temporary)
    if strangers := [name for name in flight.names if name not in scenario.names]:
        named = ", ".join(first_of(strangers, MOST_NAMED))
        raise ValueError(
            f"another simulator flew in this ROS domain (vehicles {named}): set another ROS_DOMAIN_ID"
        )
    around = Circumstances(vehicle=scenario.vehicle, faults=scenario.faults)
    verdict = with_lost_ticks(verdict_of(flight, around, timing.missed_ticks), flight, timing.ticks)
    if unfinished:
        flown = timing.ticks * TICK_S
        end = end_of_bag(bag, flight, flown, unfinished, temporary=request.temporary)
        verdict = with_finding(verdict, end)
    else:
        verdict = with_planned_end(verdict, flight, f"{scenario.duration}")
    return FlightRun(request, flight, measure(flight, scenario.vehicle), timing, bag, verdict)
