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
The MPC has its default tuning. The explicit law is distilled from "MPC observer" for the case's vehicle,
bound and model, and replaces only its solver; without active bounds it is the linear law.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from q2q_control.disturbance.tracker import TrackerParams
from q2q_control.explicit.distillation import DistillationParams, distil
from q2q_control.explicit.explicit_solver import explicit_solver
from q2q_control.explicit.law import ExplicitLaw
from q2q_control.explicit.teacher import Teacher
from q2q_control.inputs.controller import Controller
from q2q_control.inputs.plan_samples import sampled_preview
from q2q_control.inputs.preview import SampledPreview
from q2q_control.mpc.receding import Mpc, MpcSetup
from q2q_control.pid.observed_pid import ObservedPid
from q2q_control.pid.pid import Pid
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.experiments.ablation.learned_model import Learned
from q2q_sim.loop.assembly import mpc_params, pid_params
from q2q_sim.scenarios.scenario import Scenario

CONTENDERS = (
    "ignoring", "PD aware", "PID aware", "integral", "observer", "observer aware", "MPC", "MPC observer",
    "explicit",
)  # fmt: skip
BLIND = ("ignoring", "integral", "observer")
"""Contenders without a downwash model."""
INTEGRAL_SHARE = 0.12
"""K_i over K_p K_d [-]."""


def built(name: str, flown: tuple[Scenario, SwarmPlan], learned: Learned, *, limited: bool) -> Controller:
    """Return a fresh contender for a scenario and its plan; raise ValueError for an unknown name."""
    scenario, plan = flown
    gains = pid_params(scenario, limited=limited)
    integral = replace(gains, k_i_z=INTEGRAL_SHARE * gains.k_p_z * gains.k_d_z)
    latency = scenario.vicon.latency + scenario.radio.latency
    tracker = TrackerParams(latency=latency)
    if name in ("ignoring", "PD aware"):
        return Pid(gains, scenario.vehicle)
    if name in ("integral", "PID aware"):
        return Pid(integral, scenario.vehicle)
    if name in ("observer", "observer aware"):
        return ObservedPid(gains, tracker, scenario.vehicle)
    if name not in CONTENDERS:
        raise ValueError(f"unknown contender {name!r}: choose one of {', '.join(CONTENDERS)}")
    params = replace(mpc_params(scenario, limited=limited), loading=learned.loading)
    setup = MpcSetup(preview=_preview(plan))
    if name == "explicit":
        setup = replace(setup, solver=explicit_solver(_law(scenario, learned, limited=limited)))
    else:
        params = replace(params, observe=name == "MPC observer")
    return Mpc(params, scenario.vehicle, learned.model, setup)


def _law(scenario: Scenario, learned: Learned, *, limited: bool) -> ExplicitLaw:
    vehicle, params = scenario.vehicle, mpc_params(scenario, limited=limited)
    bound = min(params.thrust_max, vehicle.thrust_max) if limited else vehicle.thrust_max
    # the law needs neither the room's latency nor the sources' thrust: its inputs include them
    return _distilled(Teacher(replace(params, latency=0.0, loading=0.0), vehicle, learned.model, bound))


@lru_cache(maxsize=4)
def _distilled(teacher: Teacher) -> ExplicitLaw:
    return distil(teacher, DistillationParams(), np.random.default_rng(0))


def _preview(plan: SwarmPlan) -> SampledPreview:
    return sampled_preview(plan.names, plan.trajectories, 0.0)
