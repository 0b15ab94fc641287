"""Plan files whose certificate is not trusted: every reader proves it again.

A file states that it is certified, for the zone whose profile it has. Its numbers may have been edited since,
and its checksum written again; the proof of the numbers that are flown cannot be.

A proof is of the reference at every t: over a jump of its position, velocity or yaw, or in a fall without
thrust, no vehicle follows, so a plan with one is refused (`reference_steps`, `upward_thrust`). It begins and
ends at rest, as before and after it vehicles rest.
"""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from q2q_model.trajectory import plan_file
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.certificate.certificate import certify
from q2q_planner.offline.certificate.convex_zone import zone_of_profile
from q2q_planner.offline.certificate.reference_steps import Steps, largest_step_sums
from q2q_planner.offline.certificate.upward_thrust import least_upward_thrust

STEPS_MAX = Steps(pos=1e-3, vel=1e-2, yaw=1e-2)
"""Largest sums of the steps within STEPS_SPAN that pass: far above rounding, below tracking errors."""

STEPS_SPAN = 1.0
"""Time in which steps add up [s]: a vehicle follows what is slower than STEPS_MAX in it."""


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
        warnings.warn(f"{path} has no zone: treated as not certified", stacklevel=2)
        return replace(plan, certified=False)
    try:
        proof = certify(plan, zone_of_profile(plan.zone_profile))
    except ValueError as wrong:
        raise ValueError(f"{path} is not a certified plan: {wrong}; {plan_file.REMEDY}") from wrong
    if not proof.holds:
        pair = " and ".join(proof.pair or ())
        proven = f"{pair} have a proven clearance of {proof.clearance:.3g} m at {proof.t:.2f} s"
        why = proof.not_computed or proven
        raise ValueError(f"{path} states that it is certified but is not: {why}; {plan_file.REMEDY}")
    return plan


def _check_continuous(plan: SwarmPlan, path: Path) -> None:
    for name, curve in zip(plan.names, plan.trajectories, strict=True):
        with np.errstate(over="ignore", invalid="ignore"):
            found = largest_step_sums(curve, STEPS_SPAN)
        words = ("position", "m"), ("velocity", "m/s"), ("yaw", "rad")
        for step, allowed, (what, unit) in zip(found, STEPS_MAX, words, strict=True):
            if not step <= allowed:
                bound = f"maximum {allowed:g} {unit}; {plan_file.REMEDY}"
                jump = f"jumps by {step:.3g} {unit} within {STEPS_SPAN:g} s"
                raise ValueError(f"{path}: the {what} of {name} {jump}, {bound}")


def _check_thrust(plan: SwarmPlan, path: Path) -> None:
    for name, curve in zip(plan.names, plan.trajectories, strict=True):
        with np.errstate(over="ignore", invalid="ignore"):
            least = least_upward_thrust(curve)
        if not least.is_commanded:
            raise ValueError(f"{path}: {name} {least}, at t = {least.t:.2f} s; allow more time")
