"""Planning from the command line: zone, search, certificate, and the files of the plan."""

from argparse import Namespace
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from time import process_time

from q2q_model.counted import counted
from q2q_model.documents.json_file import text_stream, write_json
from q2q_model.geometry.zone import Zone
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import Array
from q2q_model.trajectory import plan_file
from q2q_model.trajectory.plan_file import PlanFacts
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.certificate.certificate import Certificate, as_certified, certify
from q2q_planner.offline.certificate.convex_zone import zone_around
from q2q_planner.offline.certificate.rounding_bound import NOT_BOUNDED
from q2q_planner.offline.minimum_snap.feasibility import check_feasible, plan_peaks
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan, plan_cost
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.offline.walls import WallProof, prove_within
from q2q_planner.tools.export import check_upload_of, upload_rows, write_samples, write_uploads
from q2q_planner.tools.figure_zone import check_drawn
from q2q_planner.tools.flight_options import naming_options, read_swarm
from q2q_planner.tools.risk_options import risk_facts, risk_params
from q2q_planner.tools.zone_options import zone_of

DRAWN_MODEL = "paper_law"
"""Downwash of Figs 11 and 13 without --model."""


@dataclass(frozen=True, slots=True)
class Planned:
    """Plan with its proofs, cost and computing time."""

    plan: SwarmPlan
    proof: Certificate
    wall_proof: WallProof | None
    """None without walls."""
    cost: float
    infimum: float
    cpu_ms: float


def make_plan(
    asked: Namespace, swarm: Sequence[VehicleWaypoints], zone: Zone, warm: SwarmPlan | None, before: float
) -> Planned:
    """Return the plan for the command line; raise ValueError if there is none.

    `warm` is the plan to start from, `before` the processor time at the start [s].
    """
    params = _params_of(asked)
    if asked.avoid:
        found = avoid_zones(swarm, zone, asked.reading, params, warm)
        proofs = found.certificate, found.wall_proof
        return Planned(found.plan, *proofs, found.cost, found.infimum, _ms_since(before))
    plan = minimum_snap_plan(swarm, asked.reading)
    hull = zone_around(zone)
    cost, proof = plan_cost(plan), certify(plan, hull)
    wall_proof = prove_within(plan, params.walls) if params.walls else None
    shown = as_certified(plan, hull) if proof.holds else plan
    return Planned(shown, proof, wall_proof, cost, cost, _ms_since(before))


def _params_of(asked: Namespace) -> AvoidanceParams:
    """Return the parameters of the search; raise ValueError naming the option that is out of bounds."""
    with naming_options():
        return AvoidanceParams(initial_guesses=asked.initial_guesses, within=tuple(asked.within or ()))


def as_json(made: Planned) -> dict[str, float | bool | None]:
    """Return the content of the --json file."""
    return {
        "snap_cost": made.cost,
        "snap_infimum": made.infimum,
        "certified": made.proof.holds,
        "clearance_m": _finite(made.proof.clearance),
        "cpu_ms": made.cpu_ms,
        "vehicles": len(made.plan.names),
    } | _wall_facts(made.wall_proof)


def _wall_facts(proof: WallProof | None) -> dict[str, float | bool | None]:
    return {} if proof is None else {"within": proof.holds, "wall_clearance_m": _finite(proof.clearance)}


def _finite(clearance: float) -> float | None:
    return clearance if isfinite(clearance) else None


def run(asked: Namespace) -> int:
    """Plan, certify, and write the files; return the exit status."""
    asked, swarm = read_swarm(asked)
    if asked.upload:
        check_upload_of(swarm, asked.upload, (asked.out, asked.json, asked.csv))
    before = process_time()
    warm = plan_file.load(asked.warm_start) if asked.warm_start else None
    zone, words = zone_of(asked, swarm, _params_of(asked), warm)
    if asked.figures:
        check_drawn(zone)
    made = make_plan(asked, swarm, zone, warm, before)
    reserve = 0.0 if asked.risk is None else risk_params(asked).hold
    check_feasible(made.plan, swarm, asked.vehicle, reserve, asked.tilt)
    uploads = upload_rows(made.plan) if asked.upload else {}
    facts = PlanFacts(words, made.cost, made.infimum, made.proof.clearance)
    plan_file.save(asked.out, made.plan, facts)
    with redirect_stdout(text_stream(asked.json)):
        if asked.figures:
            _draw(asked, made, swarm, zone)
    _write_others(asked, made, uploads)
    with redirect_stdout(text_stream(asked.json)):
        _report(asked.out, made, words)
    return 0


def _report(out: Path, made: Planned, words: str) -> None:
    """Print where the plan is, its cost and its proofs; `words` name its zone."""
    print(f"{out}: {counted(len(made.plan.names), 'vehicle')}, {made.plan.duration:g} s")
    more = f", {made.cost / made.infimum:.4f} times that without avoidance" if made.infimum > 0.0 else ""
    print(f"  snap cost {made.cost:.6g}{more}")
    speed, acceleration, tilt = plan_peaks(made.plan)
    print(f"  at most {speed:.3g} m/s, {acceleration:.3g} m/s^2, tilted by {tilt:.2g} rad")
    print(f"  {_verdict(made)} ({words})")
    if made.wall_proof:
        print(f"  {_wall_verdict(made.wall_proof)} ({made.wall_proof.walls})")


def _write_others(asked: Namespace, made: Planned, uploads: Mapping[str, Array]) -> None:
    if asked.csv:
        write_samples(asked.csv, made.plan)
    if asked.upload:
        write_uploads(asked.upload, uploads)
    if asked.json:  # last: a printed document cannot be taken back
        facts = as_json(made) | risk_facts(asked, len(made.plan.names), certified=made.proof.holds)
        write_json(facts, asked.json)


def _draw(asked: Namespace, made: Planned, swarm: Sequence[VehicleWaypoints], zone: Zone) -> None:
    from q2q_planner.tools import plan_figures  # drawing is slow to import

    model = find_model(asked.model or DRAWN_MODEL).interaction
    free = minimum_snap_plan(swarm, asked.reading)
    for path in plan_figures.draw_all(asked.figures, made.plan, free, zone, model):
        print(f"  drew {path}")


def _verdict(made: Planned) -> str:
    proof = made.proof
    if proof.pair is None:
        return "one vehicle: no pair to certify"
    if proof.not_computed:
        return f"NOT proven: {proof.not_computed}"
    nearest = f"{' and '.join(proof.pair)} at {proof.t:.2f} s"
    if proof.holds:
        least = f"smallest distance to it {proof.clearance * 1e3:.2f} mm"
        return f"certified out of the zone for every t; {least}, {nearest}"
    return f"NOT out of the zone: {-proof.clearance * 1e3:.0f} mm inside, {nearest}"


def _wall_verdict(proof: WallProof) -> str:
    nearest = f"{proof.name} at {proof.t:.2f} s"
    if proof.holds:
        least = f"smallest distance to one {proof.clearance * 1e3:.2f} mm"
        return f"certified within the walls for every t; {least}, {nearest}"
    if not isfinite(proof.clearance):
        return f"NOT proven within the walls: {NOT_BOUNDED}"
    return f"NOT within the walls: {-proof.clearance * 1e3:.0f} mm beyond, {nearest}"


def _ms_since(before: float) -> float:
    return (process_time() - before) * 1e3
