"""The explicit law is the same in numpy, compiled and in C, and costs what its teacher costs."""

import shutil
import subprocess
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from pid_swarms import swarm

from q2q_control.explicit_mpc.c_export import c_source
from q2q_control.explicit_mpc.distillation import DistillationParams, control_policy, distil
from q2q_control.explicit_mpc.encounter_flight import fly_encounters, teacher_policy
from q2q_control.explicit_mpc.explicit_law import (
    ExplicitLaw,
    evaluate,
    evaluate_one,
    weights_of,
    workspace_of,
)
from q2q_control.explicit_mpc.explicit_solver import ExplicitSolver, explicit_solver
from q2q_control.explicit_mpc.features import STAGES, WIDTH, PairHorizon, features
from q2q_control.explicit_mpc.situations import random_encounters, random_situations
from q2q_control.explicit_mpc.teacher import Teacher, downwash_between, pair_horizon, solve_situations
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.prediction.downwash_horizon import GradientRule, predict_downwash
from q2q_control.mpc.prediction.downwash_horizon_kernel import Tracks
from q2q_control.mpc.problem.axis_model import axis_models
from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon
from q2q_control.mpc.problem.joint_problem import group_shape, joint_problem
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.axis_sweep import gains_table, sweep_gains
from q2q_control.mpc.solver.horizon_solver import horizon_solver
from q2q_control.mpc.solver.riccati import solve
from q2q_model.downwash.jet import MEASURED_LAW, PAPER_LAW
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065, Vehicle

PARAMS = MpcParams(latency=0.0, thrust_limited=True)
TEACHER = Teacher(PARAMS, TEXTBOOK_065, PAPER_LAW, 6.6)
SIDE = sweep_gains(axis_models(PARAMS, TEXTBOOK_065)[0])
SHORT = DistillationParams(situations=2000, encounters=40, length=60, layers=(16, 10), iterations=200)
"""A tenth of what is asked where the law is to fly."""


@lru_cache(maxsize=1)
def distilled() -> ExplicitLaw:
    return distil(TEACHER, SHORT, np.random.default_rng(0))


def random_law(seed: int = 0) -> ExplicitLaw:
    rng = np.random.default_rng(seed)
    return ExplicitLaw(
        gains=gains_table(sweep_gains(TEACHER.altitude_model)),
        bounds=np.array([-1.0, 0.5]),
        mean=rng.normal(size=WIDTH) * 0.1,
        scale=rng.uniform(0.5, 2.0, WIDTH),
        linear=rng.normal(size=WIDTH + 1) * 0.1,
        first=rng.normal(size=(12, WIDTH + 1)) * 0.3,
        second=rng.normal(size=(8, 13)) * 0.3,
        last=rng.normal(size=8) * 0.3,
    )


def fitting_law() -> ExplicitLaw:
    return replace(random_law(), bounds=np.array(TEACHER.bounds))


def flown_by(law: ExplicitLaw, params: MpcParams, vehicle: Vehicle = TEXTBOOK_065) -> Mpc:
    return Mpc(params, vehicle, PAPER_LAW, MpcSetup(solver=explicit_solver(law)))


def pairs(count: int, seed: int) -> PairHorizon:
    return pair_horizon(random_situations(count, PARAMS.step, np.random.default_rng(seed)), TEACHER)


def rows_of(pair: PairHorizon) -> list[PairHorizon]:
    return [PairHorizon(*(np.ascontiguousarray(part[k]) for part in pair)) for k in range(len(pair.push))]


def test_compiled_and_plain_evaluation_agree():
    law, pair = random_law(), pairs(80, 1)
    singly = [evaluate_one(weights_of(law), row, workspace_of(law)) for row in rows_of(pair)]
    assert np.allclose(singly, evaluate(law, pair), atol=1e-11)
    gate = features(pair, law.altitude_gains, 0.5).gate
    assert (
        (gate > 0.1) & (np.array(singly) > -1.0) & (np.array(singly) < 0.5)
    ).sum() > 5  # the network counts


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler: install one to check the export")
def test_the_c_export_compiles_without_warnings_and_agrees(tmp_path: Path):
    law, pair = random_law(2), pairs(40, 3)
    numbers = ", ".join(
        f"{v:.9e}f" for row in rows_of(pair) for part in row for v in np.float32(part).ravel()
    )
    size = 2 * (3 + 2 * STAGES)
    one = "q2q_explicit((const F3 *)p, (const FN *)(p + 6), (const FN *)(p + 6 + 2 * N))"
    main = (
        "#include <stdio.h>\ntypedef float F3[3];\ntypedef float FN[N];\n"
        f"int main(void) {{ static float all[] = {{{numbers}}};\n"
        f"  for (int k = 0; k < 40; ++k) {{ const float *p = all + {size} * k;\n"
        f'    printf("%.9e\\n", (double){one}); }}\n'
        f'  all[7] = NAN; const float *p = all; printf("%.9e\\n", (double){one});\n'
        "  return 0; }\n"
    )
    source, program = tmp_path / "law.c", tmp_path / "law"
    source.write_text(c_source(law) + main, encoding="utf-8")
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-Wno-missing-braces", "-Wno-cast-qual"]
    subprocess.run(["cc", *flags, str(source), "-o", str(program), "-lm"], check=True)
    printed = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
    *values, of_nan = np.array(printed.split(), dtype=float)
    # single precision through recursions of 80 steps with numbers of order 1
    assert np.allclose(values, evaluate(law, pair), atol=1e-4)
    assert of_nan == np.float32(law.bounds[0])


def test_the_teacher_of_many_answers_as_the_solver_of_one():
    asked = random_situations(20, PARAMS.step, np.random.default_rng(6))
    model, stages = TEACHER.altitude_model, PARAMS.steps
    shape = group_shape(2, (2,), (model, model, model))
    shape = shape._replace(terminal=PARAMS.terminal_weight * shape.terminal)
    lines = solve_situations(asked, TEACHER)
    times, axis = np.arange(stages + 1) * PARAMS.step, np.tile([0.0, 0.0, 1.0], (2, stages, 1))
    bound = np.tile([0.0, 0.0, TEACHER.bounds[1]], (2, stages, 1))
    for k in range(20):
        reference, path, start = np.zeros((2, stages + 1, 9)), asked.paths[k].copy(), np.zeros((2, 3, 3))
        reference[..., :3] = path
        start[:, 2] = asked.states[k] + np.stack([path[:, 0, 2], [0.0, 0.0], [0.0, 0.0]], axis=1)
        start[:, 2, 1] += (path[:, 1, 2] - path[:, 0, 2]) / PARAMS.step
        reference[..., 5] = start[:, 2, 1, None] - asked.states[k, :, 1, None]
        for _ in range(2):
            tracks = Tracks(
                times, np.ascontiguousarray(path.transpose(1, 0, 2)), axis, np.ones((2, stages)), 0
            )
            downwash = predict_downwash(PAPER_LAW, tracks, GradientRule((2,), PARAMS.slope_max))
            push = downwash.eta.copy()
            push[..., 2] += asked.extra[k]
            low, rate = np.full((2, 3), TEACHER.bounds[0]), np.full(3, np.inf)
            horizon = Horizon(start, reference, push, path, np.minimum(low, bound[:, 0]), bound, rate)
            found = solve(joint_problem(shape, np.array([0, 1]), horizon, downwash), None, 60)
            path[..., 2] = found.states[:, 0::3].T
        # faint downwash is none there; they are below 1e-4 m/s^2
        assert np.allclose(found.inputs[0], lines.inputs[k], atol=5e-4)


def test_downwashs_come_from_where_their_source_was():
    teacher = Teacher(PARAMS, CRAZYFLIE_2_0, MEASURED_LAW, 0.6)
    drawn = random_situations(1, PARAMS.step, np.random.default_rng(0))
    t = np.arange(STAGES + 1) * PARAMS.step
    paths = np.zeros_like(drawn.paths)
    paths[0, 1, :, 2] = 0.75  # source above
    still, moving = paths.copy(), paths.copy()
    still[0, 0, :, 1] = 0.5 * t - 0.5  # the lower one flies under a hovering one
    moving[0, 1, :, 1] = -0.5 * t + 0.5  # the upper one flies over a hovering one
    (eta_still, _), (eta_moving, _) = (
        downwash_between(path, np.zeros(1), teacher) for path in (still, moving)
    )
    # at the middle of stage 19, 0.975 s, the two are 12.5 mm apart; the air takes 0.1 s = 50 mm of flight
    width = MEASURED_LAW.width
    peak = MEASURED_LAW.strength * np.exp(-MEASURED_LAW.decay_rate * 0.35)
    assert eta_still[0, 0, 19] == pytest.approx(-peak * np.exp(-(0.0125**2) / (2 * width**2)), rel=1e-6)
    assert eta_moving[0, 0, 19] == pytest.approx(-peak * np.exp(-(0.0625**2) / (2 * width**2)), rel=1e-6)


def test_where_no_bound_is_met_the_law_is_the_optimum():
    calm = Teacher(PARAMS, TEXTBOOK_065, PAPER_LAW, 12.0)
    asked = random_situations(200, PARAMS.step, np.random.default_rng(7))
    law = distil(calm, replace(SHORT, situations=200), np.random.default_rng(8))
    off = evaluate(law, pair_horizon(asked, calm)) - solve_situations(asked, calm).inputs[:, 0]
    # gradients are not in the linear law: downwash changes by 1 m/s^2 a metre, errors of cm pass within 0.2 s
    assert np.percentile(np.abs(off), 95) < 0.02
    assert not law.last.any()


@pytest.mark.parametrize("climb", [0.5, -1.0])
def test_on_an_accelerating_reference_the_law_commands_what_the_horizon_commands(climb: float) -> None:
    law = random_law()
    unbent = replace(
        law, bounds=np.array([-9.0, 9.0]), linear=np.zeros_like(law.linear), last=np.zeros_like(law.last)
    )
    t, none = np.arange(STAGES + 1) * PARAMS.step, np.zeros(0, np.intp)
    reference, push = np.zeros((1, STAGES + 1, 9)), np.zeros((1, STAGES, 3))
    reference[0][:, [2, 5, 8]] = np.stack([1.0 + 0.5 * climb * t**2, climb * t, np.full(t.size, climb)], 1)
    push[0, :, 2] = 0.2 * np.cos(t[:-1])
    start = np.zeros((1, 3, 3))
    start[0, 2] = 0.95, 0.1, climb + 0.3  # below, faster, and accelerating more
    low, high = np.full((1, 3), -9.0), np.full((1, STAGES, 3), 9.0)
    horizon = Horizon(start, reference, push, reference[..., :3].copy(), low, high, np.full(3, 100.0))
    downwash = DownwashHorizon(push, none, none, np.zeros((0, STAGES, 3, 3)))
    ours, theirs = (
        solver.solve(horizon, downwash, np.zeros((1, STAGES, 3), np.int8), lambda: True)
        for solver in (ExplicitSolver(unbent, SIDE), horizon_solver(PARAMS, TEXTBOOK_065))
    )
    assert ours.inputs[0, 0, 2] == pytest.approx(theirs.inputs[0, 0, 2], abs=1e-9)


def test_a_distilled_law_answers_unseen_situations_better_than_its_linear_part():
    law = distilled()
    asked = random_situations(500, PARAMS.step, np.random.default_rng(9))
    truth = np.clip(solve_situations(asked, TEACHER).inputs[:, 0], *TEACHER.bounds)
    straight = replace(law, linear=np.zeros_like(law.linear), last=np.zeros_like(law.last))
    gate = features(pair_horizon(asked, TEACHER), law.altitude_gains, float(law.bounds[1])).gate > 0.1
    full, part = (
        np.std((evaluate(one, pair_horizon(asked, TEACHER)) - truth)[gate]) for one in (law, straight)
    )
    assert full < 0.6 * part


def test_in_unseen_encounters_the_law_costs_at_most_five_percent_more_than_the_horizon():
    shown = random_encounters(30, 100, PARAMS.step, np.random.default_rng(10))  # distilled from other seeds
    ours = fly_encounters(shown, control_policy(distilled(), TEACHER), TEACHER).cost
    theirs = fly_encounters(shown, teacher_policy(TEACHER), TEACHER).cost
    assert np.median(ours / theirs) <= 1.05
    assert ours.sum() <= 1.05 * theirs.sum()  # made up by the hard ones, where the bound matters


def test_a_vehicle_alone_hovers_and_a_broken_state_is_survived():
    flown = flown_by(fitting_law(), PARAMS)
    state, setpoint, downwash = swarm(("cf1",))
    assert flown.update(state, setpoint, downwash).thrust[0] == pytest.approx(0.65 * GRAVITY)
    broken = replace(state, t=0.01, pos=np.full((1, 3), np.nan))
    command = flown.update(broken, replace(setpoint, t=0.01), replace(downwash, t=0.01))
    assert np.isfinite(command.thrust).all()


def test_rotors_too_weak_to_hover_and_a_reference_out_of_reach_are_survived():
    low = replace(random_law(), bounds=np.array([-0.95 * GRAVITY, 6.0 / 0.65 - GRAVITY]))
    flown = flown_by(low, PARAMS, replace(TEXTBOOK_065, thrust_max=6.0))
    state, setpoint, downwash = swarm(("cf1",))
    assert flown.update(state, setpoint, downwash).thrust[0] == pytest.approx(6.0)
    far = replace(setpoint, t=0.01, pos=np.array([[0.0, 0.0, 100.0]]))
    assert flown.update(replace(state, t=0.01), far, replace(downwash, t=0.01)).thrust[0] == pytest.approx(
        6.0
    )
    deep = replace(setpoint, t=0.02, pos=np.array([[0.0, 0.0, -100.0]]))
    assert 0.0 <= flown.update(replace(state, t=0.02), deep, replace(downwash, t=0.02)).thrust[0] < 6.0


def test_a_law_of_another_vehicle_or_horizon_is_refused():
    with pytest.raises(ValueError, match="law is for another vehicle"):
        flown_by(fitting_law(), PARAMS, CRAZYFLIE_2_0)
    with pytest.raises(ValueError, match="law is for another vehicle"):
        flown_by(fitting_law(), PARAMS).configure(replace(PARAMS, bandwidth_z=4.0))
    with pytest.raises(ValueError, match="law is for another vehicle"):  # of the same thrust lag
        flown_by(fitting_law(), PARAMS, replace(TEXTBOOK_065, thrust_max=6.5))
    with pytest.raises(ValueError, match="law is for another vehicle"):
        flown_by(fitting_law(), replace(PARAMS, thrust_max=7.0))
    with pytest.raises(ValueError, match="steps = 20"):
        Teacher(replace(PARAMS, steps=20), TEXTBOOK_065, PAPER_LAW, 6.6)
