"""Distributed MPC without ROS: one guarded MPC for each vehicle, and the exchange of their predictions.

    each Mpc -- command of its vehicle --> joined command
        |  ^
        +--+-- predictions, `delay` ticks later, some of them lost

In a tick every MPC answers by what it has heard in earlier ticks, as the nodes do.
"""

from dataclasses import dataclass

from q2q_control.failsafe.guard import Guard
from q2q_control.failsafe.ladder import FallbackParams
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.mpc.prediction.neighbours import PredictedPaths
from q2q_control.mpc.receding import Mpc, MpcSetup
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.signals.values import Interference, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.loop.assembly import Options, mpc_params
from q2q_sim.loop.lockstep import joined_command
from q2q_sim.random_streams import stream
from q2q_sim.scenarios.scenario import Scenario


@dataclass(frozen=True, slots=True)
class ExchangeParams:
    """Network between the MPCs of a distributed flight."""

    delay: int = 0
    """Ticks by which a prediction arrives later than before the next tick."""
    loss: float = 0.0
    """Share of predictions that a receiver does not get, 0 to 1."""
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the bounds."""
        if self.delay < 0 or not 0.0 <= self.loss <= 1.0:
            raise ValueError(f"delay {self.delay}, loss {self.loss:g}: 0 or more, and 0 to 1 are allowed")


class DistributedMpc:
    """One guarded MPC for each vehicle."""

    def __init__(
        self,
        scenario: Scenario,
        options: Options,
        model: InteractionModel,
        plan: SwarmPlan,
        exchange: ExchangeParams | None = None,
    ) -> None:
        """Control the vehicles of `scenario`; `model` is the downwash as the controllers know it."""
        params = mpc_params(scenario, limited=options.limited)
        preview = sampled_preview(plan.names, plan.trajectories, 0.0)
        setups = [MpcSetup((name,), preview=preview, exchange=True) for name in scenario.names]
        self._mpcs = [Mpc(params, scenario.vehicle, model, setup) for setup in setups]
        hover = scenario.vehicle.hover_thrust
        self._guards = [Guard(mpc, FallbackParams(), hover) for mpc in self._mpcs]
        self._names, self._exchange = scenario.names, exchange or ExchangeParams()
        self.reset()

    def reset(self) -> None:
        """Forget all ticks."""
        for guard in self._guards:
            guard.reset()
        self._under_way: list[list[PredictedPaths]] = []
        self._losses = stream(self._exchange.seed, "exchange")

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command of all vehicles."""
        if len(self._under_way) > self._exchange.delay:
            self._deliver(self._under_way.pop(0))
        commands = [guard.update(state, setpoint, interference) for guard in self._guards]
        self._under_way.append([mpc.prediction for mpc in self._mpcs if mpc.prediction is not None])
        return joined_command(self._names, commands)

    def _deliver(self, predictions: list[PredictedPaths]) -> None:
        for prediction in predictions:
            for name, mpc in zip(self._names, self._mpcs, strict=True):
                if name not in prediction.names and self._losses.random() >= self._exchange.loss:
                    mpc.hear(prediction)
