"""Joint plan of a swarm in which no pair enters the interference zone: eq. (18), any number of vehicles.

min sum_j cost(r_j)  subject to the waypoints and  dr_ij(t) not in I  for all pairs and all t.

Method: successive convex steps. Around the current curves each sample (i, j, t) near or in the zone gets
the plane that touches the zone towards dr_ij(t): n.dr_ij(t) >= support(n) + margin keeps it out, and is a
convex, conservative approximation of the zone (Augugliaro, Schoellig and D'Andrea, Generation of
collision-free trajectories for a quadrocopter fleet, 2012). Each step deforms the curves as little as the
planes allow; planes are updated with the curves until convergence (`convexification`). Then `certificate`
proves the plan.

Starts: the sides on which pairs already pass, to the right if head on; then mirrored; then at random;
within walls, if all fail, over and under each other. The cheapest certified plan is returned. A plan that is
not certified is never returned: InfeasibleError names the pair in conflict, its time and depth, or the
vehicle that crosses a wall.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.geometry.zone import Zone
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.avoidance_problem import Problem
from q2q_planner.offline.avoidance.convexification import Attempt, Start, search
from q2q_planner.offline.avoidance.deviation_space import deviation_space
from q2q_planner.offline.avoidance.separating_planes import Sides
from q2q_planner.offline.avoidance.waypoint_checks import InfeasibleError, check_apart, check_inside
from q2q_planner.offline.certificate.certificate import Certificate, as_certified, certify
from q2q_planner.offline.certificate.convex_zone import zone_around
from q2q_planner.offline.minimum_snap.minimum_snap import Reading, minimum_snap_plan, plan_cost
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.offline.walls import WallProof, prove_within


@dataclass(frozen=True, slots=True)
class AvoidancePlan:
    """Certified plan, its costs and the number of steps."""

    plan: SwarmPlan
    certificate: Certificate
    wall_proof: WallProof | None
    """None without walls."""
    cost: float
    """(18)"""
    infimum: float
    """(18) without avoidance."""
    steps: int
    """Convex steps of all initial guesses."""


def avoid_zones(
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
        params: numbers of the search, and the walls.
        warm: a plan of the same vehicles; the search starts around it and tries nothing else.

    Raises:
        InfeasibleError: no start led to a certified plan.
        ValueError: the waypoints cannot be flown.
    """
    search_params = params or AvoidanceParams()
    hull = zone_around(zone)
    free = minimum_snap_plan(swarm, reading)
    infimum, proof, walls = plan_cost(free), certify(free, hull), search_params.walls
    wall_proof = prove_within(free, walls) if walls else None
    if proof.holds and (wall_proof is None or wall_proof.holds):
        return AvoidancePlan(as_certified(free, hull), proof, wall_proof, infimum, infimum, 0)
    check_apart(swarm, hull)
    if walls:
        check_inside(swarm, walls)
    spaces = tuple(deviation_space(vehicle, reading, search_params.pieces) for vehicle in swarm)
    problem = Problem(free, infimum, spaces, hull, search_params.margin, search_params.steps, walls)
    found = [search(problem, start) for start in _starts(problem, search_params, warm)]
    certified = [attempt for attempt in found if attempt.holds]
    if not certified and walls and warm is None:
        certified = _over_or_under(problem)
    if not certified:
        raise InfeasibleError(_explanation(found, lambda: _holds_without_walls(problem, search_params, warm)))
    best = min(certified, key=lambda attempt: attempt.cost)
    steps = sum(attempt.steps for attempt in found)
    return AvoidancePlan(
        as_certified(best.plan, hull), best.proof, best.wall_proof, best.cost, infimum, steps
    )


def _starts(problem: Problem, params: AvoidanceParams, warm: SwarmPlan | None) -> Iterator[Start]:
    pairs = len(problem.pairs[0])
    if warm is not None:
        if warm.names != problem.free.names:
            raise ValueError(
                f"warm start of {', '.join(warm.names)}: expected {', '.join(problem.free.names)}"
            )
        yield Start(Sides(np.ones(pairs)), warm)
        return
    generator = np.random.default_rng(params.seed)
    for start in range(params.initial_guesses):
        yield Start(Sides(_sides(start, pairs, generator)), problem.free)


def _over_or_under(problem: Problem) -> list[Attempt]:
    """Return the certified results of starts in which the first of each pair passes over, or under."""
    signs = np.ones(len(problem.pairs[0]))
    tried = (search(problem, Start(Sides(sign * signs, vertical=True), problem.free)) for sign in (1.0, -1.0))
    return [attempt for attempt in tried if attempt.holds]


def _sides(start: int, pairs: int, generator: np.random.Generator) -> Array:
    match start:
        case 0:
            return np.ones(pairs)
        case 1:
            return -np.ones(pairs)
        case _:
            return generator.choice([-1.0, 1.0], pairs)


def _holds_without_walls(problem: Problem, params: AvoidanceParams, warm: SwarmPlan | None) -> bool:
    """Return whether there are walls, and the first initial guess leads to a certified plan without them."""
    if problem.walls is None:
        return False
    return search(replace(problem, walls=None), next(_starts(problem, params, warm))).holds


def _explanation(found: Sequence[Attempt], walls_are_why: Callable[[], bool]) -> str:
    """Return what cannot be kept, in words; `walls_are_why` searches without the walls, for pairs only."""
    apart = [attempt for attempt in found if attempt.proof.holds]
    best = f"in the best of {len(found)} initial guesses; move a waypoint there or allow more time"
    if apart:
        nearest = max(
            (attempt.wall_proof for attempt in apart if attempt.wall_proof), key=lambda one: one.clearance
        )
        beyond = f"{-nearest.clearance:.3g} m beyond a wall at t = {nearest.t:.2f} s"
        return f"{nearest.name} cannot be kept within the walls: {beyond} {best}"
    proof = max((attempt.proof for attempt in found), key=lambda proof: proof.clearance)
    first, second = proof.pair or ("", "")
    if proof.not_computed:
        tried = f"in any of {len(found)} initial guesses"
        return f"no pair is proven to stay apart, {tried}: {proof.not_computed}"
    depth = f"{-proof.clearance:.3g} m inside each other's zone at t = {proof.t:.2f} s"
    if walls_are_why():
        best = f"in the best of {len(found)} initial guesses, and apart without walls"
        advice = "move the walls outwards, or reduce the zone"
        return f"{first} and {second} cannot be kept apart within the walls: {depth} {best}; {advice}"
    return f"{first} and {second} cannot be kept apart: {depth} {best}"
