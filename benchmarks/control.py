"""Time controllers: one MPC step, its solver beside others on the same problem, swarms, PID, explicit law."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter, process_time

import casadi
import daqp
import numpy as np
from scipy.optimize import minimize

from q2q_control.explicit.features import WIDTH, PairHorizon
from q2q_control.explicit.law import ExplicitLaw, evaluate_all, gains_table, weights_of, workspace_of
from q2q_control.explicit.situations import random_situations
from q2q_control.explicit.teacher import Teacher, pair_horizon
from q2q_control.inputs.preview import SampledPreview
from q2q_control.mpc.chain import ChainWeights, chain
from q2q_control.mpc.group_solve import Modes
from q2q_control.mpc.horizon_solver import InTime, horizon_solver
from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.prediction.downwash_horizon import SlopeRule, predict_downwash
from q2q_control.mpc.prediction.downwash_stages import DownwashHorizon, Tracks
from q2q_control.mpc.problem.horizon import Horizon, HorizonSolution
from q2q_control.mpc.problem.joint_problem import group_shape, joint_problem
from q2q_control.mpc.problem.lq_problem import LqProblem, cost, dense_matrices, input_matrix
from q2q_control.mpc.receding import Mpc, MpcSetup
from q2q_control.mpc.solver.chain_sweep import sweep_gains
from q2q_control.mpc.solver.riccati import solve
from q2q_control.pid.pid import Pid, PidParams
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.signals.values import Array, Interference, SwarmSetpoint, SwarmState
from q2q_model.vehicle.constants import TEXTBOOK_065, Vehicle
from row import Row

Program = dict[str, casadi.MX]

DT = 0.01
"""The house's tick [s]."""
STEPS = 300
"""Ticks of a measured flight: 3 s, the downwash's rise, its limit and its end."""
PARAMS = MpcParams(latency=0.0, thrust_limited=True)


@dataclass(frozen=True, slots=True)
class Flight:
    """Signals of every tick, made before the clock starts."""

    preview: SampledPreview
    ticks: list[tuple[SwarmState, SwarmSetpoint, Interference]]


class TimedSolver:
    """Solver of an Mpc that keeps how long each solve took [ms]."""

    def __init__(self) -> None:
        self.taken: list[float] = []

    def of(self, params: MpcParams, vehicle: Vehicle) -> "TimedSolver":
        """Return this one, for these parameters."""
        self._solver = horizon_solver(params, vehicle)
        return self

    def solve(
        self, horizon: Horizon, downwash: DownwashHorizon, guess: Modes, in_time: InTime
    ) -> HorizonSolution:
        """Return the solution."""
        start = perf_counter()
        found = self._solver.solve(horizon, downwash, guess, in_time)
        self.taken.append(1e3 * (perf_counter() - start))
        return found


def run() -> list[Row]:
    """Return the rows of this area."""
    pair, solver = _stacked(1), TimedSolver()
    mpc = Mpc(PARAMS, TEXTBOOK_065, PAPER_LAW, MpcSetup(solver=solver.of))
    steps = _milliseconds(mpc, pair)
    median, solving = float(np.median(steps)), float(np.median(solver.taken[-len(steps) :]))
    rows = [
        Row("joint MPC step, two vehicles, median", median, "ms", "its solve", solving / median),
        Row("joint MPC step, two vehicles, p99", float(np.percentile(steps, 99)), "ms"),
    ]
    return rows + _solvers() + [row for pairs in (5, 25, 50) for row in _swarm(pairs)] + _small_laws(pair)


def _stacked(pairs: int) -> Flight:
    """Return pairs 3 m apart whose upper vehicles glide over the lower ones at 0.05 m/s."""
    names = tuple(f"cf{k}" for k in range(2 * pairs))
    n, t = 2 * pairs, np.arange(0.0, STEPS * DT + 4.0, DT)
    samples = np.zeros((n, t.size, 9))
    samples[:, :, 0] = 3.0 * (np.arange(n) // 2)[:, None]
    samples[0::2, :, 2] = 1.5
    samples[1::2, :, 1], samples[1::2, :, 2], samples[1::2, :, 4] = 0.15 - 0.05 * t, 2.0, -0.05
    zero, flag, level = np.zeros((n, 3)), np.zeros(n, np.uint8), np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    wander = np.random.default_rng(0).normal(size=(STEPS, n, 3)) * 1e-3
    ticks = []
    for k in range(STEPS):
        at = samples[:, k]
        state = SwarmState(
            k * DT, names, at[:, :3] + wander[k], at[:, 3:6].copy(), level, zero, np.zeros(n), flag
        )
        ref = SwarmSetpoint(k * DT, names, at[:, :3], at[:, 3:6], at[:, 6:], np.zeros(n), np.zeros(n), flag)
        ticks.append((state, ref, Interference(k * DT, names, zero, zero, flag)))
    return Flight(SampledPreview(names, 0.0, DT, samples), ticks)


def _milliseconds(mpc: Mpc, flight: Flight) -> Array:
    """Return how long each tick took [ms], the first ones, which compile, left out."""
    mpc.follow(flight.preview)
    taken = []
    for tick in flight.ticks:
        start = perf_counter()
        mpc.update(*tick)
        taken.append(1e3 * (perf_counter() - start))
    return np.array(taken[20:])


def _solvers() -> list[Row]:
    """Time the structured solve beside others on the same problem, building included where it recurs."""
    problem = _problem()
    pattern = solve(problem).pattern
    ours = _best(lambda: solve(problem, pattern), 200)
    others: dict[str, tuple[Callable[[], Array], int]] = {
        "dense condensed QP (build + daqp)": (lambda: _by_daqp(problem), 5),
        "PIQP (CasADi)": (_by_casadi(problem, _piqp), 20),
        "IPOPT (CasADi)": (_by_casadi(problem, _ipopt), 3),
        "SciPy SLSQP": (lambda: _by_slsqp(problem), 1),
    }
    name = "solve the joint problem, two altitude axes, N = 40"
    reached = _cost_of(problem, solve(problem).inputs)
    times = {other: _best(task, count) / ours for other, (task, count) in others.items()}
    return [Row(name, 1e3 * ours, "ms", other, ratio) for other, ratio in times.items()] + [
        Row("its cost", reached, "m^2", f"{other}'s", _cost_of(problem, task()) / reached)
        for other, (task, _) in others.items()
    ]


def _cost_of(problem: LqProblem, inputs: Array) -> float:
    """Return the objective that inputs reach, in any layout whose order is stage by stage."""
    a, b = dense_matrices(problem), input_matrix(problem)
    acting = np.reshape(inputs, problem.low.shape)
    states = [problem.start]
    for k, u in enumerate(acting):
        states.append(a[k] @ states[-1] + b @ u + problem.drift[k])
    return cost(problem, np.array(states), acting)


def _problem() -> LqProblem:
    """Return the joint problem of a pair two seconds before the downwash's middle."""
    stages = PARAMS.steps
    up = chain(0.0, PARAMS.step, ChainWeights(PARAMS.bandwidth_z, PARAMS.jerk))
    times = np.linspace(0.0, PARAMS.horizon, stages + 1)
    reference = np.zeros((2, stages + 1, 9))
    reference[0, :, 2], reference[1, :, 2], reference[1, :, 1] = 1.5, 2.0, 0.1 - 0.05 * times
    axis = np.tile([0.0, 0.0, 1.0], (2, stages, 1))
    path = np.ascontiguousarray(reference[..., :3].transpose(1, 0, 2))
    downwash = predict_downwash(
        PAPER_LAW, Tracks(times, path, axis, np.ones((2, stages)), 0), SlopeRule((2,), 10.0)
    )
    start = np.zeros((2, 3, 3))
    start[:, 2, 0] = [1.49, 2.0]
    most, path = 6.6 / 0.65 - 9.81, reference[..., :3].copy()
    low, high = np.full((2, 3), most - 10.0), np.full((2, stages, 3), most)
    asked = Horizon(start, reference, downwash.eta, path, low, high, np.full(3, np.inf))
    return joint_problem(group_shape(2, (2,), (up, up, up)), np.arange(2), asked, downwash)


def _condensed(problem: LqProblem) -> tuple[Array, Array]:
    """Return H, g of 1/2 u'Hu + g'u over all inputs: the naive way, states eliminated."""
    a, b = dense_matrices(problem), input_matrix(problem)
    stages, n = problem.low.shape
    effect, free = np.zeros((3 * n, stages * n)), problem.start.copy()
    weight, (effort, jerk) = problem.state_weight.ravel(), problem.input_weight.T
    hessian, slope = np.zeros((stages * n, stages * n)), np.zeros(stages * n)
    for k in range(stages):
        own = np.zeros((n, stages * n))
        own[:, k * n : (k + 1) * n] = np.eye(n)
        lead = own - effect[2::3]
        hessian += effect.T @ (weight[:, None] * effect) + own.T @ (effort[:, None] * own)
        hessian += lead.T @ (jerk[:, None] * lead)
        slope += effect.T @ (weight * (free - problem.target[k])) - own.T @ (effort * problem.input_target[k])
        slope -= lead.T @ (jerk * free[2::3])
        effect, free = a[k] @ effect + b @ own, a[k] @ free + problem.drift[k]
    for c in range(n):
        part = slice(3 * c, 3 * c + 3)
        hessian += effect[part].T @ problem.terminal[c] @ effect[part]
        slope += effect[part].T @ problem.terminal[c] @ (free - problem.target[-1])[part]
    return 2.0 * hessian, 2.0 * slope


def _by_daqp(problem: LqProblem) -> Array:
    hessian, slope = _condensed(problem)
    empty = np.zeros((0, slope.size))
    sense = np.zeros(slope.size, np.int32)
    low, high = problem.low.ravel().copy(), problem.high.ravel().copy()
    return np.asarray(daqp.solve(hessian, slope, empty, high, low, sense)[0])


def _by_slsqp(problem: LqProblem) -> Array:
    hessian, slope = _condensed(problem)
    bounds = list(zip(problem.low.ravel(), problem.high.ravel(), strict=True))
    found = minimize(
        lambda u: 0.5 * u @ hessian @ u + slope @ u,
        np.zeros(slope.size),
        jac=lambda u: hessian @ u + slope,
        bounds=bounds,
        method="SLSQP",
        options={"ftol": 1e-10, "maxiter": 300},
    )
    return np.asarray(found.x)


def _by_casadi(problem: LqProblem, made: Callable[[Program], casadi.Function]) -> Callable[[], Array]:
    """Return a solver of the sparse problem, states kept, in the order x_0 u_0 x_1 u_1 ..., built once."""
    a, b = dense_matrices(problem), input_matrix(problem)
    stages, n = problem.low.shape
    x = [casadi.MX.sym("x", 3 * n) for _ in range(stages + 1)]
    u = [casadi.MX.sym("u", n) for _ in range(stages)]
    goal, gaps = casadi.MX(0.0), []
    for k in range(stages):
        off, lead = x[k] - problem.target[k], u[k] - x[k][2::3]
        goal += casadi.dot(problem.state_weight.ravel(), off**2)
        goal += casadi.dot(problem.input_weight[:, 0], (u[k] - problem.input_target[k]) ** 2)
        goal += casadi.dot(problem.input_weight[:, 1], lead**2)
        gaps.append(a[k] @ x[k] + b @ u[k] + problem.drift[k] - x[k + 1])
    for c in range(n):
        off = x[stages][3 * c : 3 * c + 3] - problem.target[-1][3 * c : 3 * c + 3]
        goal += casadi.bilin(problem.terminal[c], off, off)
    pairs = [casadi.vertcat(*pair) for pair in zip(x, u, strict=False)]
    solver = made({"x": casadi.vertcat(*pairs, x[stages]), "f": goal, "g": casadi.vertcat(*gaps)})
    free = np.full((stages, 3 * n), np.inf)
    free[0] = problem.start
    high = np.concatenate([np.hstack([free, problem.high]).ravel(), free[1]])
    free[1:] = -np.inf
    low = np.concatenate([np.hstack([free, problem.low]).ravel(), free[1]])

    def answer() -> Array:
        found = np.array(solver(lbx=low, ubx=high, lbg=0.0, ubg=0.0)["x"]).ravel()
        return found[: stages * 4 * n].reshape(stages, 4 * n)[:, 3 * n :]

    return answer


def _ipopt(program: Program) -> casadi.Function:
    quiet = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False}
    return casadi.nlpsol("step", "ipopt", program, quiet)


def _piqp(program: Program) -> casadi.Function:
    return casadi.qpsol("step", "piqp", program, {"print_time": False})


def _swarm(pairs: int) -> list[Row]:
    flight = _stacked(pairs)
    steps = _milliseconds(Mpc(PARAMS, TEXTBOOK_065, PAPER_LAW), flight)
    n, median = 2 * pairs, float(np.median(steps))
    one_tick = "a tick of 100 Hz on one core"
    return [
        Row(f"MPC of {n} vehicles in pairs, for each", median / n, "ms", one_tick, 10.0 / median),
        Row(f"MPC step, {n} vehicles in pairs, median", median, "ms", one_tick, 10.0 / median),
        Row(f"MPC step, {n} vehicles in pairs, p99", float(np.percentile(steps, 99)), "ms"),
    ]


def _small_laws(flight: Flight) -> list[Row]:
    pid = Pid(PidParams(), TEXTBOOK_065)
    ticks = iter(flight.ticks)
    by_pid = _best(lambda: pid.update(*next(ticks)), 90, repeats=3)
    problem = _problem()
    by_law, by_horizon = _explicit_law(), _best(lambda: solve(problem), 50)
    return [
        Row("PID step, two vehicles", 1e6 * by_pid, "us"),
        Row("explicit law, one evaluation", 1e6 * by_law, "us", "the horizon's solve", by_horizon / by_law),
    ]


def _explicit_law() -> float:
    """Return how long one evaluation takes [s] where a bound lies ahead, its network's size as distilled."""
    rng = np.random.default_rng(0)
    teacher = Teacher(PARAMS, TEXTBOOK_065, PAPER_LAW, PARAMS.thrust_max)
    law = ExplicitLaw(
        gains=gains_table(sweep_gains(teacher.chain)),
        bounds=np.array(teacher.bounds),
        mean=np.zeros(WIDTH),
        scale=np.ones(WIDTH),
        linear=rng.normal(size=WIDTH + 1),
        first=rng.normal(size=(24, WIDTH + 1)),
        second=rng.normal(size=(16, 25)),
        last=rng.normal(size=16),
    )
    count = 200
    ahead = pair_horizon(random_situations(count, PARAMS.step, rng), teacher)
    # three times the push: a bound is met, the network is evaluated
    pairs = PairHorizon(ahead.states, -3.0 * np.abs(ahead.push) - 0.5, ahead.slope)
    weights, work = weights_of(law), workspace_of(law)
    return _best(lambda: evaluate_all(weights, pairs, work), 20) / count


def _best(task: Callable[[], object], count: int, repeats: int = 5) -> float:
    """Return the least CPU time of one call [s] over repeats of `count` calls."""
    task()
    least = np.inf
    for _ in range(repeats):
        start = process_time()
        for _ in range(count):
            task()
        least = min(least, (process_time() - start) / count)
    return float(least)
