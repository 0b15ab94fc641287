"""Distributed MPC without ROS: one guarded MPC for each vehicle, and the exchange of their predictions.

    each Mpc -- command of its vehicle --> joined command
        |  ^
        +--+-- predictions, in turns, `delay` ticks later, some of them lost

In a tick every MPC answers by what it has received in earlier ticks, as the nodes do.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.neighbours.exchanged_paths import PredictedPaths
from q2q_control.mpc.neighbours.time_slots import RATE_HZ, BroadcastSchedule
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.signals.values import Interference, Names, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.loop.command_gate import joined_command
from q2q_sim.loop.flight_blocks import BlockChoices, mpc_params
from q2q_sim.random_streams import stream
from q2q_sim.scenarios.scenario import Scenario


@dataclass(frozen=True, slots=True)
class ExchangeParams:
    """MPCs of a distributed flight, and the network between them."""

    rate_hz: float = RATE_HZ
    """Predictions of a vehicle per second."""
    delay: int = 0
    """Ticks by which a prediction arrives later than before the next tick."""
    loss: float = 0.0
    """Share of predictions that a receiver does not get, 0 to 1."""
    seed: int = 0
    controlled: tuple[Names, ...] = ()
    """Vehicles of each MPC; one each if empty."""

    def __post_init__(self) -> None:
        """Check the bounds."""
        if self.delay < 0 or self.delay != int(self.delay) or not 0.0 <= self.loss <= 1.0:
            words = "must be whole ticks >= 0, and in [0, 1]"
            raise ValueError(f"delay {self.delay}, loss {self.loss:g}; {words}")
        if not self.rate_hz > 0.0:
            raise ValueError(f"rate_hz {self.rate_hz:g}; must be above 0")


class DistributedMpc:
    """One guarded MPC for each vehicle."""

    def __init__(
        self,
        scenario: Scenario,
        options: BlockChoices,
        model: InteractionModel,
        plan: SwarmPlan,
        exchange: ExchangeParams | None = None,
    ) -> None:
        """Control the vehicles of `scenario`; `model` is the downwash as the controllers know it."""
        self._exchange = exchange or ExchangeParams()
        self._controlled = self._exchange.controlled or tuple((name,) for name in scenario.names)
        params = mpc_params(scenario, limited=options.limited)
        preview = sampled_preview(plan.names, plan.trajectories, 0.0)
        period = 1.0 / self._exchange.rate_hz
        setups = [MpcSetup(names, preview=preview, exchange_period=period) for names in self._controlled]
        self._mpcs = [Mpc(params, scenario.vehicle, model, setup) for setup in setups]
        hover = scenario.vehicle.hover_thrust
        self._guards = [Guard(mpc, FallbackParams(), hover) for mpc in self._mpcs]
        self._schedules = [BroadcastSchedule(names[:1], period) for names in self._controlled]
        self._names = scenario.names
        self.reset()

    def reset(self) -> None:
        """Forget all ticks."""
        for guard in self._guards:
            guard.reset()
        for schedule in self._schedules:
            schedule.reset()
        self._under_way: list[list[PredictedPaths]] = []
        self._losses = stream(self._exchange.seed, "exchange")

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command of all vehicles."""
        if len(self._under_way) > self._exchange.delay:
            self._deliver(self._under_way.pop(0))
        commands = [guard.update(state, setpoint, interference) for guard in self._guards]
        self._under_way.append(list(self._broadcast(state)))
        return joined_command(self._names, commands)

    def _broadcast(self, state: SwarmState) -> Iterator[PredictedPaths]:
        """Yield the predictions that are sent in this tick."""
        for mpc, schedule in zip(self._mpcs, self._schedules, strict=True):
            prediction = mpc.prediction
            if prediction is not None and schedule.take_turn(state):
                yield prediction

    def _deliver(self, predictions: list[PredictedPaths]) -> None:
        for prediction in predictions:
            for names, mpc in zip(self._controlled, self._mpcs, strict=True):
                if names != prediction.names and self._losses.random() >= self._exchange.loss:
                    mpc.receive(prediction)
