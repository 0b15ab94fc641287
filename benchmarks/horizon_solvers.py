"""Joint problem of a pair of vehicles, solved by our solver and by others; building counts where it recurs.

| solver | method |
|---|---|
| daqp | dense active set, states eliminated |
| PIQP | sparse proximal interior point, states kept |
| IPOPT | sparse interior point, states kept |
| SLSQP | dense sequential least squares, states eliminated |
"""

from collections.abc import Callable

import casadi
import daqp
import numpy as np
from scipy.optimize import minimize

from processor_time import least_time
from q2q_control.mpc.prediction.downwash_horizon import GradientRule, predict_downwash
from q2q_control.mpc.prediction.downwash_horizon_kernel import Tracks
from q2q_control.mpc.problem.axis_cost import AxisWeights
from q2q_control.mpc.problem.axis_model import axis_model
from q2q_control.mpc.problem.horizon import Horizon
from q2q_control.mpc.problem.joint_problem import group_shape, joint_problem
from q2q_control.mpc.problem.lq_problem import LqProblem, cost, dense_matrices, input_matrix
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.riccati import solve
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.signals.values import Array
from row import Row

Program = dict[str, casadi.MX]


def rows_of_solvers(params: MpcParams) -> list[Row]:
    """Return the time of our solve and those of others, and the cost that each reaches."""
    problem = pair_problem(params)
    active_set = solve(problem).active_set
    ours = least_time(lambda: solve(problem, active_set), 200)
    others: dict[str, tuple[Callable[[], Array], int]] = {
        "dense condensed QP (build + daqp)": (lambda: _by_daqp(problem), 5),
        "PIQP (CasADi)": (_by_casadi(problem, _piqp), 20),
        "IPOPT (CasADi)": (_by_casadi(problem, _ipopt), 3),
        "SciPy SLSQP": (lambda: _by_slsqp(problem), 1),
    }
    name = "solve the joint problem, two altitude axes, N = 40"
    reached = _cost_of(problem, solve(problem).inputs)
    times = {other: least_time(task, count) / ours for other, (task, count) in others.items()}
    return [Row(name, 1e3 * ours, "ms", other, ratio) for other, ratio in times.items()] + [
        Row("its cost", reached, "m^2", f"{other}'s", _cost_of(problem, task()) / reached)
        for other, (task, _) in others.items()
    ]


def pair_problem(params: MpcParams) -> LqProblem:
    """Return the joint problem of a pair two seconds before the downwash's middle."""
    stages = params.steps
    up = axis_model(0.0, params.step, AxisWeights(params.bandwidth_z, params.jerk_weight))
    times = np.linspace(0.0, params.horizon, stages + 1)
    reference = np.zeros((2, stages + 1, 9))
    reference[0, :, 2], reference[1, :, 2], reference[1, :, 1] = 1.5, 2.0, 0.1 - 0.05 * times
    axis = np.tile([0.0, 0.0, 1.0], (2, stages, 1))
    path = np.ascontiguousarray(reference[..., :3].transpose(1, 0, 2))
    downwash = predict_downwash(
        PAPER_LAW, Tracks(times, path, axis, np.ones((2, stages)), 0), GradientRule((2,), 10.0)
    )
    start = np.zeros((2, 3, 3))
    start[:, 2, 0] = [1.49, 2.0]
    most, path = 6.6 / 0.65 - 9.81, reference[..., :3].copy()
    low, high = np.full((2, 3), most - 10.0), np.full((2, stages, 3), most)
    asked = Horizon(start, reference, downwash.eta, path, low, high, np.full(3, np.inf))
    return joint_problem(group_shape(2, (2,), (up, up, up)), np.arange(2), asked, downwash)


def _cost_of(problem: LqProblem, inputs: Array) -> float:
    """Return the objective that inputs reach, in any layout whose order is stage by stage."""
    a, b = dense_matrices(problem), input_matrix(problem)
    acting = np.reshape(inputs, problem.low.shape)
    states = [problem.start]
    for k, u in enumerate(acting):
        states.append(a[k] @ states[-1] + b @ u + problem.drift[k])
    return cost(problem, np.array(states), acting)


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
