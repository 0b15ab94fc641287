"""Controllers of the ablation, all with the same gains and the same learned model.

| name | downwash model | against the residual |
|---|---|---|
| ignoring | no | nothing |
| integral | no | integral |
| observer | no | disturbance observer |
| PD aware | yes | nothing |
| PID aware | yes | integral |
| observer aware | yes | disturbance observer |
| MPC | yes, ahead | nothing |
| MPC observer | yes, ahead | disturbance observer |
| explicit | yes, ahead | disturbance observer |

K_p and K_d are the scenario's; K_i = 0.12 K_p K_d, an eighth of the stability limit (Routh: K_i < K_p K_d).
The MPC has its default tuning. The explicit law is distilled from "MPC observer" for the vehicle, its bound
and the model, and replaces only its solver; without active bounds it is the linear law.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from q2q_control.disturbance.tracker import TrackerParams
from q2q_control.explicit.distillation import DistillationParams, distil
from q2q_control.explicit.explicit_solver import explicit_solver
from q2q_control.explicit.law import ExplicitLaw
from q2q_control.explicit.teacher import Teacher
from q2q_control.inputs.controller import Controller
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.receding import Mpc, MpcSetup
from q2q_control.pid.observed_pid import ObservedPid
from q2q_control.pid.pid import Pid
from q2q_model.downwash.jet import Jet
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.loop.assembly import mpc_params, pid_params
from q2q_sim.scenarios.scenario import Scenario

INTEGRAL_SHARE = 0.12
"""K_i over K_p K_d [-]."""


@dataclass(frozen=True, slots=True)
class Situation:
    """What a contender is built for."""

    scenario: Scenario
    plan: SwarmPlan
    model: Jet


@dataclass(frozen=True, slots=True)
class Contender:
    """Row of the tables."""

    built: Callable[[Situation], Controller]
    aware: bool = True
    """Whether it is given the predicted downwash."""


def _pd(given: Situation) -> Controller:
    return Pid(pid_params(given.scenario, limited=False), given.scenario.vehicle)


def _pid(given: Situation) -> Controller:
    gains = pid_params(given.scenario, limited=False)
    return Pid(replace(gains, k_i_z=INTEGRAL_SHARE * gains.k_p_z * gains.k_d_z), given.scenario.vehicle)


def _observed(given: Situation) -> Controller:
    latency = given.scenario.vicon.latency + given.scenario.radio.latency
    gains = pid_params(given.scenario, limited=False)
    return ObservedPid(gains, TrackerParams(latency=latency), given.scenario.vehicle)


def _mpc(given: Situation) -> Controller:
    return Mpc(replace(_params(given), observe=False), given.scenario.vehicle, given.model, _setup(given))


def _observed_mpc(given: Situation) -> Controller:
    return Mpc(replace(_params(given), observe=True), given.scenario.vehicle, given.model, _setup(given))


def _explicit(given: Situation) -> Controller:
    vehicle, params = given.scenario.vehicle, _params(given)
    # the law does not need the room's latency: its inputs include it
    law = _distilled(Teacher(replace(params, latency=0.0), vehicle, given.model, vehicle.thrust_max))
    setup = replace(_setup(given), solver=explicit_solver(law))
    return Mpc(params, vehicle, given.model, setup)


CONTENDERS = {
    "ignoring": Contender(_pd, aware=False),
    "integral": Contender(_pid, aware=False),
    "observer": Contender(_observed, aware=False),
    "PD aware": Contender(_pd),
    "PID aware": Contender(_pid),
    "observer aware": Contender(_observed),
    "MPC": Contender(_mpc),
    "MPC observer": Contender(_observed_mpc),
    "explicit": Contender(_explicit),
}
"""Rows of the tables; a further row is a further entry."""
TWINS = {"PD aware": "ignoring", "PID aware": "integral", "observer aware": "observer"}
"""Contenders that differ from another only by knowing the downwash."""


def _params(given: Situation) -> MpcParams:
    """Return the MPC's parameters; sources' loading is the model's own, as no flight has shown another."""
    return replace(mpc_params(given.scenario, limited=False), loading=0.0)


def _setup(given: Situation) -> MpcSetup:
    return MpcSetup(preview=sampled_preview(given.plan.names, given.plan.trajectories, 0.0))


@lru_cache(maxsize=4)
def _distilled(teacher: Teacher) -> ExplicitLaw:
    return distil(teacher, DistillationParams(), np.random.default_rng(0))
