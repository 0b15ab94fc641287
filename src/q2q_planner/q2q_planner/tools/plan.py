"""Turn waypoints into a plan file: minimum snap, and out of each other's draft, proven for every t."""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from time import process_time

import yaml

from q2q_model.tools.command_line import CommandLine, without_ros
from q2q_model.tools.models import find_model
from q2q_model.zone import Cylinder, Zone
from q2q_planner import plan_file
from q2q_planner.avoidance import avoid
from q2q_planner.certificate import Certificate, certify
from q2q_planner.minsnap import minimum_snap_plan, plan_cost
from q2q_planner.plan_file import PlanFacts
from q2q_planner.tools.export import write_samples, write_uploads
from q2q_planner.trajectory import SwarmPlan
from q2q_planner.waypoints import VehicleWaypoints, swarm_from_document

EXAMPLE = """  ros2 run q2q_planner plan waypoints.yaml --out plan.json
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --model model.q2q --json cost.json --csv plan.csv
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --no-avoid --upload uploads/

waypoints.yaml:
  vehicles: {cf1: [{t: 0, pos: [-1, 0, 0]}, {t: 20, pos: [0, 0, 2.5]}, {t: 50, pos: [1, 0, 0]}], cf2: [..]}"""


@dataclass(frozen=True, slots=True)
class Planned:
    """Hold a plan and what it took."""

    plan: SwarmPlan
    proof: Certificate
    cost: float
    infimum: float
    cpu_ms: float


def main(arguments: Sequence[str] | None = None) -> int:
    """Plan as the command line says; return the exit status."""
    asked = parser().parse_args(without_ros(arguments))
    try:
        return _run(asked)
    except (ValueError, OSError, yaml.YAMLError) as refusal:
        print(f"plan: {refusal}", file=sys.stderr)
        return 1


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("plan", __doc__, EXAMPLE)
    made.add_argument("waypoints", type=Path, help="YAML file of waypoints")
    made.add_argument("--out", type=Path, required=True, metavar="PLAN", help="plan file to write")
    made.add_argument("--json", type=Path, help="write cost and proof to this file")
    made.add_argument(
        "--avoid", action=argparse.BooleanOptionalAction, default=True, help="keep out of the zone"
    )
    made.add_argument(
        "--model", help="take the zone of this interaction model: a shipped name or a .q2q file"
    )
    made.add_argument("--eps", type=float, default=0.1, help="radius of the zone [m] (default 0.1)")
    made.add_argument(
        "--d", type=float, default=1.1, help="half height of the cylinder zone [m] (default 1.1)"
    )
    made.add_argument("--reading", choices=("stop_and_go", "free"), default="stop_and_go", help="of eq. (17)")
    made.add_argument("--csv", type=Path, help="write setpoints at 100 Hz to this file")
    made.add_argument(
        "--upload", type=Path, help="write <name>.csv for Crazyswarm2's upload into this folder"
    )
    return made


def planned(asked: argparse.Namespace, swarm: Sequence[VehicleWaypoints], zone: Zone) -> Planned:
    """Return the plan that the command line asks for; raise ValueError where there is none."""
    before = process_time()
    if asked.avoid:
        found = avoid(swarm, zone, asked.reading)
        return Planned(found.plan, found.certificate, found.cost, found.infimum, _ms_since(before))
    plan = minimum_snap_plan(swarm, asked.reading)
    cost = plan_cost(plan)
    return Planned(plan, certify(plan, zone), cost, cost, _ms_since(before))


def as_json(made: Planned) -> dict[str, float | bool | int | None]:
    """Return the numbers other programs read."""
    return {
        "snap_cost": made.cost,
        "snap_infimum": made.infimum,
        "certified": made.proof.holds,
        "clearance_m": made.proof.clearance if isfinite(made.proof.clearance) else None,
        "cpu_ms": made.cpu_ms,
        "vehicles": len(made.plan.names),
    }


def _run(asked: argparse.Namespace) -> int:
    swarm = swarm_from_document(yaml.safe_load(asked.waypoints.read_text(encoding="utf-8")))
    zone = find_model(asked.model).zone if asked.model else Cylinder(asked.eps, asked.d)
    made = planned(asked, swarm, zone)
    words = f"the zone of {asked.model}" if asked.model else f"cylinder eps {asked.eps} m, d {asked.d} m"
    facts = PlanFacts(words, made.cost, made.infimum, made.proof.clearance)
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    plan_file.save(asked.out, made.plan, facts)
    _write_others(asked, made)
    print(f"{asked.out}: {len(made.plan.names)} vehicles, {made.plan.duration:g} s")
    print(f"  snap cost {made.cost:.6g}, {made.cost / made.infimum:.4f} of what it costs without avoidance")
    print(f"  {_verdict(made)} ({words})")
    return 0


def _write_others(asked: argparse.Namespace, made: Planned) -> None:
    if asked.json:
        asked.json.write_text(json.dumps(as_json(made), indent=1) + "\n")
    if asked.csv:
        write_samples(asked.csv, made.plan)
    if asked.upload:
        write_uploads(asked.upload, made.plan)


def _verdict(made: Planned) -> str:
    proof = made.proof
    if proof.pair is None:
        return "one vehicle: nothing to keep out of"
    nearest = f"{' and '.join(proof.pair)} at {proof.t:.2f} s"
    if proof.holds:
        return f"certified out of the zone for every t; nearest {proof.clearance * 1e3:.2f} mm, {nearest}"
    return f"NOT out of the zone: {-proof.clearance * 1e3:.0f} mm inside, {nearest}"


def _ms_since(before: float) -> float:
    return (process_time() - before) * 1e3


if __name__ == "__main__":
    sys.exit(main())
