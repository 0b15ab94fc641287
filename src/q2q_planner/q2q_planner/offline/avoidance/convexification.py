"""Successive convexification: deform a swarm's trajectories out of a zone step by step, then certify them.

Each step linearises the zone around the current curves (`separating_planes`) and deforms the minimum snap
curves as little as the planes allow (`least_deformation`). In a large swarm the planes of the first steps are
soft, so that pairs can change sides. When the cost has converged and no plane is violated, the curves are
certified (`certificate`); if a pair is in the zone between two planes, the samples are made denser, and the
deepest one of each pass through the zone gets a plane, too (`near_samples.cut_corners`). Walls are planes
from the start.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.avoidance.avoidance_problem import Problem
from q2q_planner.offline.avoidance.deviation_space import deform
from q2q_planner.offline.avoidance.least_deformation import HARD, least_deviations
from q2q_planner.offline.avoidance.separating_planes import SPACING, Sides
from q2q_planner.offline.avoidance.step_planes import watched_samples
from q2q_planner.offline.avoidance.swarm_samples import SwarmSamples, sample_swarm, sample_times
from q2q_planner.offline.certificate.certificate import Certificate, certify
from q2q_planner.offline.minimum_snap.minimum_snap import plan_cost
from q2q_planner.offline.minimum_snap.waypoints import FARTHEST
from q2q_planner.offline.walls import WallProof, prove_within

DENSER = 3
"""Rounds of samples, each twice as dense as the previous one."""
STILL = 1e-4
"""Relative change of cost in a step below which the iteration has converged."""
SOFTEST = 0.1
"""Softness of the first step of a large swarm."""
HARDEN = 0.3
"""Factor on the softness from step to step."""
FEWEST_SAMPLES = 64
TOO_DEEP = 0.2
"""Depth, in radii, beyond which denser samples do not help."""


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Starting point of the iteration."""

    sides: Sides
    """Of the first step."""
    plan: SwarmPlan
    """Curves around which the first planes are placed."""


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """Result of the iteration."""

    plan: SwarmPlan
    proof: Certificate
    wall_proof: WallProof | None
    """None without walls."""
    cost: float
    steps: int

    @property
    def holds(self) -> bool:
        """Return whether the plan is proven to stay out of the zone and within the walls."""
        return self.proof.holds and (self.wall_proof is None or self.wall_proof.holds)


def search(problem: Problem, start: Start) -> Attempt:
    """Return the result of the convex steps from one start, with its certificate."""
    spacing, steps, softness = SPACING * problem.zone.eps, 0, SOFTEST
    plan, around = problem.free, start
    for denser in range(DENSER):
        times = sample_times(plan.trajectories, spacing, FEWEST_SAMPLES)
        samples = sample_swarm(problem.free, problem.spaces, times)
        samples = samples.with_room() if problem.walls else samples
        deviations, taken = _iterate(problem, samples, around, softness, corners=denser > 0)
        steps += taken
        plan = _deformed_plan(problem, deviations)
        proof = certify(plan, problem.zone)
        wall_proof = prove_within(plan, problem.walls) if problem.walls else None
        attempt = Attempt(plan, proof, wall_proof, plan_cost(plan), steps)
        if attempt.holds or proof.clearance < -TOO_DEEP * problem.zone.eps:
            break
        spacing, around, softness = 0.5 * spacing, Start(_kept(start.sides), plan), HARD
    return attempt


def _kept(sides: Sides) -> Sides:
    """Return the sides on which pairs pass already."""
    return Sides(np.ones_like(sides.sign))


def _deformed_plan(problem: Problem, deviations: Array) -> SwarmPlan:
    rows = zip(problem.free.trajectories, problem.spaces, deviations[: len(problem.spaces)], strict=True)
    return SwarmPlan(
        problem.free.names, tuple(deform(curve, space, y[: space.dimension]) for curve, space, y in rows)
    )


def _iterate(
    problem: Problem, samples: SwarmSamples, start: Start, softness: float, *, corners: bool
) -> tuple[Array, int]:
    """Return the converged deviations (n, m, 3) and the number of steps; cut corners may get planes.

    Where planes contradict each other deviations may grow without end: those before are returned.
    """
    sides, dual = start.sides, np.zeros((problem.rows, len(samples.t)))
    positions = start.plan.positions(samples.t)
    deviations, cost = np.zeros((len(samples.rows), samples.rows.shape[2], 3)), np.inf
    for step in range(problem.most_steps):
        watched = watched_samples(problem, positions, dual > 0.0, corners=corners)
        before, cost = cost, problem.infimum + float((deviations**2).sum())
        if abs(before - cost) < STILL * cost and watched.distance >= 0.0:
            return deviations, step
        at, planes = watched.planes(problem, sides)
        taken, found = least_deviations(samples, planes, dual[at], softness)
        positions, sides = samples.positions(taken)[:, : len(problem.spaces)], _kept(sides)
        if not np.abs(positions).max() < FARTHEST:
            return deviations, step
        deviations, dual[at] = taken, found
        softness = max(HARD, HARDEN * softness)
    return deviations, problem.most_steps
