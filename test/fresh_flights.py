"""Fly what users fly in one process; print which kernels it compiled, never called, or has twice: for a test.

Closed loop with every controller and replanner, of a single vehicle and of two through every fault of the
room, also with blocks that get messages as those of nodes do, the passage of table6 with its active bounds,
flights with correction, one of distributed MPCs, the view's scenes, the vehicles' own firmware, and an
identification.
"""

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from types import FunctionType

import numpy as np
from fresh_checkout import ROOT
from numba.core.dispatcher import Dispatcher

from q2q_model.compilation.kernel_digest import called_kernels
from q2q_model.compiled import COMPILED, KERNELS
from q2q_model.diagnostics.smallest_separation import smallest_separation
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.downwash.jet import MEASURED_LAW
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.geometry.zone import Cylinder
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.model_files.find_model import find_model
from q2q_model.node.warm_up import warm_up
from q2q_model.recordings.recordings_of_bags import recordings_of_bags
from q2q_model.signals.cdr.cdr_reader import SignalReader
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_time
from q2q_model.signals.values import SwarmSetpoint, SwarmState
from q2q_sim.air.air_terms import JetTerm, ResidualTerm
from q2q_sim.air.room_air import RoomAir
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in
from q2q_sim.faults.faults import KINDS, Fault
from q2q_sim.loop.closed_loop import FlightOptions, LoopSettings, fly, fly_blocks
from q2q_sim.loop.distributed import DistributedMpc
from q2q_sim.loop.flight_blocks import BlockChoices, blocks_of
from q2q_sim.loop.room import Room
from q2q_sim.monitors.metrics.exposure import exposure
from q2q_sim.monitors.metrics.proximity import any_in_zone, in_zone_once, least_distances, near_sample
from q2q_sim.plant.swarm import Swarm
from q2q_sim.plant.swarm_batch import SwarmBatch, SwarmBatchSetup
from q2q_sim.scenarios import library
from q2q_sim.scenarios.choices import CONTROLLERS, REPLANNERS
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.tools.kernels.compile_kernels import import_kernels
from q2q_sim.view.scene import SceneBuilder, SceneParams, SceneSignals

SHORT_ROOM = library.load(str(ROOT / "test" / "scenarios" / "short_room.yaml"))
BLOCKS = ("mocap_filter", "predictor", "replanner", "controller")
RecordedSignal = list[dict[str, Signal]]


def main() -> None:
    """Fly and identify; print what was compiled, what is idle, and what is there for several types."""
    import_kernels()
    flights()
    recordings, _ = recordings_of_bags([ROOT / "bags" / "table2_1"])
    identify(recordings, ProcedureParams(), lambda _: None)
    print(json.dumps({"compiled": COMPILED, "idle": uncalled_kernels(), "twice": twice_compiled()}))


def uncalled_kernels() -> list[str]:
    """Return the names of the kernels this process has called neither from Python nor from other kernels."""
    called: set[FunctionType] = set()
    callers = [one.function for one in KERNELS if isinstance(one.made, Dispatcher) and one.made.overloads]
    while callers:
        one = callers.pop()
        if one not in called:
            called.add(one)
            callers.extend(called_kernels(one))
    return [kernel.name for kernel in KERNELS if kernel.function not in called]


def twice_compiled() -> list[str]:
    """Return the names of the kernels that this process has called with several types or array layouts."""
    return [one.name for one in KERNELS if isinstance(one.made, Dispatcher) and len(one.made.overloads) > 1]


def flights() -> None:
    """Fly all there is to fly."""
    faulty = replace(SHORT_ROOM, faults=tuple(faults_in_turn(SHORT_ROOM)))
    alone = replace(SHORT_ROOM, waypoints=SHORT_ROOM.waypoints[:1])
    for controller, replan in product(CONTROLLERS, REPLANNERS):
        flown(alone, controller, replan)
        signals = flown(faulty, controller, replan)
        through_messages(faulty, controller, replan)
    drawn(signals)
    measured(signals)
    flown(replace(library.load("table6"), duration=25.0), "mpc", "none")
    flown(replace(library.load("stack3"), duration=5.0), "mpc", "safe")
    absorbing = replace(MEASURED_LAW, absorption=1.0)
    fly(
        replace(library.load("swarm20"), duration=0.1),
        FlightOptions(controller="mpc", model=absorbing),
    )
    distributed(replace(library.load("stack3"), duration=0.2))
    flown(replace(library.load("swarm20"), duration=0.5), "mpc", "safe")
    jerk_limited = {"safe_replanner": {"jerk_max": 20.0, "tracking_z": 0.1}}
    flown(replace(library.load("swarm20"), duration=0.5, overrides=jerk_limited), "pid", "safe")
    fly(replace(library.load("stack3"), duration=1.0), FlightOptions(residual_process=REAL_FLIGHTS))
    fly(replace(alone, duration=1.0), FlightOptions(residual_process=REAL_FLIGHTS))
    flown_by_firmware(library.load("table6"))
    stacked_in_a_rooms_air()


def faults_in_turn(scenario: Scenario) -> list[Fault]:
    """Return a fault of every kind, one after the other, of a vehicle or the whole frame."""
    each = scenario.duration / (len(KINDS) + 1)
    made = []
    for number, (kind, about) in enumerate(KINDS.items(), start=1):
        struck = () if about.whole_frame else scenario.names if kind == "swap" else scenario.names[:1]
        size = min(about.high, max(about.low, 0.2))
        made.append(Fault(kind, number * each, 0.8 * each, struck, size))
    return made


def flown(scenario: Scenario, controller: str, replan: str) -> RecordedSignal:
    """Fly without ROS; return what was heard at each tick."""
    signals: RecordedSignal = []

    def hear(topic: str, _: int, signal: Signal) -> None:
        if topic == "truth":
            signals.append({})
        signals[-1][topic] = signal

    known = find_model(scenario.model).interaction
    fly(scenario, FlightOptions(controller=controller, replan=replan, model=known, on_signal=hear))
    return signals


def through_messages(scenario: Scenario, controller: str, replan: str) -> None:
    """Fly blocks whose signals come as messages."""
    known = find_model(scenario.model).interaction
    blocks = blocks_of(scenario, BlockChoices("aware", controller, replan), known)
    fed = {name: FedByMessages(getattr(blocks, name).update) for name in BLOCKS}
    fly_blocks(scenario, replace(blocks, **fed), LoopSettings())


class FedByMessages:
    """Block that gets its signals as a node does: from the bytes of messages."""

    def __init__(self, update: Callable[..., Signal]) -> None:
        self._update = update

    def update(self, *signals: Signal | None) -> Signal:
        """Update the block."""
        return self._update(*(None if one is None else received(one) for one in signals))


def received(signal: Signal) -> Signal:
    """Return a signal as a node gets it."""
    return SignalReader(type(signal)).received(encode(signal, stamp_from_time(signal.t)))


def distributed(scenario: Scenario) -> None:
    """Fly one MPC for each vehicle."""
    model = find_model(scenario.model).interaction
    blocks = blocks_of(scenario, BlockChoices("aware", "mpc"), model)
    controller = DistributedMpc(scenario, BlockChoices("aware", "mpc"), model, blocks.plan)
    fly_blocks(scenario, replace(blocks, controller=controller), LoopSettings())


def measured(signals: RecordedSignal) -> None:
    """Measure how near the vehicles came to each other."""
    pos = np.stack([tick["truth"].pos for tick in signals])
    least_distances(pos)
    smallest_separation(pos[0])
    any_in_zone(pos, Cylinder())
    in_zone_once(pos, Cylinder())
    near_sample(pos, pos, 0.1)
    exposure(pos, 0.01 * np.arange(len(pos)))


def drawn(signals: RecordedSignal) -> None:
    """Draw a flight as the view does."""
    builder = SceneBuilder(SceneParams())
    for tick in signals:
        state, reference = tick["state"], tick["reference_safe"]
        assert isinstance(state, SwarmState)
        assert isinstance(reference, SwarmSetpoint)
        builder.update(SceneSignals(state, reference_safe=reference))


def flown_by_firmware(scenario: Scenario) -> None:
    """Fly a room whose vehicles run their own firmware, from the ground."""
    room = Room(scenario, seed=0)
    fleet = fleet_in(room, scenario, CrtpRoomParams())
    for _ in range(50):
        room.capture()
        room.fly(fleet.fly)


def stacked_in_a_rooms_air() -> None:
    """Fly a stack whose sources feed and absorb each other's jets, in drawn random air."""
    scenario = library.load("stack3")
    predictor = InteractionPredictor(replace(MEASURED_LAW, loading=1.0, absorption=0.5))
    warm_up(predictor.update, predictor.reset, (SwarmState,), scenario.names)
    gaps, radii = np.array([0.1, 1.0]), np.array([0.0, 0.2])
    term = JetTerm(gaps, radii, np.array([[2.0, 0.0], [1.0, 0.0]]), 0.02, 7.5, 0.5, 0.5)
    start = np.array([vehicle.points[0] for vehicle in scenario.waypoints])
    air = RoomAir(jet=term, residual=ResidualTerm(0.3, 0.1, 0.08))
    swarm = Swarm(scenario.names, scenario.vehicle, start, air)
    drive = np.hstack([np.zeros((len(start), 3)), np.ones((len(start), 4))])
    swarm.step(np.zeros((1, len(start), 4)), drive)
    swarm.downwash()
    batch = SwarmBatch(SwarmBatchSetup(scenario.vehicle, np.stack([start, start]), air))
    batch.step(np.zeros((1, 2, len(start), 4)), np.stack([drive, drive]))


if __name__ == "__main__":
    main()
