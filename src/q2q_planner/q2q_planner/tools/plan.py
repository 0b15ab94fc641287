"""Turn waypoints into a plan file: minimum snap, and out of each other's draft, proven for every t."""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from time import process_time

from q2q_model.level_set import level_set
from q2q_model.tools.command_line import CommandLine, without_ros
from q2q_model.tools.models import find_model
from q2q_model.vehicle import VEHICLES, vehicle_by_name
from q2q_model.zone import Cylinder, Ellipsoid, Zone
from q2q_planner import plan_file
from q2q_planner.avoidance import AvoidanceParams, avoid
from q2q_planner.certificate import Certificate, certify
from q2q_planner.draft_zone import PAPER_LOOP, LearnedDraft, avoid_draft
from q2q_planner.flight_limits import FlightLimits, check_flyable, with_limits_of
from q2q_planner.minsnap import minimum_snap_plan, plan_cost
from q2q_planner.plan_file import PlanFacts
from q2q_planner.tools.export import write_samples, write_uploads
from q2q_planner.tools.waypoint_file import read_waypoints
from q2q_planner.trajectory import SwarmPlan
from q2q_planner.waypoints import VehicleWaypoints

EXAMPLE = """  ros2 run q2q_planner plan waypoints.yaml --out plan.json
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --model model.q2q --json cost.json --csv plan.csv
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --model model.q2q --cut 0.88
  ros2 run q2q_planner plan waypoints.yaml --out plan.json --no-avoid --upload uploads/

waypoints.yaml:
  vehicles: {cf1: [{t: 0, pos: [-1, 0, 0]}, {t: 20, pos: [0, 0, 2.5]}, {t: 50, pos: [1, 0, 0]}], cf2: [..]}"""


LARGEST = 5.0
"""Largest zone [m]: far beyond any draft measured."""

DRAFT = "paper_law"
"""The draft in which Figs 11 and 13 are drawn where --model names none."""


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
    except (ValueError, OSError) as refusal:
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
    made.add_argument("--starts", type=int, default=2, help="starts of the search (default 2)")
    made.add_argument("--warm", type=Path, metavar="PLAN", help="search only around this plan")
    made.add_argument("--reading", choices=("stop_and_go", "free"), default="stop_and_go", help="of eq. (17)")
    made.add_argument("--csv", type=Path, help="write setpoints at 100 Hz to this file")
    made.add_argument(
        "--upload", type=Path, help="write <name>.csv for Crazyswarm2's upload into this folder"
    )
    made.add_argument(
        "--figures", type=Path, help="draw Figs 10 to 13 and plan and zone in 3-D, into this folder"
    )
    _add_zone(made)
    _add_limits(made)
    return made


def _add_zone(made: CommandLine) -> None:
    zone = made.add_argument_group("zone")
    zone.add_argument("--shape", choices=("cylinder", "ellipsoid"), default="cylinder")
    zone.add_argument("--eps", type=float, default=0.1, help="radius of the zone [m] (default 0.1)")
    zone.add_argument("--d", type=float, default=1.1, help="half height of the zone [m] (default 1.1)")
    zone.add_argument("--model", help="take this interaction model's zone: a shipped name or a .q2q file")
    zone.add_argument("--threshold", type=float, help="with --model: where its draft is above this [m/s^2]")
    zone.add_argument("--cut", type=float, help="with --model: so large that this share of the draft is gone")


def _add_limits(made: CommandLine) -> None:
    limits = made.add_argument_group("limits; waypoints without t get times within them")
    limits.add_argument("--vehicle", default="crazyflie_2_0", help=f"one of {', '.join(VEHICLES)}")
    limits.add_argument("--speed", type=float, default=2.0, help="[m/s] (default 2)")
    limits.add_argument("--acceleration", type=float, default=4.0, help="[m/s^2] (default 4)")


def planned(
    asked: argparse.Namespace, swarm: Sequence[VehicleWaypoints], zone: Zone, before: float
) -> Planned:
    """Return the plan that the command line asks for; raise ValueError where there is none.

    `before` is the processor time at which work on it began [s].
    """
    warm = plan_file.load(asked.warm) if asked.warm else None
    params = AvoidanceParams(starts=asked.starts)
    if asked.avoid:
        found = avoid(swarm, zone, asked.reading, params, warm)
        return Planned(found.plan, found.certificate, found.cost, found.infimum, _ms_since(before))
    plan = minimum_snap_plan(swarm, asked.reading)
    cost, proof = plan_cost(plan), certify(plan, zone)
    plan = SwarmPlan(plan.names, plan.trajectories, proof.holds)
    return Planned(plan, proof, cost, cost, _ms_since(before))


def zone_of(asked: argparse.Namespace, swarm: Sequence[VehicleWaypoints]) -> tuple[Zone, str]:
    """Return the zone that the command line asks for, and in words."""
    if asked.cut is not None:
        return _zone_by_cut(asked, swarm)
    if asked.model and asked.threshold is not None:
        words = f"level set of {asked.model} at {asked.threshold} m/s^2"
        return level_set(find_model(asked.model).interaction, asked.threshold), words
    if asked.model:
        return find_model(asked.model).zone, f"the zone of {asked.model}"
    if asked.threshold is not None:
        raise ValueError(f"--threshold {asked.threshold} needs --model: a threshold of which draft?")
    for name in ("eps", "d"):
        value = getattr(asked, name)
        if not 0.0 < value < LARGEST:
            raise ValueError(f"--{name} = {value}: allowed is 0 to {LARGEST} m, both excluded")
    shape = Cylinder if asked.shape == "cylinder" else Ellipsoid
    return shape(asked.eps, asked.d), f"{asked.shape} eps {asked.eps} m, d {asked.d} m"


def _zone_by_cut(asked: argparse.Namespace, swarm: Sequence[VehicleWaypoints]) -> tuple[Zone, str]:
    if not asked.model or asked.threshold is not None:
        raise ValueError(f"--cut {asked.cut} needs --model, and no --threshold: it chooses that")
    file = find_model(asked.model)
    draft = LearnedDraft(file.interaction, file.gains or PAPER_LOOP, asked.cut)
    made = avoid_draft(swarm, draft, asked.reading, AvoidanceParams(starts=asked.starts))
    if made.cut < asked.cut:
        raise ValueError(
            f"--cut {asked.cut}: at most {made.cut:.3f} was found; ask for less, or allow more time"
        )
    words = f"level set of {asked.model} at {made.zone.threshold:.4g} m/s^2"
    return made.zone, f"{words}: spares {100.0 * made.cut:.1f} % of the height error foretold"


def swarm_of(asked: argparse.Namespace) -> tuple[VehicleWaypoints, ...]:
    """Return the waypoints of the file, timed where it gives no times; raise ValueError naming the file."""
    limits = with_limits_of(FlightLimits(asked.speed, asked.acceleration), vehicle_by_name(asked.vehicle))
    return read_waypoints(asked.waypoints, limits, asked.reading)


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
    swarm, before = swarm_of(asked), process_time()
    zone, words = zone_of(asked, swarm)
    made = planned(asked, swarm, zone, before)
    check_flyable(made.plan, swarm, vehicle_by_name(asked.vehicle))
    facts = PlanFacts(words, made.cost, made.infimum, made.proof.clearance)
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    plan_file.save(asked.out, made.plan, facts)
    _write_others(asked, made)
    if asked.figures:
        _draw(asked, made, swarm, zone)
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


def _draw(asked: argparse.Namespace, made: Planned, swarm: Sequence[VehicleWaypoints], zone: Zone) -> None:
    from q2q_planner.tools import plan_figures  # drawing is slow to import

    model = find_model(asked.model or DRAFT).interaction
    free = minimum_snap_plan(swarm, asked.reading)
    for path in plan_figures.draw_all(asked.figures, made.plan, free, zone, model):
        print(f"  drew {path}")


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
