"""Time controllers: one MPC step, its solver against others, swarms, PID, explicit law."""

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from horizon_solvers import pair_problem, rows_of_solvers
from processor_time import least_time
from q2q_control.explicit_mpc.explicit_law import ExplicitLaw, evaluate_all, weights_of, workspace_of
from q2q_control.explicit_mpc.features import WIDTH, PairHorizon
from q2q_control.explicit_mpc.situations import random_situations
from q2q_control.explicit_mpc.teacher import Teacher, pair_horizon
from q2q_control.inputs.preview import SampledPreview
from q2q_control.mpc.mpc import Mpc, MpcSetup
from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon, HorizonSolution
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.active_set import ActiveSet
from q2q_control.mpc.solver.axis_sweep import gains_table, sweep_gains
from q2q_control.mpc.solver.horizon_solver import InTime, horizon_solver
from q2q_control.mpc.solver.riccati import solve
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.signals.values import Array, Interference, SwarmSetpoint, SwarmState
from q2q_model.vehicle.constants import TEXTBOOK_065, Vehicle
from row import Row

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
        self, horizon: Horizon, downwash: DownwashHorizon, warm_start: ActiveSet, in_time: InTime
    ) -> HorizonSolution:
        """Return the solution."""
        start = perf_counter()
        found = self._solver.solve(horizon, downwash, warm_start, in_time)
        self.taken.append(1e3 * (perf_counter() - start))
        return found


def run() -> list[Row]:
    """Return the rows of this area."""
    pair = _stacked(1)
    steps, solves = _step_and_solve(pair)
    median = float(np.median(steps))
    rows = [
        Row(
            "joint MPC step, two vehicles, median",
            median,
            "ms",
            "its solve",
            float(np.median(solves)) / median,
        ),
        Row("joint MPC step, two vehicles, p99", float(np.percentile(steps, 99)), "ms"),
    ]
    rows += rows_of_solvers(PARAMS)
    return rows + [row for pairs in (5, 25, 50) for row in _swarm(pairs)] + _small_laws(pair)


def _stacked(pairs: int) -> Flight:
    """Return pairs 3 m apart whose upper vehicles fly over the lower ones at 0.05 m/s."""
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


def _step_and_solve(flight: Flight) -> tuple[Array, Array]:
    """Return how long each tick's step took, and of it the solve [ms]."""
    solver = TimedSolver()
    steps = _milliseconds(Mpc(PARAMS, TEXTBOOK_065, PAPER_LAW, MpcSetup(solver=solver.of)), flight)
    return steps, np.array(solver.taken[-len(steps) :])


def _milliseconds(mpc: Mpc, flight: Flight) -> Array:
    """Return how long each tick took [ms], the first ones, which compile, left out."""
    mpc.follow(flight.preview)
    taken = []
    for tick in flight.ticks:
        start = perf_counter()
        mpc.update(*tick)
        taken.append(1e3 * (perf_counter() - start))
    return np.array(taken[20:])


def _swarm(pairs: int) -> list[Row]:
    steps, solves = _step_and_solve(_stacked(pairs))
    n, median, solving = 2 * pairs, float(np.median(steps)), float(np.median(solves))
    one_tick = "a tick of 100 Hz on one core"
    return [
        Row(f"MPC of {n} vehicles in pairs, for each", median / n, "ms", one_tick, 10.0 / median),
        Row(f"MPC step, {n} vehicles in pairs, median", median, "ms", one_tick, 10.0 / median),
        Row(
            f"  of it its solve, {n} vehicles",
            solving,
            "ms",
            "what surrounds it",
            solving / (median - solving),
        ),
        Row(f"MPC step, {n} vehicles in pairs, p99", float(np.percentile(steps, 99)), "ms"),
    ]


def _small_laws(flight: Flight) -> list[Row]:
    pid = Pid(PidParams(), TEXTBOOK_065)
    ticks = iter(flight.ticks)
    by_pid = least_time(lambda: pid.update(*next(ticks)), 90, repeats=3)
    problem = pair_problem(PARAMS)
    by_law, by_horizon = _explicit_law(), least_time(lambda: solve(problem), 50)
    return [
        Row("PID step, two vehicles", 1e6 * by_pid, "us"),
        Row("explicit law, one evaluation", 1e6 * by_law, "us", "the horizon's solve", by_horizon / by_law),
    ]


def _explicit_law() -> float:
    """Return how long one evaluation takes [s] where a bound lies ahead, its network's size as distilled."""
    rng = np.random.default_rng(0)
    teacher = Teacher(PARAMS, TEXTBOOK_065, PAPER_LAW, PARAMS.thrust_max)
    law = ExplicitLaw(
        gains=gains_table(sweep_gains(teacher.altitude_model)),
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
    pairs = PairHorizon(ahead.states, -3.0 * np.abs(ahead.push) - 0.5, ahead.gradient)
    weights, work = weights_of(law), workspace_of(law)
    return least_time(lambda: evaluate_all(weights, pairs, work), 20) / count
