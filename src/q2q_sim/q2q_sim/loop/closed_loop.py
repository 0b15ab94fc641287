"""Flight of a scenario without ROS: the blocks of the nodes, called in turn, as fast as they compute.

    room.capture -> mocap filter -> predictor -> plan -> replanner -> controller -> room.advance

Order, inputs and stamps are those of the nodes in lockstep; a test checks that both give the same numbers.
`fly` records everything; `answered_ticks` computes only what moves the vehicles, for campaigns.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS, ResidualProcess
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.flights.flight import Flight
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import TICK_NS, TICK_S
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.loop.flight_blocks import BlockChoices, Blocks, Mode, blocks_of
from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.loop.room import Room, Tick
from q2q_sim.scenarios.scenario import Scenario

SignalListener = Callable[[str, int, Signal], None]
"""Function of topic, stamp of the tick [ns] and signal."""


def ignore_signals(_: str, __: int, ___: Signal) -> None:
    """Ignore the signal."""


@dataclass(frozen=True, slots=True)
class LoopSettings:
    """What the loop itself depends on, whichever blocks fly."""

    mode: Mode = "aware"
    """Ignoring: the controller does not know of the downwash."""
    seed: int = 0
    air: FlownAir | None = None
    """Air in place of the scenario's air, or wake and disturbance."""
    on_signal: SignalListener = ignore_signals
    """Called with every signal of q2q_sim.flight_bag.topics, as a recorder of the nodes' topics."""


@dataclass(frozen=True, slots=True)
class FlightOptions:
    """Options of a flight."""

    mode: Mode = "aware"
    controller: str = "pid"
    replan: str = "none"
    """none, paper or safe."""
    seed: int = 0
    model: InteractionModel = field(default_factory=NoInteraction)
    """Interaction model of the predictor; the scenario's own is find_model(scenario.model).interaction
    (q2q_model.model_files.find_model)."""
    air: FlownAir | None = None
    """As in LoopSettings."""
    plan: SwarmPlan | None = None
    """Plan in place of the scenario's own."""
    residual_process: ResidualProcess | None = None
    """Residual of the model that the controller corrects by accelerometers; None corrects nothing."""
    on_signal: SignalListener = ignore_signals
    """As in LoopSettings."""

    @property
    def loop(self) -> LoopSettings:
        """Return the settings of the loop."""
        return LoopSettings(self.mode, self.seed, self.air, self.on_signal)


@dataclass(frozen=True, slots=True)
class BlockSignals:
    """Signals with which the blocks answer the frame of a tick."""

    state: SwarmState
    reference: SwarmSetpoint
    reference_safe: SwarmSetpoint
    """By the replanner."""
    command: SwarmCommand


def fly(scenario: Scenario, options: FlightOptions) -> Flight:
    """Fly a scenario and return its recording.

    Raises:
        ValueError: an unknown mode or controller, a seed below 0, or an air that cannot be flown in.
    """
    return fly_blocks(scenario, _blocks(scenario, options), options.loop)


def fly_blocks(scenario: Scenario, blocks: Blocks, loop: LoopSettings) -> Flight:
    """Fly given blocks and return the recording."""
    room = Room(scenario, loop.seed, loop.air)
    recorder = FlightRecorder(scenario.names, ticks_of(scenario))
    while room.tick * TICK_S < scenario.duration:
        number, tick, imu = room.tick, room.capture(), room.imu()
        recorder.frame(number, tick.stamp_ns, tick.frame)
        recorder.truth(number, tick.truth, tick.truth_interference, imu)
        loop.on_signal("truth", tick.stamp_ns, tick.truth)
        loop.on_signal("truth_interference", tick.stamp_ns, tick.truth_interference)
        loop.on_signal("imu", tick.stamp_ns, imu)
        state = blocks.mocap_filter.update(tick.frame)
        downwash = blocks.predictor.update(state)
        answer = _answer(blocks, tick, state, downwash if loop.mode != "ignoring" else None)
        blocks.sense(imu)
        _record(recorder, tick, answer, downwash)
        _report(loop.on_signal, tick, answer, downwash)
        room.advance(answer.command)
    return recorder.flight(f"{scenario.name} {loop.mode} seed {loop.seed}")


def answered_ticks(scenario: Scenario, options: FlightOptions) -> Iterator[tuple[Tick, BlockSignals]]:
    """Fly a scenario; yield each tick and its answer, before the vehicles move on.

    The flight is that of `fly`, which also computes what is only recorded.

    Raises:
        ValueError: as `fly`.
    """
    blocks, room = _blocks(scenario, options), Room(scenario, options.seed, options.air)
    while room.tick * TICK_S < scenario.duration:
        tick = room.capture()
        state = blocks.mocap_filter.update(tick.frame)
        downwash = blocks.predictor.update(state) if options.mode != "ignoring" else None
        answer = _answer(blocks, tick, state, downwash)
        if options.residual_process is not None:
            blocks.sense(room.imu())
        yield tick, answer
        room.advance(answer.command)


def ticks_of(scenario: Scenario) -> int:
    """Return the number of ticks of a flight."""
    count = round(scenario.duration / TICK_S)
    return count + (count * TICK_S < scenario.duration)


def _blocks(scenario: Scenario, options: FlightOptions) -> Blocks:
    choice = BlockChoices(
        options.mode, options.controller, options.replan, options.residual_process is not None
    )
    return blocks_of(scenario, choice, options.model, options.plan, options.residual_process or REAL_FLIGHTS)


def _answer(blocks: Blocks, tick: Tick, state: SwarmState, downwash: Interference | None) -> BlockSignals:
    """Return the answer to a tick; without downwash, the controller ignores it."""
    reference = blocks.player.update(tick.frame)
    reference_safe = blocks.replanner.update(reference, state)
    return BlockSignals(
        state, reference, reference_safe, blocks.controller.update(state, reference_safe, downwash)
    )


def _record(recorder: FlightRecorder, tick: Tick, answer: BlockSignals, downwash: Interference) -> None:
    number = tick.stamp_ns // TICK_NS
    recorder.state(number, answer.state, downwash)
    recorder.setpoints(number, answer.reference, answer.reference_safe)
    recorder.command(number, answer.command)


def _report(on_signal: SignalListener, tick: Tick, answer: BlockSignals, downwash: Interference) -> None:
    signals: dict[str, Signal] = {"mocap": tick.frame, "state": answer.state, "interference": downwash}
    signals |= {
        "reference": answer.reference,
        "reference_safe": answer.reference_safe,
        "command": answer.command,
    }
    for topic, signal in signals.items():
        on_signal(topic, tick.stamp_ns, signal)
