"""Time planning: section 4.1 against networks, minimum snap against a QP, swarms that cross a room.

Everything is timed in processor time of this process, references in the same run. A room of N vehicles has
free air in proportion to N: they start on a jittered grid, 0.8 m apart, and each flies straight to another's
place, so that all cross each other's way in its middle. Zones are the paper's I(0.1, 1.1).
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from time import process_time
from types import FrameType

import numpy as np
import osqp
from scipy import sparse

from neural_trajectory import NeuralPlan, plan_neural
from processor_time import least_time
from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.joint_plan import AvoidancePlan, avoid_zones
from q2q_planner.offline.avoidance.waypoint_checks import InfeasibleError
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap, minimum_snap_plan, snap_cost
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, waypoints_through
from q2q_planner.online.potential_field import PotentialField
from q2q_planner.online.replanner import Replanner
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_sim.scenarios import library
from row import Row

ZONE = Cylinder()
SECTION_4_1 = library.load("section4_1").waypoints
NEURAL_TIME = 60.0
"""Processor time that the paper's way is given [s]."""
ROOMS = (10, 50, 100, 200)
WANTED = {200: 20.0}
"""Processor time in which a room's joint plan is wanted [s]."""
LONGEST = 60.0
"""Processor time after which a joint plan is given up [s]."""
TICKS = {10: 400, 100: 400, 500: 100}
"""Vehicles, and how many ticks are timed in the middle of the crossing."""
GRID, JITTER = 0.8, 0.1
"""Places of a room are this far apart, and off by up to this [m]."""
SPEED = 0.5
"""Mean speed across a room [m/s]: a peak of 1.1."""
TICK_ZONE = SafeReplannerParams(eps=0.15, tracking=0.02)


def run() -> list[Row]:
    """Return the rows of this area."""
    rows = _section_4_1(NEURAL_TIME) + _minimum_snap()
    rows += [row for count in TICKS for row in _tick(count)]
    return rows + [row for count in ROOMS for row in _joint(count)]


def _section_4_1(longest: float) -> list[Row]:
    """Return our plan and that of networks and SLSQP, both around the paper's zone."""
    ours = least_time(lambda: avoid_zones(SECTION_4_1, ZONE), 1, repeats=3)
    found = avoid_zones(SECTION_4_1, ZONE)
    neural = plan_neural(SECTION_4_1, ZONE, longest)
    speed = "the paper's networks by SLSQP, " + ("converged" if neural.converged else "not converged")
    return [
        Row("section 4.1, planned and certified", 1e3 * ours, "ms", speed, neural.cpu / ours),
        Row("  snap cost over the infimum", found.cost / found.infimum, ""),
        Row("  clearance, proven for every t", 1e3 * found.certificate.clearance, "mm"),
        *_neural_rows(neural, found.infimum),
    ]


def _neural_rows(neural: NeuralPlan, infimum: float) -> list[Row]:
    return [
        Row("networks: processor time taken", neural.cpu, "s"),
        Row("networks: converged (1) or not (0)", float(neural.converged), ""),
        Row("networks: iterations", neural.iterations, ""),
        Row("networks: snap cost over the infimum", neural.cost / infimum, ""),
        Row("networks: waypoints missed by up to", 1e3 * neural.waypoint_error, "mm"),
        Row("networks: inside the zone on their grid, share", neural.zone_error, ""),
    ]


def _minimum_snap() -> list[Row]:
    """Return minimum snap through many waypoints and a QP over the polynomials' coefficients."""
    generator, rows = np.random.default_rng(0), []
    for count in (3, 10, 100):
        points = generator.uniform([-1.0, -1.0, 0.5], [1.0, 1.0, 2.5], (count, 3))
        times = np.concatenate([[0.0], np.cumsum(generator.uniform(1.0, 3.0, count - 1))])
        vehicle = waypoints_through("cf1", times, points)
        ours = least_time(lambda vehicle=vehicle: minimum_snap(vehicle, "free"), 1)
        problem = coefficient_problem(times, points)
        theirs, cost = least_time(partial(cost_by_osqp, problem), 1), cost_by_osqp(problem)
        name = f"minimum snap, {count} waypoints, free derivatives"
        rows.append(Row(name, 1e3 * ours, "ms", "OSQP over coefficients, set up and solved", theirs / ours))
        ratio = cost / snap_cost(minimum_snap(vehicle, "free"))
        rows.append(Row("  cost of OSQP's solution over ours", ratio, ""))
    return rows


@dataclass(frozen=True, slots=True, eq=False)
class CoefficientProblem:
    """QP of minimum snap over coefficients x: min x'Wx / 2 with Ex = b, for each axis its b."""

    weight: sparse.csc_matrix
    """W, (8 pieces, 8 pieces)"""
    equal: sparse.csc_matrix
    """E, (m, 8 pieces)"""
    ends: Array
    """b of each axis, (m, 3)"""


def coefficient_problem(times: Array, points: Array) -> CoefficientProblem:
    """Return the QP in monomials of unit time (Mellinger and Kumar, 2011)."""
    spans = np.diff(times)
    order, pieces = 8, len(spans)
    k = np.arange(order)
    fall = np.array([_falling(k, p) for p in range(4)])  # derivatives 0..3 at u = 0 and 1
    snap = _falling(k, 4)
    power = k[:, None] + k - 7
    gram = np.where(power > 0, np.outer(snap, snap) / np.maximum(power, 1), 0.0)
    weight = sparse.block_diag([2.0 * gram / span**7 for span in spans], format="csc")
    rows, ends = [], np.zeros((0, 3))
    for piece, span in enumerate(spans):
        for at, share in ((piece, 0.0), (piece + 1, 1.0)):
            row = np.zeros(order * pieces)
            row[order * piece : order * (piece + 1)] = share**k
            rows.append(row)
            ends = np.vstack([ends, points[at]])
        for p in range(1, 4 if piece in (0, pieces - 1) else 1):
            row = np.zeros(order * pieces)
            row[order * piece + k] = fall[p] * (0.0 ** np.maximum(k - p, 0) if piece == 0 else 1.0)
            rows.append(row)
            ends = np.vstack([ends, np.zeros(3)])
        for p in range(1, 7 if piece < pieces - 1 else 1):
            row = np.zeros(order * pieces)
            row[order * piece + k] = _falling(k, p) / span**p
            row[order * (piece + 1) + p] = -_falling(k, p)[p] / spans[piece + 1] ** p
            rows.append(row)
            ends = np.vstack([ends, np.zeros(3)])
    return CoefficientProblem(weight, sparse.csc_matrix(np.array(rows)), ends)


def cost_by_osqp(problem: CoefficientProblem) -> float:
    """Return the least cost of all axes together: they differ in their bounds only, so one set-up serves."""
    solver, cost = osqp.OSQP(), 0.0
    solver.setup(
        problem.weight, np.zeros(problem.weight.shape[0]), problem.equal, problem.ends[:, 0],
        problem.ends[:, 0], verbose=False, eps_abs=1e-7, eps_rel=1e-7, max_iter=20_000, polishing=True,
    )  # fmt: skip
    for bound in problem.ends.T:
        solver.update(l=bound, u=bound)
        x = solver.solve(raise_error=True).x
        cost += 0.5 * float(x @ (problem.weight @ x))
    return cost


def _falling(k: Array, p: int) -> Array:
    """Return k (k-1) ... (k-p+1), (order,): the factors of the p-th derivative."""
    return np.asarray(np.prod([k - i for i in range(p)], axis=0) * np.ones(len(k)))


def _tick(count: int) -> list[Row]:
    """Return one tick of both laws while a room is crossed."""
    plan = minimum_snap_plan(_room(count))
    middle = 0.5 * plan.duration - 0.005 * TICKS[count]
    ticks = [setpoint_at(plan, middle + 0.01 * k) for k in range(TICKS[count])]
    laws: dict[str, Replanner] = {"safe": SafeReplanner(TICK_ZONE), "paper": PotentialField()}
    rows = []
    for law, replanner in laws.items():
        taken = []
        for tick in ticks:
            start = process_time()
            replanner.update(tick, None)
            taken.append(1e3 * (process_time() - start))
        late = np.array(taken[len(taken) // 10 :])  # the first ones compile
        name, beside = f"replanner tick, {law} law, {count} vehicles", "a tick of 100 Hz"
        rows.append(
            Row(f"{name}, median", float(np.median(late)), "ms", beside, 10.0 / float(np.median(late)))
        )
        rows.append(Row(f"{name}, p99", float(np.percentile(late, 99)), "ms"))
    return rows


def _joint(count: int) -> list[Row]:
    """Return how long it takes to plan a room's crossing, certified, or until that is given up."""
    swarm = _room(count)
    begun = process_time()
    try:
        with _given_up_after(LONGEST):
            found: AvoidancePlan | None = avoid_zones(swarm, ZONE, params=AvoidanceParams(initial_guesses=1))
    except (InfeasibleError, TimeoutError):
        found = None
    taken = process_time() - begun
    name = f"joint plan of {count} vehicles across a room"
    wanted = WANTED.get(count)
    within = (f"within {wanted:g} s", wanted / taken) if wanted else (None, None)
    if found is None:
        return [Row(f"{name}, NOT found", taken, "s", *within)]
    return [
        Row(f"{name}, certified", taken, "s", *within),
        Row("  snap cost over the infimum", found.cost / found.infimum, ""),
        Row("  clearance, proven for every t", 1e3 * found.certificate.clearance, "mm"),
    ]


@contextmanager
def _given_up_after(seconds: float) -> Iterator[None]:
    """Raise TimeoutError in the block after some processor time [s]."""

    def give_up(_: int, __: FrameType | None) -> None:
        raise TimeoutError

    signal.signal(signal.SIGPROF, give_up)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def _room(count: int) -> tuple[VehicleWaypoints, ...]:
    """Return vehicles that fly to each other's places, all at the same time."""
    generator = np.random.default_rng(count)
    side = int(np.ceil(np.sqrt(count)))
    grid = np.stack(np.divmod(generator.permutation(side * side)[:count], side), axis=-1) * GRID
    places = np.column_stack([grid, np.full(count, 1.2)]) + generator.uniform(-JITTER, JITTER, (count, 3))
    goals = places[generator.permutation(count)]
    end = max(6.0, GRID * side / SPEED)
    pairs = enumerate(zip(places, goals, strict=True))
    return tuple(waypoints_through(f"cf{row}", (0.0, end), pair) for row, pair in pairs)
