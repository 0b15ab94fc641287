"""MPC node: `state`, `reference_safe`, `interference`, latched `plan` in, `command` out."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from time import monotonic

from q2q_msgs.msg import Plan
from rclpy.node import Node

from q2q_control.failsafe.ladder import FallbackParams
from q2q_control.failsafe.time_budget import TimeBudget
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.inputs.preview import SampledPreview, resting_preview
from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.receding import Mpc, MpcSetup
from q2q_control.radio.rpyt_scale import LegacyScale
from q2q_control.ros.guarded_commands import GuardedCommands
from q2q_control.ros.legacy_topics import LegacyTopics
from q2q_model.files.find_model import find_model
from q2q_model.node.rehearsal import STAND_IN
from q2q_model.ros.node.node_parameters import declare, on_change
from q2q_model.ros.node.ready import expect_latched
from q2q_model.ros.node.run import run
from q2q_model.ros.node.tick import TickWiring
from q2q_model.ros.topics.plan_message import decode_trajectories
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_parts, time_from_stamp
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import vehicle_by_name
from q2q_model.vehicle.thrust_map import FIRMWARES, STOCK


@dataclass(frozen=True, slots=True)
class MpcNodeParams:
    """Parameters of the node, without the controller's."""

    vehicle: str = tunable("crazyflie_2_0", "vehicle constants to use", read_only=True)
    firmware: str = tunable(STOCK, "its thrust per PWM", choices=FIRMWARES, read_only=True)
    vehicles: tuple[str, ...] = tunable((), "vehicles to command; empty: all of the setpoint", read_only=True)
    aware: bool = tunable(default=True, description="include the downwash in the model", read_only=True)
    model: str = tunable("none", "interaction model: none, a shipped name, or a .q2q file", read_only=True)
    live: bool = tunable(
        default=False, description="watch the wall clock and fall back if a tick is missing", read_only=True
    )
    budget_s: float = tunable(
        0.006,
        "live: longest time to solve in a tick before falling back to the last plan, shifted",
        unit="s",
        low=1e-4,
        high=1.0,
        read_only=True,
    )
    legacy_hz: float = tunable(
        10.0,
        "largest rate of <name>/cmd_vel_legacy; 0: not published",
        unit="Hz",
        low=0.0,
        high=1000.0,
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Refuse values out of bounds."""
        check_bounds(self)


def build(node: Node) -> TickWiring[SwarmCommand]:
    """Wire the MPC into a node; its parameters may change in flight."""
    own = declare(node, MpcNodeParams())
    vehicle = vehicle_by_name(own.vehicle, own.firmware)
    params = declare(node, MpcParams(), in_flight=True)
    budget = TimeBudget(own.budget_s if own.live else inf, monotonic)
    setup = MpcSetup(own.vehicles, budget.in_time)
    block = Mpc(params, vehicle, find_model(own.model).interaction, setup)
    on_change(node, params, block.configure)
    inputs: dict[str, type[Signal]] = {"state": SwarmState, "reference_safe": SwarmSetpoint}
    if own.aware:
        inputs["interference"] = Interference
    wiring = TickWiring(node, inputs, ("command", SwarmCommand))
    wiring.after_publish(
        LegacyTopics(node, LegacyScale(vehicle.full_pwm_thrust), own.legacy_hz, own.vehicles).publish
    )
    guarded = GuardedCommands(block, declare(node, FallbackParams()), vehicle.hover_thrust, live=own.live)
    guarded.wire(node, wiring)

    def take_plan(message: Plan) -> None:
        block.follow(preview_of(message))
        plan_came()

    def answer(
        state: SwarmState, setpoint: SwarmSetpoint, downwash: Interference | None = None
    ) -> SwarmCommand:
        command = guarded.update(state, setpoint, downwash)
        report = block.report
        wiring.health.fallbacks += int(report.shifted + report.pid > 0)
        wiring.health.extra["iterations"] = str(report.iterations)
        return command

    plan_came = expect_latched(node, node.create_subscription(Plan, "plan", take_plan, LATCHED))
    block.follow(resting_preview(own.vehicles or STAND_IN))
    wiring.rehearse(answer, guarded.reset, own.vehicles)
    block.follow(None)
    wiring.start(_within(budget, answer))
    return wiring


def _within(budget: TimeBudget, answer: Callable[..., SwarmCommand]) -> Callable[..., SwarmCommand]:
    """Return `answer` with a budget that starts at each tick; the rehearsal, without it, loads all code."""

    def update(*signals: Signal) -> SwarmCommand:
        budget.begin()
        return answer(*signals)

    return update


def preview_of(message: Plan) -> SampledPreview:
    """Return the preview of the plan in a message."""
    stamp = message.header.stamp
    start = time_from_stamp(stamp_from_parts(stamp.sec, stamp.nanosec))
    return sampled_preview(tuple(message.names), decode_trajectories(message), start)


def main() -> None:
    """Run the node `mpc`."""
    run("mpc", build)
