"""Blocks whose cost is measured, each with a reference that does the same job another way.

| block | reference |
|---|---|
| filter, trajectory, PID, guard, MPC | the same block for one pair at a time |
| interference | the law evaluated on all pairs of the swarm, without a search for those in reach |
| replanner, potential field | the push of all pairs in numpy, without that search |
| replanner, safe | a replanner for each vehicle, the others external |
| simulator | its twin in plain numpy |
| message, encoded and decoded | a copy of its bytes |
| whole tick | the 10 ms that it has in real time |
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cost_growth.scene import BEFORE, Scene, Tick
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.pid.pid import Pid
from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.signals.cdr.cdr_reader import SignalReader
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.stamps import stamp_from_time
from q2q_model.signals.values import (
    Interference,
    Names,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_planner.online.potential_field import PotentialField, PotentialFieldParams, repulsive_force
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.loop.flight_blocks import BlockChoices, blocks_of, filter_params, pid_params
from q2q_sim.loop.room import STEPS
from q2q_sim.plant.swarm import Swarm
from q2q_sim.plant.swarm_air import still_air
from swarm_numpy import run_numpy

Task = Callable[[int], object]
"""Work of a tick, by its number in the scene."""
Made = tuple[object, Callable[[Tick], object]]
"""What keeps the arrays of a block, and the work of a tick."""

PAIR = 2
BY_PAIRS = "one pair at a time"
ZONE = SafeReplannerParams(eps=0.15, tracking=0.02)
"""As of the replanner's ticks in the area planning."""
MOST_MPC = 200
"""Vehicles up to which MPC is measured: 100 pairs are beyond a tick of real time on one core."""


@dataclass(frozen=True, slots=True)
class TimedBlock:
    """Block of a scene with its reference."""

    name: str
    task: Task
    keeps: object
    """What holds the arrays that outlive a tick."""
    beside: str
    """Name of the reference."""
    reference: Task
    times: float = 1.0
    """How often the reference has to run for the same job."""


@dataclass(slots=True)
class _Given:
    """Controller that answers a given command: what a guard costs alone."""

    command: SwarmCommand

    def update(self, _: SwarmState, __: SwarmSetpoint, ___: Interference | None) -> SwarmCommand:
        """Return the given command."""
        return self.command

    def reset(self) -> None:
        """Do nothing."""


def timed_blocks(scene: Scene) -> list[TimedBlock]:
    """Return new blocks for a scene."""
    made = [_filter, _interference, _trajectory, _potential_field, _safe, _pid, _guard, _guard_in_fallback]
    made += [_mpc] if len(scene.scenario.names) <= MOST_MPC else []
    return [*(one(scene) for one in [*made, _simulator]), *_message(scene)]


def _by_pairs(name: str, scene: Scene, make: Callable[[Names], Made]) -> TimedBlock:
    """Return a block made for all vehicles, and one made for the first pair."""
    names = scene.scenario.names
    keeps, whole = make(names)
    _, single = make(names[:PAIR])
    pair = [tick.of(names[:PAIR]) for tick in scene.ticks]
    return TimedBlock(
        name,
        lambda k: whole(scene.ticks[k]),
        keeps,
        BY_PAIRS,
        lambda k: single(pair[k]),
        len(names) / PAIR,
    )


def _filter(scene: Scene) -> TimedBlock:
    def make(names: Names) -> Made:
        block = MocapFilter(filter_params(scene.scenario), names)
        return block, lambda tick: block.update(tick.frame)

    return _by_pairs("mocap filter", scene, make)


def _interference(scene: Scene) -> TimedBlock:
    block, model = InteractionPredictor(scene.model), scene.model

    def all_pairs(k: int) -> object:
        pos = scene.ticks[k].state.pos
        rel_pos = pos - pos[:, None]  # (n, n, 3)
        return model.acceleration(rel_pos, pairs_at_rest(rel_pos))

    task: Task = lambda k: block.update(scene.ticks[k].state)  # noqa: E731
    return TimedBlock("interference", task, block, "the law on all pairs", all_pairs)


def _trajectory(scene: Scene) -> TimedBlock:
    def make(names: Names) -> Made:
        plan = SwarmPlan(names, scene.plan.trajectories[: len(names)])
        return plan, lambda tick: setpoint_at(plan, tick.frame.t)

    return _by_pairs("trajectory", scene, make)


def _potential_field(scene: Scene) -> TimedBlock:
    block, params = PotentialField(), PotentialFieldParams()

    def all_pairs(k: int) -> object:
        pos = scene.ticks[k].planned.pos
        return repulsive_force(pos[:, None] - pos, params).sum(axis=1)

    task: Task = lambda k: block.update(scene.ticks[k].planned, None)  # noqa: E731
    return TimedBlock("replanner, potential field", task, block, "the push of all pairs, numpy", all_pairs)


def _safe(scene: Scene) -> TimedBlock:
    block, alone, first = SafeReplanner(ZONE), SafeReplanner(ZONE), np.array([0])
    own = [of_vehicles(tick.planned, first) for tick in scene.ticks]
    task: Task = lambda k: block.update(scene.ticks[k].planned, None)  # noqa: E731
    return TimedBlock(
        "replanner, safe",
        task,
        block,
        "a replanner for each vehicle",
        lambda k: alone.update(own[k], scene.ticks[k].state),
        len(scene.scenario.names),
    )


def _pid(scene: Scene) -> TimedBlock:
    def make(_: Names) -> Made:
        block = Pid(pid_params(scene.scenario, limited=True), scene.scenario.vehicle)
        return block, lambda tick: block.update(tick.state, tick.planned, tick.downwash)

    return _by_pairs("PID", scene, make)


def _guard(scene: Scene) -> TimedBlock:
    def make(_: Names) -> Made:
        given = _Given(scene.ticks[0].command)
        block = Guard(given, FallbackParams(), scene.scenario.vehicle.hover_thrust)

        def guarded(tick: Tick) -> object:
            given.command = tick.command
            return block.update(tick.state, tick.planned, tick.downwash)

        return block, guarded

    return _by_pairs("guard", scene, make)


def _guard_in_fallback(scene: Scene) -> TimedBlock:
    """Return the guard of a room whose cameras have stopped: it flies every vehicle by dead reckoning."""

    def make(_: Names) -> Made:
        first = scene.ticks[BEFORE - 1]
        given = _Given(first.command)
        block = Guard(given, FallbackParams(), scene.scenario.vehicle.hover_thrust)

        def guarded(tick: Tick) -> object:
            if block.newest < first.state.t:
                block.update(first.of(tick.state.names).state, tick.planned, tick.downwash)
            given.command = tick.command
            return block.update(_unseen(tick.state, first.state.t), tick.planned, tick.downwash)

        return block, guarded

    return _by_pairs("guard, nobody measured", scene, make)


def _unseen(state: SwarmState, last: float) -> SwarmState:
    """Return a state whose vehicles were all measured at `last` [s] for the last time."""
    lost = np.full(len(state.names), TrackStatus.LOST, dtype=np.uint8)
    return replace(state, status=lost, age=np.full(len(state.names), state.t - last))


def _mpc(scene: Scene) -> TimedBlock:
    def make(names: Names) -> Made:
        plan = SwarmPlan(names, scene.plan.trajectories[: len(names)])
        flown = replace(scene.scenario, waypoints=scene.scenario.waypoints[: len(names)])
        block = blocks_of(flown, BlockChoices(controller="mpc"), scene.model, plan).controller
        return block, lambda tick: block.update(tick.state, tick.planned, tick.downwash)

    return _by_pairs("MPC of pairs", scene, make)


def _simulator(scene: Scene) -> TimedBlock:
    scenario = scene.scenario
    start = np.array([vehicle.points[0] for vehicle in scenario.waypoints])  # (n, 4)
    swarm = Swarm(scenario.names, scenario.vehicle, start, WakeLaw.MEASURED)
    state = swarm.state.copy()
    air = still_air(state, WakeLaw.MEASURED, swarm.body)
    drive = np.hstack([np.zeros((len(start), 3)), np.ones((len(start), 4))])
    sent = [_rows_of(tick.command) for tick in scene.ticks]
    return TimedBlock(
        "simulator, 5 steps",
        lambda k: swarm.step(sent[k], drive),
        swarm,
        "numpy twin",
        lambda k: run_numpy(state, air, sent[k][:1], drive, swarm.body),
        STEPS,
    )


def _rows_of(command: SwarmCommand) -> np.ndarray:
    """Return the command of every physics step of a tick, (STEPS, n, 4)."""
    row = np.column_stack([command.thrust, command.roll, command.pitch, command.yaw_rate])
    return np.repeat(row[None], STEPS, axis=0)


def _message(scene: Scene) -> list[TimedBlock]:
    sent = [encode(tick.state, stamp_from_time(tick.state.t)) for tick in scene.ticks]
    reader, beside = SignalReader(SwarmState), "a copy of its bytes"
    tasks: dict[str, Task] = {
        "encoded": lambda k: encode(scene.ticks[k].state, stamp_from_time(scene.ticks[k].state.t)),
        "decoded": lambda k: reader.read(sent[k]),
    }
    one = np.frombuffer(sent[0], np.uint8)
    return [
        TimedBlock(f"message {word}", task, one, beside, lambda k: bytearray(sent[k]))
        for word, task in tasks.items()
    ]
