"""The receding-horizon controller sees downwash coming, keeps its limits, and falls back as documented."""

from dataclasses import replace

import numpy as np
import pytest
from mpc_bench import DT, IDEAL, PAIR, Air, controller, first_tick, hover, pass_over, rms, signals

from q2q_control.inputs.preview import SampledPreview
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.prediction.downwash_horizon import GradientRule, predict_downwash
from q2q_control.mpc.prediction.downwash_horizon_kernel import Tracks
from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon, HorizonSolution
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.active_set import ActiveSet
from q2q_control.mpc.solver.horizon_solver import InTime, horizon_solver
from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.vehicle.constants import TEXTBOOK_065, Vehicle


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


def test_a_bound_that_does_not_carry_the_vehicle_is_refused():
    low = replace(IDEAL, thrust_max=6.37)
    with pytest.raises(ValueError, match=r"thrust_max = 6.37 N .* above .* of textbook_065, 6.3765 N"):
        Mpc(low, TEXTBOOK_065, PAPER_LAW)
    Mpc(replace(low, thrust_limited=False), TEXTBOOK_065, PAPER_LAW)


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


@pytest.mark.parametrize(("axes", "moves"), [("coupled_z", False), ("coupled_xyz", True)])
def test_with_all_axes_coupled_vehicles_may_step_aside_and_with_z_alone_they_do_not(axes: str, moves: bool):
    preview = pass_over(speed=0.05, start=0.2)
    aside: list[float] = []

    class Recorded:
        def __init__(self, params: MpcParams, vehicle: Vehicle) -> None:
            self._solver = horizon_solver(params, vehicle)

        def solve(
            self, horizon: Horizon, downwash: DownwashHorizon, warm_start: ActiveSet, in_time: InTime
        ) -> HorizonSolution:
            solution = self._solver.solve(horizon, downwash, warm_start, in_time)
            aside.append(float(np.abs(solution.pos[..., :2] - horizon.reference[..., :2]).max()))
            return solution

    setup = MpcSetup(preview=preview, solver=Recorded)
    Air(preview).fly(Mpc(replace(IDEAL, axes=axes), TEXTBOOK_065, PAPER_LAW, setup), 350)
    assert (aside[-1] > 1e-3) is moves


def test_the_predicted_downwashs_are_those_that_come_with_their_delay():
    model = replace(MEASURED_LAW, strength=0.3)
    passage, when = pass_over(gap=0.6), np.arange(0.0, 2.05, 0.05)
    predictor, eta = InteractionPredictor(model), []
    middles = 2.0 + 0.5 * (when[1:] + when[:-1])
    for t in np.arange(1.0, 4.0, 0.005):
        at = passage.at(PAIR, np.array([t]))[:, 0]
        state = signals(float(t), PAIR, at[:, :3], at[:, 3:6], at)[0]
        eta.append(predictor.update(state).acc)
    exact = np.stack(
        [np.interp(middles, np.arange(1.0, 4.0, 0.005), np.array(eta)[:, 0, a]) for a in range(3)]
    )
    past = np.arange(1.0, 2.0, 0.01)
    times = np.concatenate([past, 2.0 + when])
    pos = passage.at(PAIR, times)[..., :3].transpose(1, 0, 2)
    axis = np.tile([0.0, 0.0, 1.0], (2, when.size - 1, 1))
    found = predict_downwash(
        model, Tracks(times, pos, axis, np.ones((2, middles.size)), past.size), GradientRule((2,), 10.0)
    )
    # the predictor goes by samples 5 ms apart: a peak 0.05 m wide at 0.25 m/s bends by 1e-4
    assert np.abs(found.eta[0].T - exact).max() < 1e-3 * np.abs(exact).max()
    assert np.abs(exact).max() > 0.1


def test_gradients_are_the_derivative_of_the_downwash():
    rel = np.array([0.03, 0.02, 0.5])
    pos = np.zeros((5, 2, 3))
    pos[:, 1] = rel
    tracks = Tracks(np.arange(5) * 0.05, pos, np.tile([0.0, 0.0, 1.0], (2, 4, 1)), np.ones((2, 4)), 0)
    downwash = predict_downwash(PAPER_LAW, tracks, GradientRule((0, 1, 2), 100.0))
    row = int(np.flatnonzero(downwash.i == 0)[0])
    for axis in range(3):
        nudge = np.zeros(3)
        nudge[axis] = 1e-5
        up, down = (PAPER_LAW.acceleration(rel + s * nudge, pairs_at_rest(rel)) for s in (1.0, -1.0))
        assert np.allclose(downwash.gradient[row, 0, :, axis], (up - down) / 2e-5, rtol=1e-3, atol=1e-6)


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
