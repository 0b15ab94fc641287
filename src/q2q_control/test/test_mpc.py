"""The receding-horizon controller sees downwash coming, keeps its limits, and falls back as documented."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from q2q_control.inputs.preview import SampledPreview
from q2q_control.mpc.group_solve import Modes
from q2q_control.mpc.horizon_solver import InTime, horizon_solver
from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.prediction.downwash_horizon import SlopeRule, predict_downwash
from q2q_control.mpc.prediction.downwash_stages import DownwashHorizon, Tracks
from q2q_control.mpc.problem.horizon import Horizon, HorizonSolution
from q2q_control.mpc.receding import Mpc, MpcSetup
from q2q_model.downwash.interaction_model import InteractionModel, PairMotion, at_rest
from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW, Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    Interference,
    Names,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import GRAVITY, TEXTBOOK_065, Vehicle

DT = 0.01
"""The house's tick [s]."""
IDEAL = MpcParams(latency=0.0, thrust_limited=True)
"""For a plant without latency, lag and offset."""
PAIR = ("cf1", "cf2")


@dataclass
class Air:
    """Move vehicles along z only: thrust, downwash, and what the controller does not know."""

    preview: SampledPreview
    latency: int = 0
    """Ticks from a command to its effect."""
    gain: float = 1.0
    """Share of the thrust that rotors give."""
    wake: InteractionModel = PAPER_LAW

    def fly(
        self, mpc: Mpc, ticks: int, spoil: Callable[[int, SwarmState], SwarmState] | None = None
    ) -> tuple[Array, Array]:
        """Return the height errors [m] and thrusts [N], (ticks, n)."""
        names, samples = self.preview.names, self.preview.samples
        n = len(names)
        pos, vel = samples[:, 0, :3].copy(), samples[:, 0, 3:6].copy()
        acting = [np.full(n, TEXTBOOK_065.hover_thrust)] * self.latency
        errors, thrusts = [], []
        for k in range(ticks):
            state, setpoint, downwash = signals(k * DT, names, pos, vel, samples[:, k])
            downwash = replace(downwash, acc=self.downwash(pos))
            command = mpc.update(state if spoil is None else spoil(k, state), setpoint, downwash)
            acting.append(command.thrust)
            lift = self.gain * acting.pop(0) / TEXTBOOK_065.mass - GRAVITY
            for _ in range(2):
                acc = self.downwash(pos)[:, 2] + lift
                pos[:, 2] += 0.5 * DT * vel[:, 2] + 0.125 * DT**2 * acc
                vel[:, 2] += 0.5 * DT * acc
            pos[:, :2], vel[:, :2] = samples[:, k + 1, :2], samples[:, k + 1, 3:5]
            errors.append(pos[:, 2] - samples[:, k + 1, 2])
            thrusts.append(command.thrust)
        return np.array(errors), np.array(thrusts)

    def downwash(self, pos: Array) -> Array:
        """Return every vehicle's downwash, (n, 3)."""
        total = np.zeros_like(pos)
        for i in range(len(pos)):
            for j in range(len(pos)):
                if i != j:
                    rel = pos[j] - pos[i]
                    total[i] += self.wake.acceleration(rel, at_rest(rel))
        return total


def signals(t: float, names: Names, pos: Array, vel: Array, ref: Array):
    """Return state, setpoint and downwash of zero."""
    n = len(names)
    zero, flag, level = np.zeros((n, 3)), np.zeros(n, np.uint8), np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    state = SwarmState(t, names, pos.copy(), vel.copy(), level, zero, np.zeros(n), flag)
    setpoint = SwarmSetpoint(t, names, ref[:, :3], ref[:, 3:6], ref[:, 6:9], np.zeros(n), np.zeros(n), flag)
    return state, setpoint, Interference(t, names, zero, zero, flag)


def pass_over(speed: float = 0.25, start: float = 1.0, gap: float = 0.5) -> SampledPreview:
    """Return cf1 hovering and cf2 gliding over it from y = start [m] at a speed [m/s]."""
    t = np.arange(0.0, 12.0, DT)
    samples = np.zeros((2, t.size, 9))
    samples[0, :, 2] = 1.5
    samples[1, :, 1], samples[1, :, 2], samples[1, :, 4] = start - speed * t, 1.5 + gap, -speed
    return SampledPreview(PAIR, 0.0, DT, samples)


def first_tick(preview: SampledPreview, k: int = 0):
    """Return the signals of vehicles on their references at tick k."""
    at = preview.samples[:, k]
    return signals(k * DT, preview.names, at[:, :3], at[:, 3:6], at)


def hover(names: Names = ("cf1",)) -> SampledPreview:
    samples = np.zeros((len(names), 1200, 9))
    samples[:, :, 1] = 3.0 * np.arange(len(names))[:, None]
    samples[:, :, 2] = 1.0
    return SampledPreview(names, 0.0, DT, samples)


def controller(params: MpcParams, preview: SampledPreview, model: InteractionModel = PAPER_LAW) -> Mpc:
    return Mpc(params, TEXTBOOK_065, model, MpcSetup(preview=preview))


def rms(errors: Array) -> Array:
    return np.sqrt((errors**2).mean(axis=0))


def test_it_climbs_before_a_downwash_beyond_its_limit_comes_and_the_upper_vehicle_makes_room():
    preview = pass_over(speed=0.05, start=0.2)  # under the downwash's middle for two seconds at tick 400
    joint, thrust = Air(preview).fly(controller(IDEAL, preview), 800)
    alone, _ = Air(preview).fly(controller(replace(IDEAL, group_max=1), preview), 800)
    assert thrust.max() <= 6.6
    assert joint[:400, 0].max() > 5e-3
    assert joint[400, 1] > 0.02
    assert np.abs(alone[:, 1]).max() < 1e-3
    assert (rms(joint) ** 2).sum() < 0.4 * (rms(alone) ** 2).sum()  # what (26) minimises


def test_without_limit_nothing_of_the_downwash_is_left():
    preview = pass_over()
    errors, _ = Air(preview).fly(controller(replace(IDEAL, thrust_limited=False), preview), 800)
    # 0.39 m/s^2 at 5 rad/s would be 16 mm; what is left is the trend within a stage, some 5 % of it
    assert np.abs(errors).max() < 1e-3


def test_latency_that_is_known_is_made_up_for():
    preview = pass_over(speed=0.5, start=1.5)
    known = replace(IDEAL, latency=0.03, thrust_limited=False)
    errors = [
        rms(Air(preview, latency=3).fly(controller(params, preview), 600)[0])[0]
        for params in (known, replace(known, latency=0.0))
    ]
    assert errors[0] < 0.5 * errors[1]


def test_a_weak_battery_leaves_no_offset():
    preview = hover()
    errors, _ = Air(preview, gain=0.97).fly(controller(IDEAL, preview), 600)
    # 0.3 m/s^2 unexplained fall as the slowest pole, some 2 rad/s: e^-12 of the dip
    assert np.abs(errors[-50:]).max() < 1e-4
    blind, _ = Air(preview, gain=0.97).fly(controller(replace(IDEAL, observe=False), preview), 600)
    assert np.abs(blind[-50:]).min() > 0.005  # 0.3 / 25 = 12 mm


@pytest.mark.parametrize(("mode", "moves"), [("vertical", False), ("full", True)])
def test_a_full_problem_may_step_aside_and_a_vertical_one_does_not(mode: str, moves: bool):
    preview = pass_over(speed=0.05, start=0.2)
    aside: list[float] = []

    class Recorded:
        def __init__(self, params: MpcParams, vehicle: Vehicle) -> None:
            self._solver = horizon_solver(params, vehicle)

        def solve(
            self, horizon: Horizon, downwash: DownwashHorizon, guess: Modes, in_time: InTime
        ) -> HorizonSolution:
            solution = self._solver.solve(horizon, downwash, guess, in_time)
            aside.append(float(np.abs(solution.pos[..., :2] - horizon.reference[..., :2]).max()))
            return solution

    setup = MpcSetup(preview=preview, solver=Recorded)
    Air(preview).fly(Mpc(replace(IDEAL, mode=mode), TEXTBOOK_065, PAPER_LAW, setup), 350)
    assert (aside[-1] > 1e-3) is moves


def test_the_predicted_downwashs_are_those_that_come_with_their_delay():
    model = replace(MEASURED_LAW, strength=0.3)
    glide, when = pass_over(gap=0.6), np.arange(0.0, 2.05, 0.05)
    predictor, eta = InteractionPredictor(model), []
    middles = 2.0 + 0.5 * (when[1:] + when[:-1])
    for t in np.arange(1.0, 4.0, 0.005):
        at = glide.at(PAIR, np.array([t]))[:, 0]
        state = signals(float(t), PAIR, at[:, :3], at[:, 3:6], at)[0]
        eta.append(predictor.update(state).acc)
    exact = np.stack(
        [np.interp(middles, np.arange(1.0, 4.0, 0.005), np.array(eta)[:, 0, a]) for a in range(3)]
    )
    past = np.arange(1.0, 2.0, 0.01)
    times = np.concatenate([past, 2.0 + when])
    pos = glide.at(PAIR, times)[..., :3].transpose(1, 0, 2)
    axis = np.tile([0.0, 0.0, 1.0], (2, when.size - 1, 1))
    found = predict_downwash(
        model, Tracks(times, pos, axis, np.ones((2, middles.size)), past.size), SlopeRule((2,), 10.0)
    )
    # the predictor goes by samples 5 ms apart: a peak 0.05 m wide at 0.25 m/s bends by 1e-4
    assert np.abs(found.eta[0].T - exact).max() < 1e-3 * np.abs(exact).max()
    assert np.abs(exact).max() > 0.1


def test_slopes_are_the_derivative_of_the_downwash():
    rel = np.array([0.03, 0.02, 0.5])
    pos = np.zeros((5, 2, 3))
    pos[:, 1] = rel
    tracks = Tracks(np.arange(5) * 0.05, pos, np.tile([0.0, 0.0, 1.0], (2, 4, 1)), np.ones((2, 4)), 0)
    downwash = predict_downwash(PAPER_LAW, tracks, SlopeRule((0, 1, 2), 100.0))
    row = int(np.flatnonzero(downwash.i == 0)[0])
    for axis in range(3):
        nudge = np.zeros(3)
        nudge[axis] = 1e-5
        up, down = (PAPER_LAW.acceleration(rel + s * nudge, at_rest(rel)) for s in (1.0, -1.0))
        assert np.allclose(downwash.slope[row, 0, :, axis], (up - down) / 2e-5, rtol=1e-3, atol=1e-6)


def test_vehicles_of_another_controller_are_extrapolated_at_constant_velocity():
    preview = pass_over()
    state, setpoint, downwash = first_tick(preview, 300)
    own = SampledPreview(("cf1",), 0.0, DT, preview.samples[:1])
    mpc = Mpc(IDEAL, TEXTBOOK_065, PAPER_LAW, MpcSetup(("cf1",), preview=own))
    straight = mpc.update(state, setpoint, downwash)
    assert mpc.report.pairs == 1  # what the other one feels is not this controller's
    assert straight.names == ("cf1",)
    vel = state.vel.copy()
    vel[1, 0] = 50.0  # out of reach within the first stage
    mpc.reset()
    mpc.update(replace(state, vel=vel), setpoint, downwash)
    assert mpc.report.pairs == 0


def test_hidden_vehicles_out_of_reach_change_nothing():
    both, alone = (
        controller(IDEAL, preview).update(*first_tick(replace(preview, samples=preview.samples + 0.1)))
        for preview in (hover(PAIR), hover())
    )
    assert np.allclose(alone.thrust[0], both.thrust[0], rtol=0.0, atol=1e-12)
    assert np.allclose(alone.roll[0], both.roll[0], rtol=0.0, atol=1e-12)


def test_a_solve_that_comes_too_late_is_replaced_by_the_shifted_plan_then_by_the_pid():
    preview, left = pass_over(), [10**9]

    def in_time() -> bool:
        left[0] -= 1
        return left[0] >= 0

    mpc = Mpc(IDEAL, TEXTBOOK_065, PAPER_LAW, MpcSetup(in_time=in_time, preview=preview))
    lines = []

    def spoil(k: int, state: SwarmState) -> SwarmState:
        lines.append((mpc.report.shifted, mpc.report.pid))
        left[0] = 0 if k >= 300 else 10**9
        return state

    errors, thrust = Air(preview).fly(mpc, 420, spoil)
    assert lines[300] == (0, 0)
    assert lines[305] == (2, 0)
    assert lines[340] == (0, 2)
    assert np.isfinite(thrust).all()
    assert np.abs(errors).max() < 0.05


def test_a_model_that_returns_nan_is_survived_and_said():
    class Broken(Jet):
        def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:  # noqa: ARG002
            return np.full(rel_pos.shape, np.nan)

    preview = pass_over()
    mpc = controller(IDEAL, preview, Broken())
    _, thrust = Air(preview).fly(mpc, 20)
    assert np.isfinite(thrust).all()
    assert mpc.report.solved == 2
    assert mpc.report.pairs == 0


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_state_that_is_no_number_holds_then_levels_and_the_other_flies_on(bad: float):
    preview = hover(PAIR)
    mpc = controller(IDEAL, preview)

    def spoil(k: int, state: SwarmState) -> SwarmState:
        pos = state.pos.copy()
        pos[0] = bad if k >= 20 else pos[0]
        return replace(state, pos=pos)

    errors, thrust = Air(preview).fly(mpc, 60, spoil)
    assert np.isfinite(thrust).all()
    assert np.abs(errors[:, 1]).max() < 1e-9
    state, setpoint, downwash = first_tick(preview, 60)
    lost = replace(state, status=np.array([TrackStatus.LOST, 0], np.uint8))
    assert mpc.update(lost, setpoint, downwash).status[0] == CommandStatus.LEVEL


def test_vehicles_lost_in_a_gap_count_as_on_their_references_and_are_found_there_by_the_first_solve():
    """Both are lost for 6 ticks after 0.4 s without one; the one that finds them is solved as any other."""
    preview = pass_over(speed=0.2, start=0.3, gap=1.0)
    known, unsure = controller(MpcParams(), preview), controller(MpcParams(), preview)
    for k in [*range(10), *range(50, 57)]:
        state, setpoint, downwash = first_tick(preview, k)
        lost = replace(state, status=np.full(2, TrackStatus.LOST if 50 <= k < 56 else 0, np.uint8))
        whole, some = known.update(state, setpoint, downwash), unsure.update(lost, setpoint, downwash)
        assert unsure.report.iterations == 1
    # what was commanded meanwhile, and with it the thrust, differs: hover, and the compensation
    np.testing.assert_allclose(some.thrust, whole.thrust, atol=0.02 * TEXTBOOK_065.hover_thrust)


def test_a_thrust_bound_below_hover_saturates_and_sinks_without_winding_up():
    preview = hover()
    mpc = controller(replace(IDEAL, thrust_max=6.0), preview)
    _, thrust = Air(preview).fly(mpc, 100)
    assert np.all(thrust == 6.0)
    state, setpoint, downwash = first_tick(preview, 100)
    mpc.configure(IDEAL)
    assert mpc.update(state, setpoint, downwash).thrust[0] == pytest.approx(TEXTBOOK_065.hover_thrust)


def test_a_reference_that_no_vehicle_can_follow_is_approached_within_the_limits():
    preview = hover()
    jump = replace(preview, samples=preview.samples.copy())
    jump.samples[:, 100:, 2] += 3.0
    mpc = controller(IDEAL, jump)
    errors, thrust = Air(jump).fly(mpc, 1100)
    assert thrust.max() <= 6.6
    assert thrust.min() >= 0.0
    assert abs(errors[-1, 0]) < 0.03  # 3 m at 0.34 m/s^2 take 6 s, and the end is soft
    assert errors[100:, 0].max() < 0.15  # a horizon of 2 s brakes in time


def test_a_horizon_of_zero_is_refused():
    with pytest.raises(ValueError, match=r"horizon = 0.0: allowed is 0.2 to 10.0 s"):
        MpcParams(horizon=0.0)


def test_a_repeated_stamp_gets_the_same_answer():
    preview = pass_over()
    mpc = controller(IDEAL, preview)
    at = first_tick(preview)
    assert mpc.update(*at) is mpc.update(*at)


def test_ignoring_means_no_model():
    preview = pass_over()
    mpc = controller(IDEAL, preview)
    state, setpoint, _ = first_tick(preview, 300)
    mpc.update(state, setpoint, None)
    assert mpc.report.pairs == 0


def test_a_vehicle_without_neighbours_flies_like_one_without_model():
    preview = hover()
    at = signals(0.0, ("cf1",), preview.samples[:, 0, :3] + 0.1, np.zeros((1, 3)), preview.samples[:, 0])
    with_model = controller(IDEAL, preview).update(*at)
    without = controller(IDEAL, preview, NoInteraction()).update(*at)
    assert np.array_equal(with_model.thrust, without.thrust)
