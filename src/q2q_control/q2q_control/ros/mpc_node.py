"""MPC node: `state`, `reference_safe`, `interference` (if aware), latched `plan` in, `command` out.

With `distributed:=true`, one node controls one vehicle or some, and exchanges `predictions` with the others.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from time import monotonic

from q2q_msgs.msg import Plan
from rclpy.node import Node

from q2q_control.inputs.plan_mismatch import PlanMismatchMonitor
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.inputs.preview import SampledPreview, resting_preview
from q2q_control.mpc.bounds_warm_up import at_bounds
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.neighbours.time_slots import RATE_HZ
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.time_budget import TimeBudget
from q2q_control.ros.accelerometers import receive_accelerometers
from q2q_control.ros.controller_wiring import ControllerNodeParams, CorrectionNodeParams, wire_controller
from q2q_control.ros.prediction_exchange import PredictionExchange
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.model_files.find_model import find_model
from q2q_model.node.warm_up import STAND_IN
from q2q_model.ros.node.input_warnings import AbsentNames
from q2q_model.ros.node.node_parameters import declare, on_change
from q2q_model.ros.node.ready import expect_latched
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.ros.topics.messages import stamp_of
from q2q_model.ros.topics.plan_message import decode_trajectories
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import time_from_stamp
from q2q_model.signals.topic_names import PLAN
from q2q_model.signals.values import Interference, Names, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import vehicle_by_name

MISMATCH = "plan's course"
"""Doubt of a plan that is not that of the setpoints."""
NEIGHBOUR = "neighbour"
"""Vehicle of another controller in the warm-up."""


@dataclass(frozen=True, slots=True)
class MpcNodeParams:
    """Parameters of the node in addition to those of every controller node."""

    model: str = tunable("none", "interaction model: none, a shipped name, or a .q2q file", read_only=True)
    distributed: bool = tunable(
        default=False,
        description=(
            "publish the predictions of this node's `vehicles` on the topic predictions, "
            "and use those of other nodes"
        ),
        read_only=True,
    )
    prediction_hz: float = tunable(
        RATE_HZ,
        "distributed: rate at which predictions of a vehicle are published; the same for all nodes",
        unit="Hz",
        low=0.1,
        high=100.0,
        read_only=True,
    )
    budget_s: float = tunable(
        0.006,
        "live: time for solving in a tick; vehicles not solved by then use their last solution, "
        "shifted in time",
        unit="s",
        low=1e-4,
        high=1.0,
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[SwarmCommand]:
    """Wire the MPC into a node; its parameters may change in flight."""
    own, mpc = declare(node, ControllerNodeParams()), declare(node, MpcNodeParams())
    correct = declare(node, CorrectionNodeParams()).correct
    vehicle = vehicle_by_name(own.vehicle, own.firmware)
    params = declare(node, MpcParams(), in_flight=True)
    budget = TimeBudget(mpc.budget_s if own.live else inf, monotonic)
    known = find_model(mpc.model)
    residual_process = (known.residual or REAL_FLIGHTS) if correct else None
    period = 1.0 / mpc.prediction_hz if mpc.distributed else 0.0
    setup = MpcSetup(own.vehicles, budget.in_time, residual_process=residual_process, exchange_period=period)
    block = Mpc(params, vehicle, known.interaction, setup)
    on_change(node, params, block.configure)
    wiring, guarded = wire_controller(node, own, vehicle, block)
    if correct:
        receive_accelerometers(node, block.sense, wiring.health)
    exchange = PredictionExchange(node, block, own.vehicles, period) if mpc.distributed else None

    def compute(
        state: SwarmState, setpoint: SwarmSetpoint, downwash: Interference | None = None
    ) -> SwarmCommand:
        if exchange is not None:
            exchange.begin(state)
        command = guarded.update(state, setpoint, downwash)
        sources = block.report.sources
        wiring.health.fallbacks += int(sources.shifted + sources.pd > 0)
        return command

    wiring.add_diagnostic_values(lambda: {"iterations": str(block.report.iterations)})
    _receive_plans(node, block, wiring)
    warmed_up = _receiving_itself(block, compute) if mpc.distributed else compute
    _warm_up(block, wiring, warmed_up, guarded.reset, (*(own.vehicles or STAND_IN), NEIGHBOUR))
    if exchange is not None:
        exchange.wire(wiring, live=own.live)
    wiring.start(_within(budget, compute))
    return wiring


def _receive_plans(node: Node, block: Mpc, wiring: TickWiring[SwarmCommand]) -> None:
    """Let the block follow the plans on `plan`; an invalid one is refused, the last one kept."""
    unplanned = AbsentNames(node, PLAN, "{}: flown without looking ahead", wiring.health)
    mismatch = PlanMismatchMonitor()

    def take(message: Plan) -> None:
        try:
            preview = preview_of(message)
        except ValueError as refusal:
            wiring.health.refuse(f"plan (the last one is kept): {refusal}")
            return
        block.follow(preview)
        unplanned.take_source(preview.names)
        mismatch.take_plan(preview)
        wiring.health.doubts[MISMATCH] = ""
        came()

    def compare(_: int, reference: Signal) -> None:
        if isinstance(reference, SwarmSetpoint):
            wiring.health.doubts[MISMATCH], is_new = mismatch.update(reference)
            if is_new:
                node.get_logger().warning(f"{wiring.health.doubts[MISMATCH]}; flown without looking ahead")

    came = expect_latched(node, node.create_subscription(Plan, PLAN, take, LATCHED))
    wiring.listen("reference_safe", unplanned.update)
    wiring.listen("reference_safe", compare)
    wiring.expect_one_publisher(PLAN)


def _warm_up(
    block: Mpc,
    wiring: TickWiring[SwarmCommand],
    update: Callable[..., SwarmCommand],
    reset: Callable[[], None],
    vehicles: Names,
) -> None:
    """Warm up the node with vehicles at rest, and at their bounds beside one without a setpoint."""
    block.follow(resting_preview(vehicles))
    wiring.warm_up(update, reset, vehicles)
    wiring.warm_up(at_bounds(update), reset, vehicles)
    block.follow(None)


def _receiving_itself(block: Mpc, compute: Callable[..., SwarmCommand]) -> Callable[..., SwarmCommand]:
    """Return `compute`, after which the block receives its own prediction as that of NEIGHBOUR."""

    def update(*signals: Signal) -> SwarmCommand:
        command, own = compute(*signals), block.prediction
        if own is not None:
            block.receive(replace(own, names=(NEIGHBOUR,), pos=own.pos[:1]))
        return command

    return update


def _within(budget: TimeBudget, compute: Callable[..., SwarmCommand]) -> Callable[..., SwarmCommand]:
    """Return `compute` with a budget that starts at each tick; the warm-up, without it, loads all code."""

    def update(*signals: Signal) -> SwarmCommand:
        budget.begin()
        return compute(*signals)

    return update


def preview_of(message: Plan) -> SampledPreview:
    """Return the preview of the plan in a message."""
    start = time_from_stamp(stamp_of(message.header))
    return sampled_preview(tuple(message.names), decode_trajectories(message), start)


def main() -> None:
    """Run the node `mpc`."""
    run("mpc", build)
