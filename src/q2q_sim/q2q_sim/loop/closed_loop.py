"""Flight of a scenario without ROS: the blocks of the nodes, called in turn, as fast as they compute.

    room.capture -> mocap filter -> predictor -> plan -> replanner -> controller -> room.advance

Order, inputs and stamps are those of the nodes in lockstep; a test checks that both give the same numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.downwash.residual_process import REAL_FLIGHTS, ResidualProcess
from q2q_model.flights.flight import Flight
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import SwarmCommand
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_sim.air.find_air import FlownAir
from q2q_sim.loop.assembly import TICK_S, Blocks, Mode, Options, blocks_of
from q2q_sim.loop.recording import FlightRecording
from q2q_sim.loop.room import TICK_NS, Room, Tick
from q2q_sim.scenarios.scenario import Scenario

Listener = Callable[[str, int, Signal], None]
"""Function of topic, stamp of the tick [ns] and signal."""


def ignore_signals(_: str, __: int, ___: Signal) -> None:
    """Ignore the signal."""


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
    (q2q_model.files.find_model)."""
    air: FlownAir | None = None
    """Air in place of the scenario's air, or wake and disturbance."""
    plan: SwarmPlan | None = None
    """Plan in place of the scenario's own."""
    correct: ResidualProcess | None = None
    """Residual of the model that the controller corrects by accelerometers; None corrects nothing."""
    on_signal: Listener = ignore_signals
    """Called with every signal, as a recorder of the nodes' topics."""


def fly(scenario: Scenario, options: FlightOptions) -> Flight:
    """Fly a scenario and return its recording.

    Raises:
        ValueError: an unknown mode or controller, a seed below 0, or an air that cannot be flown in.
    """
    corrects = options.correct is not None
    choice = Options(options.mode, options.controller, options.replan, corrects)
    residual = options.correct or REAL_FLIGHTS
    blocks = blocks_of(scenario, choice, options.model, options.plan, residual)
    return fly_blocks(scenario, blocks, options)


def fly_blocks(scenario: Scenario, blocks: Blocks, options: FlightOptions) -> Flight:
    """Fly given blocks and return the recording; of the options, mode, seed, air and on_signal apply."""
    room = Room(scenario, options.seed, options.air)
    recording = FlightRecording(scenario.names, ticks_of(scenario))
    while room.tick * TICK_S < scenario.duration:
        number, tick = room.tick, room.capture()
        recording.frame(number, tick.stamp_ns, tick.frame)
        recording.truth(number, tick.truth, tick.truth_interference, tick.imu)
        options.on_signal("truth", tick.stamp_ns, tick.truth)
        room.advance(_answer(blocks, tick, recording, options))
    return recording.flight(f"{scenario.name} {options.mode} seed {options.seed}")


def ticks_of(scenario: Scenario) -> int:
    """Return the number of ticks of a flight."""
    count = round(scenario.duration / TICK_S)
    return count + (count * TICK_S < scenario.duration)


def _answer(blocks: Blocks, tick: Tick, recording: FlightRecording, options: FlightOptions) -> SwarmCommand:
    """Return the command of a tick and record the signals that led to it."""
    number = tick.stamp_ns // TICK_NS
    state = blocks.mocap_filter.update(tick.frame)
    downwash = blocks.predictor.update(state)
    planned = setpoint_at(blocks.plan, tick.frame.t)
    given = blocks.replanner.update(planned, state)
    command = blocks.controller.update(state, given, downwash if options.mode != "ignoring" else None)
    blocks.sense(tick.imu)
    recording.state(number, state, downwash)
    recording.setpoints(number, planned, given)
    recording.command(number, command)
    signals: dict[str, Signal] = {"mocap": tick.frame, "state": state, "reference_safe": given}
    signals["command"] = command
    for topic, signal in signals.items():
        options.on_signal(topic, tick.stamp_ns, signal)
    return command
