"""Licence of a program and score of licences: what is flown, reported and written."""

import math
from argparse import Namespace
from pathlib import Path

from q2q_model.documents.json_file import write_json
from q2q_model.documents.written_file import write_text
from q2q_sim.licence.crazyflie_py.served_vehicles import vehicles_from_file
from q2q_sim.licence.flight_order import Program
from q2q_sim.licence.licence_flights import licence
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.licence_reports import (
    junit_xml,
    licence_json,
    report_text,
    write_licence_page,
)
from q2q_sim.licence.licence_score import licence_score_json, score_program, scored_programs
from q2q_sim.licence.program_process.link_host import scanned_uris
from q2q_sim.licence.rules.licence_limits import LicenceLimits
from q2q_sim.licence.rules.starting_places import check_starts


def judge_program(args: Namespace) -> int:
    """Judge a program, print the report and write it; return the exit status."""
    x, y, z = args.room
    options = LicenceOptions(
        starts=tuple((a, b, math.radians(yaw)) for a, b, yaw in args.start),
        limits=LicenceLimits(half_room=(0.5 * x, 0.5 * y), ceiling=z),
        air=args.air,
        seed=args.seed,
        arming=args.arming,
        scanned=scanned_uris(args.scan or max(len(args.start), 1)),
        served=vehicles_from_file(args.crazyflies) if args.crazyflies else (),
        limit=args.limit,
        jobs=args.jobs,
    )
    named = {f"--start {k + 1}": one for k, one in enumerate(options.starts)}
    check_starts(named or {one.name: one.start for one in options.served}, options.limits)
    found = licence(Program(args.script.resolve(), tuple(args.arguments), Path.cwd()), options)
    if args.json:
        write_json(licence_json(found), args.json)
    if args.junit:
        write_text(junit_xml(found), args.junit)
    print(report_text(found))
    if args.out:
        print(f"page: {write_licence_page(found, args.out)}")
    if not found.judged:
        return 2
    return 0 if found.passed else 1


def score_programs(args: Namespace) -> int:
    """Judge programs with and without seeded bugs, print and write the score; return the exit status."""
    found = []
    for program in scored_programs(args.score, tuple(args.only)):
        one = score_program(program, args.jobs, args.seed)
        found.append(one)
        print(f"{one.word}  {program.name}: {one.verdict}", flush=True)
    if args.json:
        write_json(licence_score_json(found), args.json)
    errors = sum(not one.judged for one in found)
    unjudged = f"; not judged because the simulator failed: {errors}" if errors else ""
    print(f"{sum(one.right for one in found)} of {len(found)} programs judged correctly{unjudged}")
    return 0 if all(one.right for one in found) else 1
