"""Corrected predictions: bandwidth and stability of the MPC's altitude loop, residual along its horizon."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state

from q2q_control.mpc.correction import (
    CROSSING,
    DELAY_MARGIN,
    faded_residual,
    thrust_reserve,
    with_correction_bandwidth,
)
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.problem.axis_cost import AxisWeights
from q2q_control.mpc.problem.axis_model import axis_model, transition
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.jet import Jet
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, TEXTBOOK_065

TICK = 0.01
"""[s]"""
TIGHT = with_correction_bandwidth(MpcParams())
BELIEVED_LAG, BELIEVED_TICKS = 0.07, 3
"""Thrust lag [s] and latency of a Crazyflie 2.0 in the room `real`."""


@dataclass(frozen=True)
class Truth:
    """Altitude of a vehicle that is not as the controller believes."""

    lag: float = BELIEVED_LAG
    """[s]"""
    ticks: int = BELIEVED_TICKS
    """Latency."""
    gain: float = 1.0
    """Thrust over that commanded."""


def feedback(params: MpcParams, terminal: float = 1.0) -> Array:
    """Return K of u = -K x, the first input of the unbounded horizon, by its Riccati recursion."""
    one = axis_model(BELIEVED_LAG, params.step, AxisWeights(params.bandwidth_z, params.jerk_weight))
    A, B, (R, S) = one.transition, one.input_gain, one.cost.input_weight
    Q, cross = np.diag(one.cost.state_weight + np.array([0.0, 0.0, S])), np.array([0.0, 0.0, -S])
    P = terminal * one.cost.terminal
    for _ in range(params.steps):
        K = (B @ P @ A + cross) / (R + S + B @ P @ B)
        P = Q + A.T @ P @ A - np.outer(K, K) * (R + S + B @ P @ B)
    return np.asarray(K)


def largest_pole(truth: Truth, params: MpcParams = TIGHT) -> float:
    """Return the largest magnitude of the closed loop's poles.

    The state: position, velocity, acceleration; the acceleration that the controller believes; the last
    commands. The controller rolls the believed state forward over the latency, then u = -K x.
    """
    longest = max(BELIEVED_TICKS, truth.ticks)
    size = 4 + longest
    believed, (A, B) = np.zeros((3, size)), transition(BELIEVED_LAG, TICK)
    believed[[0, 1, 2], [0, 1, 3]] = 1.0
    for ago in range(BELIEVED_TICKS, 0, -1):
        believed = A @ believed
        believed[:, 3 + ago] += B
    loop = np.zeros((size, size))
    real_a, real_b = transition(truth.lag, TICK)
    loop[:3, :3] = real_a
    loop[:3, 3 + truth.ticks] += truth.gain * real_b
    loop[3, 3], loop[3, 3 + BELIEVED_TICKS] = A[2, 2], B[2]
    loop[4] = -feedback(params) @ believed
    loop[5:, 4:-1] = np.eye(longest - 1)
    return float(np.abs(np.linalg.eigvals(loop)).max())


def test_a_delay_of_the_margin_brings_the_open_loop_to_minus_one() -> None:
    width = 7.0
    s = 1j * CROSSING * width
    loop = (np.sqrt(2.0) * width * s + width**2) / s**2 * np.exp(-s * DELAY_MARGIN / width)
    assert loop == pytest.approx(-1.0, abs=1e-12)


def test_the_bandwidth_is_bounded_by_delay_and_stage_and_never_lowered() -> None:
    params = MpcParams()
    assert with_correction_bandwidth(params).bandwidth_z == pytest.approx(0.736 / 0.06, rel=1e-3)
    coarse = replace(params, steps=20)  # 0.65 rad in 0.1 s
    assert with_correction_bandwidth(coarse).bandwidth_z == pytest.approx(6.5)
    assert with_correction_bandwidth(replace(params, bandwidth_z=20.0)).bandwidth_z == 20.0


@pytest.mark.parametrize(
    "truth",
    [
        *(Truth(lag=lag) for lag in (0.03, 0.05, 0.07, 0.0975, 0.14)),
        *(Truth(gain=gain) for gain in (0.5, 0.7, 1.3, 1.5)),
        *(Truth(ticks=ticks) for ticks in (1, 2, 5, 8)),
        Truth(lag=0.0975, ticks=5, gain=0.8),
    ],
)
def test_the_loop_is_stable_for_wrong_lag_latency_and_thrust(truth: Truth) -> None:
    assert largest_pole(truth) < 0.9985  # an error falls to a half within 5 s at least


def test_twice_that_error_of_the_latency_is_not_survived() -> None:
    assert largest_pole(Truth(ticks=BELIEVED_TICKS + 10)) > 1.0


@pytest.mark.parametrize("terminal", [MpcParams().terminal_weight, 1.0])
def test_the_horizon_is_so_long_that_its_first_input_is_that_of_the_infinite_one(terminal: float) -> None:
    """The terminal weight of a single axis is that of the infinite horizon; a group's is a part of it."""
    longer = replace(TIGHT, horizon=5.0 * TIGHT.horizon, steps=5 * TIGHT.steps)
    np.testing.assert_allclose(feedback(TIGHT, terminal), feedback(longer), rtol=1e-6)


def test_the_terminal_cost_falls_by_the_stage_cost_outside_saturation() -> None:
    """V(x) - V(A x + B u) is the stage cost of u = -K x, so that V is a Lyapunov function."""
    one = axis_model(BELIEVED_LAG, TIGHT.step, AxisWeights(TIGHT.bandwidth_z, TIGHT.jerk_weight))
    R, S = one.cost.input_weight
    for x in np.random.default_rng(1).standard_normal((5, 3)):
        u = -float(feedback(TIGHT) @ x)
        after = one.transition @ x + one.input_gain * u
        stage = one.cost.state_weight @ x**2 + R * u**2 + S * (u - x[2]) ** 2
        assert x @ one.cost.terminal @ x - after @ one.cost.terminal @ after == pytest.approx(stage, rel=1e-9)


def test_the_residual_fades_along_the_horizon_as_its_process() -> None:
    params, process = MpcParams(latency=0.03), ResidualProcess(time_s=0.1)
    lost = faded_residual(np.array([2.0, -1.0]), process, params)
    assert lost.shape == (2, params.steps)
    assert lost[0, 0] == pytest.approx(2.0 * (1.0 - np.exp(-0.055 / 0.1)))
    assert lost[1, -1] == pytest.approx(-1.0, abs=1e-6)


def test_a_stage_keeps_thrust_for_what_the_residual_may_become_until_its_input_is_decided() -> None:
    """The unknown part of a process known now grows by 1 - a^2 of what is left, stage by stage."""
    params, process = MpcParams(reserve=2.0), ResidualProcess(floor=0.3, slope=0.2, time_s=0.1)
    eta = np.stack([np.zeros(params.steps), np.linspace(0.0, -3.0, params.steps)])
    kept = thrust_reserve(eta, process, params)
    share, unknown = 0.0, []
    for _ in range(params.steps):
        unknown.append(np.sqrt(share))
        share += (1.0 - process.correlation(params.step) ** 2) * (1.0 - share)
    np.testing.assert_allclose(kept, 2.0 * (0.3 + 0.2 * np.abs(eta)) * unknown, rtol=1e-12)
    assert kept[:, 0].tolist() == [0.0, 0.0]  # the command given now may use all thrust


def aside_at_the_end(reserve: float, push: float) -> float:
    """Return how far from the axis a vehicle plans to be in 2 s, 1 cm beside it now [m].

    Its thrust holds 1.6 m/s^2; the model predicts `push` [m/s^2] on the axis, with a residual of 0.4.
    """
    wake = Jet(strength=push, reference_gap=0.5, width=0.06, spread=0.0, upper_ratio=0.0)
    params = MpcParams(
        latency=0.0, thrust_limited=True, thrust_max=TEXTBOOK_065.mass * (GRAVITY + 1.6), reserve=reserve
    )
    setup = MpcSetup(vehicles=("cf1",), residual_process=ResidualProcess(floor=0.4, slope=0.0))
    mpc = Mpc(params, TEXTBOOK_065, wake, setup)
    pos = np.array([[0.01, 0.0, 1.0], [0.0, 0.0, 1.5]])
    names = ("cf1", "cf2")
    for tick in range(10):  # each linearises along the last solution
        state = resting_state(TICK * tick, names, pos)
        setpoint = resting_setpoint(state.t, names, pos)
        mpc.update(state, setpoint, InteractionPredictor(wake).update(state))
    ahead = mpc.prediction
    assert ahead is not None
    return float(ahead.pos[0, -1, 0])


def test_a_push_that_thrust_holds_only_without_its_residual_is_left_ahead_with_a_reserve() -> None:
    weak, strong = 0.8, 1.4  # with one deviation kept free, thrust holds 1.2 m/s^2
    assert aside_at_the_end(1.0, weak) == pytest.approx(aside_at_the_end(0.0, weak), abs=1e-6)
    assert aside_at_the_end(0.0, strong) < 0.015
    assert aside_at_the_end(1.0, strong) > 0.02


def test_correction_couples_all_axes_by_the_downwash_but_not_those_of_another_loop() -> None:
    assert TIGHT.axes == "coupled_xyz"
    assert with_correction_bandwidth(replace(MpcParams(), axes="altitude")).axes == "altitude"
