"""Signals of a flight of n vehicles, made before any clock starts.

Pairs fly on a square grid of 2 m, the upper half a metre over the lower: the density is the same for every n,
so a vehicle has as many neighbours among 1000 as among 10. One flight without ROS (as `closed_loop`), under
PID control with the downwash compensated, gives every signal of every tick. Each upper vehicle passes over
its lower one at 1 s.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from time import process_time

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.layout import Signal
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import (
    Interference,
    MocapFrame,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    index_of,
)
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_sim.loop.flight_blocks import BlockChoices, blocks_of, plan_of
from q2q_sim.loop.room import Room
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_document import scenario_from_document
from scale import passing_pairs

DURATION = 4.0
"""Of a pass and the way back [s]."""
BEFORE = 80
"""Ticks flown before the timed ones: the pass begins."""


@dataclass(frozen=True, slots=True)
class Tick:
    """Signals of one tick."""

    frame: MocapFrame
    state: SwarmState
    downwash: Interference
    planned: SwarmSetpoint
    command: SwarmCommand

    def of(self, names: Names) -> "Tick":
        """Return the tick of some vehicles."""
        parts = (self.frame, self.state, self.downwash, self.planned, self.command)
        return Tick(*(_of(part, names) for part in parts))


@dataclass(frozen=True, slots=True)
class Scene:
    """Flight of n vehicles: what blocks are built from, and all signals."""

    scenario: Scenario
    plan: SwarmPlan
    model: InteractionModel
    ticks: tuple[Tick, ...]
    seconds: tuple[float, ...]
    """Processor time of each whole tick, simulated room included [s]."""

    @property
    def timed(self) -> Sequence[int]:
        """Return the numbers of the ticks after BEFORE."""
        return range(BEFORE, len(self.ticks))


def scene_of(vehicles: int, timed: int) -> Scene:
    """Fly pairs for BEFORE + `timed` ticks."""
    side = ceil(sqrt(vehicles / 2))
    scenario = scenario_from_document(f"pairs_{vehicles}", passing_pairs(vehicles, DURATION, side))
    plan, model = plan_of(scenario), find_model(scenario.model).interaction
    blocks, room = blocks_of(scenario, BlockChoices("aware"), model, plan), Room(scenario, 0)
    ticks, seconds = [], []
    for _ in range(BEFORE + timed):
        start = process_time()
        frame = room.capture().frame
        state = blocks.mocap_filter.update(frame)
        downwash = blocks.predictor.update(state)
        planned = blocks.replanner.update(setpoint_at(plan, frame.t), state)
        command = blocks.controller.update(state, planned, downwash)
        room.advance(command)
        seconds.append(process_time() - start)
        ticks.append(Tick(frame, state, downwash, planned, command))
    return Scene(scenario, plan, model, tuple(ticks), tuple(seconds))


def _of(signal: Signal, names: Names) -> Signal:
    rows = index_of(names, signal.names)
    return of_vehicles(signal, rows[rows >= 0])
