"""Joint plan of a swarm in which no pair enters the interference zone: eq. (18), any number of vehicles.

min sum_j cost(r_j)  subject to the waypoints and  dr_ij(t) not in I  for all pairs and all t.

Method: successive convex steps. Around the current curves each sample (i, j, t) near or in the zone gets
the plane that touches the zone towards dr_ij(t): n.dr_ij(t) >= support(n) + margin keeps it out, and is a
convex, conservative approximation of the zone (Augugliaro, Schoellig and D'Andrea, Generation of
collision-free trajectories for a quadrocopter fleet, 2012). Each step deforms the curves as little as the
planes allow; planes are updated with the curves until convergence (`convexification`). Then `certificate`
proves the plan.

Starts: the sides on which pairs already pass, to the right if head on; then mirrored; then at random. The
cheapest certified plan is returned. A plan that is not certified is never returned: InfeasibleError names the
pair in conflict, its time and depth.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.geometry.zone import Zone
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.tunable import check_bounds, tunable
from q2q_planner.offline.avoidance.convexification import Attempt, Problem, Start, search
from q2q_planner.offline.avoidance.deviation_space import deviation_space
from q2q_planner.offline.certificate import Certificate, as_certified, certify
from q2q_planner.offline.convex_zone import Lathe, lathe_around
from q2q_planner.offline.minimum_snap.minimum_snap import Reading, minimum_snap_plan, plan_cost
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints

SAME_MOMENT = 1e-3
"""Time difference within which a waypoint is named in an error [s]."""


@dataclass(frozen=True, slots=True)
class AvoidanceParams:
    """Parameters of the search; none of them weakens the proof."""

    pieces: int = tunable(5, "pieces between two waypoints; more give a freer curve", low=2, high=40)
    margin: float = tunable(2e-4, "distance kept from the zone", unit="m", low=1e-6, high=1.0)
    steps: int = tunable(40, "most convex steps from one start", low=1, high=1000)
    starts: int = tunable(2, "starts tried: as the pairs pass, mirrored, then at random", low=1, high=100)
    seed: int = tunable(0, "seed of the random starts", low=0)

    def __post_init__(self) -> None:
        """Raise ValueError if a number is out of bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class AvoidancePlan:
    """Certified plan, its costs and the number of steps."""

    plan: SwarmPlan
    certificate: Certificate
    cost: float
    """(18)"""
    infimum: float
    """(18) without avoidance."""
    steps: int
    """Convex steps of all starts."""


class InfeasibleError(ValueError):
    """Error when no certified plan was found, naming the pair in conflict."""


def avoid(
    swarm: Sequence[VehicleWaypoints],
    zone: Zone,
    reading: Reading = "stop_and_go",
    params: AvoidanceParams | None = None,
    warm: SwarmPlan | None = None,
) -> AvoidancePlan:
    """Return the cheapest certified plan found.

    Args:
        swarm: the waypoints of each vehicle.
        zone: the zone that every pair keeps out of.
        reading: whether vehicles stop at inner waypoints (`minimum_snap`).
        params: numbers of the search.
        warm: a plan of the same vehicles; the search starts around it and tries nothing else.

    Raises:
        InfeasibleError: no start led to a certified plan.
        ValueError: the waypoints cannot be flown.
    """
    numbers = params or AvoidanceParams()
    lathe = lathe_around(zone)
    free = minimum_snap_plan(swarm, reading)
    infimum, proof = plan_cost(free), certify(free, lathe)
    if proof.holds:
        return AvoidancePlan(as_certified(free, lathe), proof, infimum, infimum, 0)
    _check_held(swarm, lathe)
    spaces = tuple(deviation_space(vehicle, reading, numbers.pieces) for vehicle in swarm)
    problem = Problem(free, infimum, spaces, lathe, numbers.margin, numbers.steps)
    found = [search(problem, start) for start in _starts(problem, numbers, warm)]
    certified = [attempt for attempt in found if attempt.proof.holds]
    if not certified:
        raise InfeasibleError(_explanation(found))
    best = min(certified, key=lambda attempt: attempt.cost)
    steps = sum(attempt.steps for attempt in found)
    return AvoidancePlan(as_certified(best.plan, lathe), best.proof, best.cost, infimum, steps)


def _starts(problem: Problem, params: AvoidanceParams, warm: SwarmPlan | None) -> Iterator[Start]:
    pairs = len(problem.pairs[0])
    if warm is not None:
        if warm.names != problem.free.names:
            raise ValueError(
                f"warm start of {', '.join(warm.names)}: expected {', '.join(problem.free.names)}"
            )
        yield Start(np.ones(pairs), warm)
        return
    generator = np.random.default_rng(params.seed)
    for start in range(params.starts):
        yield Start(_sides(start, pairs, generator), problem.free)


def _sides(start: int, pairs: int, generator: np.random.Generator) -> Array:
    match start:
        case 0:
            return np.ones(pairs)
        case 1:
            return -np.ones(pairs)
        case _:
            return generator.choice([-1.0, 1.0], pairs)


def _check_held(swarm: Sequence[VehicleWaypoints], lathe: Lathe) -> None:
    """Raise if waypoints at the same time, or a rest after the last one, lie in each other's zone."""
    held = list(_held_together(swarm))
    if not held:
        return
    rel = [
        np.subtract(swarm[i].waypoints[at].pos, swarm[j].waypoints[other].pos) for (i, at), (j, other) in held
    ]
    clearance = lathe.signed_distance(np.array(rel))
    inside = np.flatnonzero(clearance <= 0.0)
    if inside.size:
        (i, at), (j, other) = held[inside[0]]
        both = f"{swarm[i].name}, waypoint {at} and {swarm[j].name}, waypoint {other}"
        depth = f"{-clearance[inside[0]]:.3g} m inside each other's zone at t = {swarm[i].waypoints[at].t} s"
        raise InfeasibleError(f"{both} lie {depth}; no trajectory can keep them apart")


def _held_together(swarm: Sequence[VehicleWaypoints]) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield (vehicle, waypoint) and each (other vehicle, waypoint) that is held at its time."""
    times = [vehicle.times for vehicle in swarm]
    for i, vehicle in enumerate(swarm):
        for at, waypoint in enumerate(vehicle.waypoints):
            for j, there in enumerate(times):
                other = _held_at(there, waypoint.t)
                if j != i and other is not None:
                    yield (i, at), (j, other)


def _held_at(times: Array, t: float) -> int | None:
    """Return the waypoint, of those at `times`, at which a vehicle is at time t [s], or None."""
    if t >= times[-1]:
        return len(times) - 1
    near = int(np.abs(times - t).argmin())
    return near if abs(times[near] - t) < SAME_MOMENT else None


def _explanation(found: Sequence[Attempt]) -> str:
    proof = max((attempt.proof for attempt in found), key=lambda proof: proof.clearance)
    first, second = proof.pair or ("", "")
    return (
        f"{first} and {second} cannot be kept apart: {-proof.clearance:.3g} m inside each other's zone at "
        f"t = {proof.t:.2f} s in the best of {len(found)} starts; move a waypoint there or allow more time"
    )
