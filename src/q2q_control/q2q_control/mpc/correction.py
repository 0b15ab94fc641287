"""MPC with corrected predictions: residual along the horizon, and bandwidth of the altitude loop.

The residual fades along the horizon as its process does, d(s) = b + r exp(-s / T). What fades before thrust
follows cannot be cancelled, but feedback removes its effect on height, with a bandwidth as large as delays
allow. By the weights of q2q_control.mpc.chain the open loop without lag is (sqrt 2 w s + w^2) / s^2: it
crosses 1 at w (1 + sqrt 2)^(1/2) with a phase margin of 65.5 deg, which a delay of 0.736 / w uses up (delay
margin: Skogestad, Postlethwaite, Multivariable Feedback Control, 2005, section 2.4). Latency and lag are in
the model, so the margin is for their errors: with

    w = min(0.736 / T_lag, 0.5 / h)

it covers an error as large as the thrust's lag, and a stage of the horizon is half a radian at most.

| symbol | name | meaning [unit] |
|---|---|---|
| b r | disturbance - residual, residual | [m/s^2] |
| w | bandwidth_z | [rad/s] |
| T_lag | thrust_lag | [s] |
| h | step | stage of the horizon [s] |
"""

import math
from dataclasses import replace

import numpy as np

from q2q_control.mpc.mpc_params import MpcParams
from q2q_model.downwash.residual_process import ResidualProcess
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle

CROSSING = math.sqrt(1.0 + math.sqrt(2.0))
"""Crossover over bandwidth [-]."""
DELAY_MARGIN = math.atan(math.sqrt(2.0) * CROSSING) / CROSSING
"""Delay margin times bandwidth [rad]: 0.736."""
STAGE_TURN = 0.5
"""Largest bandwidth times step [rad]."""


def tightened(params: MpcParams, vehicle: Vehicle) -> MpcParams:
    """Return parameters whose altitude loop has at least the bandwidth above."""
    widest = STAGE_TURN / params.step
    most = min(DELAY_MARGIN / vehicle.thrust_lag, widest) if vehicle.thrust_lag > 0.0 else widest
    return replace(params, bandwidth_z=max(params.bandwidth_z, most))


def faded_residual(residual: Array, process: ResidualProcess, params: MpcParams) -> Array:
    """Return what a residual (n,) has lost at the middle of each stage, (n, N)."""
    ahead = params.latency + params.step * (0.5 + np.arange(params.steps))
    return np.asarray(residual[:, None] * -np.expm1(-ahead / process.time_s))
