"""Plan files whose certificate is not trusted: every reader proves it again.

A file states that it is certified, for the zone whose profile it has. Its numbers may have been edited since,
and its checksum written again; the proof of the numbers that are flown cannot be.

A proof is of the reference at every t: over a jump of it, or in a fall without thrust, no vehicle follows, so
a plan with one is refused.
"""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from q2q_model.trajectory import plan_file
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.offline.certificate.convex_zone import zone_of_profile
from q2q_planner.offline.certificate.rounding_bound import largest_jump
from q2q_planner.offline.certificate.upward_thrust import least_upward_thrust

JUMP_MAX = 1e-3
"""Largest jump of a coordinate from one piece to the next [m]: far above rounding, below tracking errors."""


def load_plan(path: Path) -> SwarmPlan:
    """Return the plan in a file, certified only if that is proven here.

    A plan that states to be certified and does not have its zone is taken as not certified, with a warning.

    Raises:
        ValueError: the file is absent or no plan, jumps, falls without thrust, or states to be certified and
            is not.
    """
    plan = plan_file.load(path)
    _check_continuous(plan, path)
    _check_thrust(plan, path)
    if not plan.certified:
        return plan
    if not plan.zone_profile:
        warnings.warn(f"{path} does not have its zone: it is taken as not certified", stacklevel=2)
        return replace(plan, certified=False)
    try:
        proof = certify(plan, zone_of_profile(plan.zone_profile))
    except ValueError as wrong:
        raise ValueError(f"{path} is not a certified plan: {wrong}; {plan_file.REMEDY}") from wrong
    if not proof.holds:
        pair = " and ".join(proof.pair or ())
        proven = f"{pair} have a proven clearance of {proof.clearance:.3g} m at {proof.t:.2f} s"
        why = proof.not_computed or proven
        raise ValueError(f"{path} states that it is certified, and is not: {why}; {plan_file.REMEDY}")
    return plan


def _check_continuous(plan: SwarmPlan, path: Path) -> None:
    for name, curve in zip(plan.names, plan.trajectories, strict=True):
        with np.errstate(over="ignore", invalid="ignore"):
            jump = largest_jump(curve)
        if not jump <= JUMP_MAX:
            bound = f"allowed is {JUMP_MAX:g} m"
            raise ValueError(f"{path}: {name} jumps by {jump:.3g} m, {bound}; {plan_file.REMEDY}")


def _check_thrust(plan: SwarmPlan, path: Path) -> None:
    for name, curve in zip(plan.names, plan.trajectories, strict=True):
        with np.errstate(over="ignore", invalid="ignore"):
            least = least_upward_thrust(curve)
        if not least.is_commanded:
            raise ValueError(f"{path}: {name} {least}, at t = {least.t:.2f} s; allow more time")
