"""MPC with corrected predictions: residual along the horizon, altitude bandwidth, room to give way.

The residual fades along the horizon as its process does, d(s) = b + r exp(-s / T). What fades before thrust
follows cannot be cancelled, but feedback removes its effect on height, with a bandwidth as large as delays
allow. By the weights of q2q_control.mpc.problem.axis_cost the open loop without lag is (sqrt 2 w s + w^2) /
s^2: it crosses 1 at w (1 + sqrt 2)^(1/2) with a phase margin of 65.5 deg, which a delay of 0.736 / w uses up
(delay margin: Skogestad, Postlethwaite, Multivariable Feedback Control, 2005, section 2.4). Latency and lag
are in the model, so the margin is for their errors. With

    w = min(0.736 / 0.06 s, 0.65 / h)

poles stay within the unit circle for 50 ms of latency that nobody stated, for a thrust lag of 0.03 to 0.14 s
believed to be 0.07 s, and for half to one and a half times the believed thrust (test_correction); a stage of
the horizon is at most 0.65 rad.

A push beyond what thrust can carry cannot be held against, but left: a vehicle some centimetres off the axis
of a jet carries what arrives there. So downwash couples all axes: `axes` coupled_xyz, whose problem contains
this, replaces coupled_z.

The problem would plan with all thrust, and a prediction that is a little too small would find none left where
it counts. So thrust is kept free at each stage for what the residual may become until the input of that stage
is decided (constraint tightening: Mesbah, IEEE Control Syst. Mag. 36, 2016): the deviation of the residual's
process, given its present value,

    u_k <= u_max - c sigma(eta_k) (1 - exp(-2 k h / T))^(1/2)

The first input is decided now and may use all thrust, so that what was kept is there when it is needed.
With c > 0 a vehicle climbs, or steps aside, before a push that it could just carry.

| symbol | name | meaning [unit] |
|---|---|---|
| b r | disturbance - residual, residual | [m/s^2] |
| sigma T | process.std, process.time_s | of the residual [m/s^2], [s] |
| c | reserve | [-] |
| w | bandwidth_z | [rad/s] |
| h | step | stage of the horizon [s] |
"""

import math
from dataclasses import replace

import numpy as np

from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.signals.values import Array

CROSSING = math.sqrt(1.0 + math.sqrt(2.0))
"""Crossover over bandwidth [-]."""
DELAY_MARGIN = math.atan(math.sqrt(2.0) * CROSSING) / CROSSING
"""Delay margin times bandwidth [rad]: 0.736."""
DELAY_ERROR = 0.06
"""Delay margin of the loop without lag and sampling [s]: with both, 0.05 s."""
STAGE_TURN = 0.65
"""Largest bandwidth times step [rad]."""


def with_correction_bandwidth(params: MpcParams) -> MpcParams:
    """Return parameters with at least the bandwidth above, and with all axes coupled in place of z alone."""
    most = min(DELAY_MARGIN / DELAY_ERROR, STAGE_TURN / params.step)
    axes = "coupled_xyz" if params.axes == "coupled_z" else params.axes
    return replace(params, bandwidth_z=max(params.bandwidth_z, most), axes=axes)


def faded_residual(residual: Array, process: ResidualProcess, params: MpcParams) -> Array:
    """Return what a residual (n,) has lost at the middle of each stage, (n, N)."""
    ahead = params.latency + params.step * (0.5 + np.arange(params.steps))
    return np.asarray(residual[:, None] * -np.expm1(-ahead / process.time_s))


def thrust_reserve(eta: Array, process: ResidualProcess, params: MpcParams) -> Array:
    """Return the thrust over mass that each stage keeps for the residual [m/s^2], (n, N).

    `eta` is the predicted vertical downwash of each stage [m/s^2], (n, N).
    """
    since = params.step * np.arange(params.steps)
    unknown = np.sqrt(-np.expm1(-2.0 * since / process.time_s))
    return np.asarray(params.reserve * process.std(eta) * unknown)
