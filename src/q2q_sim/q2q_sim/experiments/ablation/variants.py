"""Variants of the controller in the ablation, all with the same gains and the same learned model.

| name | downwash model | against what the model does not explain |
|---|---|---|
| ignoring | no | nothing |
| integral | no | integral |
| observer | no | disturbance observer |
| aware | yes | nothing |
| aware + observer | yes | disturbance observer |
| aware + correction | yes | accelerometers |
| MPC | yes, ahead | disturbance observer |
| MPC + correction | yes, ahead | accelerometers |
| distributed | yes, ahead | disturbance observer; one MPC per vehicle, which gets the others' predictions |
| Mellinger | no | integral, on board |
| on board | yes | accelerometers, on board: the firmware app around Mellinger's controller |

The first nine are the controllers that `fly` flies, from a ground station: `pid`, with an integral or an
observer in three of them, `mpc`, and `mpc --distributed`. K_p and K_d are the scenario's;
K_i = 0.12 K_p K_d, an eighth of the stability limit (Routh: K_i < K_p K_d). The MPC has its default tuning.
Mellinger's controller has its stock gains.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from q2q_control.controller import Controller
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.guard import Guard
from q2q_control.pid.observed_pid import ObservedPid
from q2q_control.pid.pid import Pid
from q2q_sim.experiments.ablation.learned_models import LearnedModel
from q2q_sim.loop.distributed import DistributedMpc, ExchangeParams
from q2q_sim.loop.flight_blocks import BlockChoices, Blocks, blocks_of, pid_params, plan_of, tracker_params
from q2q_sim.scenarios.scenario import Scenario

INTEGRAL_SHARE = 0.12
"""K_i over K_p K_d [-]."""


@dataclass(frozen=True, slots=True)
class VariantInputs:
    """Scenario and model that a variant is built for."""

    scenario: Scenario
    model: LearnedModel
    each: int
    """Vehicles of a draw, which follow each other in the scenario."""


@dataclass(frozen=True, slots=True)
class Variant:
    """Variant on a ground station."""

    built: Callable[[VariantInputs], Blocks]
    aware: bool = True
    """Whether it is given the predicted downwash."""


def _shipped(choice: BlockChoices) -> Callable[[VariantInputs], Blocks]:
    def built(given: VariantInputs) -> Blocks:
        return blocks_of(given.scenario, choice, given.model.jet, residual=given.model.process)

    return built


def _integral(given: VariantInputs) -> Blocks:
    gains = pid_params(given.scenario, limited=False)
    gains = replace(gains, k_i_z=INTEGRAL_SHARE * gains.k_p_z * gains.k_d_z)
    return _with(given, Pid(gains, given.scenario.vehicle))


def _observed(given: VariantInputs) -> Blocks:
    gains, tracker = pid_params(given.scenario, limited=False), tracker_params(given.scenario)
    return _with(given, ObservedPid(gains, tracker, given.scenario.vehicle))


def _with(given: VariantInputs, controller: Controller) -> Blocks:
    guarded = Guard(controller, FallbackParams(), given.scenario.vehicle.hover_thrust)
    return replace(_shipped(BlockChoices())(given), controller=guarded)


def _distributed(given: VariantInputs) -> Blocks:
    names = given.scenario.names
    controlled = tuple(names[k :: given.each] for k in range(given.each))  # draws are out of reach
    choice = BlockChoices(controller="mpc")
    network = ExchangeParams(controlled=controlled)
    controller = DistributedMpc(given.scenario, choice, given.model.jet, plan_of(given.scenario), network)
    return replace(_shipped(choice)(given), controller=controller)


VARIANTS = {
    "ignoring": Variant(_shipped(BlockChoices("ignoring")), aware=False),
    "integral": Variant(_integral, aware=False),
    "observer": Variant(_observed, aware=False),
    "aware": Variant(_shipped(BlockChoices())),
    "aware + observer": Variant(_observed),
    "aware + correction": Variant(_shipped(BlockChoices(correct=True))),
    "MPC": Variant(_shipped(BlockChoices(controller="mpc"))),
    "MPC + correction": Variant(_shipped(BlockChoices(controller="mpc", correct=True))),
    "distributed": Variant(_distributed),
}
"""Variants on a ground station."""
ONBOARD = {"Mellinger": False, "on board": True}
"""Variants on the vehicle, and whether they have the app."""
NAMES = (*VARIANTS, *ONBOARD)
"""Rows of the tables."""
TWINS = (
    ("aware", "ignoring"),
    ("aware + observer", "observer"),
    ("MPC", "aware + observer"),
    ("aware + correction", "aware + observer"),
    ("MPC + correction", "MPC"),
    ("distributed", "MPC"),
    ("on board", "Mellinger"),
)
"""Variants that differ from another by one part."""
