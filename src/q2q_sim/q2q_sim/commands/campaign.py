"""Fly random faults in random scenarios and check every flight: `campaign --runs N`.

Each run is determined by its seed. Finished runs are stored as JSON lines, from which an interrupted campaign
resumes. If a flight violates a safety policy, its seed is printed, and its bag, its scenario and a replay
page are kept. The exit status is 1 if any policy is violated.

With --guided, an optimiser searches for the faults with the smallest margin to a violation. A violation is
reduced to as few faults as possible and kept as a case file, which --case flies again, with a replay page.
The search is also measured on seeded bugs, in comparison with random faults.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.argument_types import output_file, output_folder, whole_number
from q2q_model.commands.command_line import CommandLine, UsageError, Work, given_options, run_command
from q2q_sim.air.air_names import check_air
from q2q_sim.scenarios.choices import ENGINES

EXAMPLE = """  scripts/campaign --runs 20
  scripts/campaign --runs 2000 --jobs 2 --through-nodes 200 --json out/campaign.json
  DASK_SCHEDULER_ADDRESS=tcp://host:8786 scripts/campaign --runs 20000 --engine dask
  scripts/campaign --guided --runs 400 --jobs 2 --json out/guided.json
  scripts/campaign --case out/campaign/cases/case_7.yaml"""
OUT = Path("out/campaign")
"""Folder of a campaign."""
OF_CASE = ("--case", "--out")
"""Options that have an effect with --case."""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly the campaign of the command line; return the exit status."""
    return run_command(
        parser(), _prepare, argv, interrupted="interrupted; run the same command to resume", refused=2
    )


def _prepare(args: Namespace) -> Work:
    if args.case:
        _refuse_beside_case(args)
    elif not args.guided and "--bug-runs" in given_options(args):
        raise UsageError("--bug-runs needs --guided")
    if args.through_nodes > args.runs:
        raise ValueError(f"--through-nodes {args.through_nodes}; must be at most --runs {args.runs}")
    if args.guided and args.through_nodes:
        raise ValueError("--guided flies without nodes: leave out --through-nodes")
    if args.case and not args.case.is_file():
        raise ValueError(f"no case at {args.case}")
    args.out = args.out or (args.case.parent if args.case else OUT)
    if args.air:
        check_air(args.air)
    if args.case or args.guided:
        from q2q_sim.campaigns.falsification.guided_campaign import refly_case
        from q2q_sim.campaigns.falsification.guided_campaign import run as run_guided

        return refly_case if args.case else run_guided
    from q2q_sim.campaigns.random_runs.resumable_campaign import run

    return run


def _refuse_beside_case(args: Namespace) -> None:
    """Raise UsageError for an option that is given and has no effect with --case."""
    for option in given_options(args):
        if option not in OF_CASE:
            raise UsageError(f"{option} has no effect with --case")


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("campaign", __doc__, EXAMPLE)
    made.add_argument("--runs", type=whole_number(1), default=20, help="number of runs (default 20)")
    made.add_argument("--jobs", type=whole_number(1), default=1, help="number of parallel runs (default 1)")
    made.add_argument(
        "--through-nodes",
        type=whole_number(0),
        default=0,
        help="number of runs through the real nodes, in lockstep",
    )
    made.add_argument(
        "--seed", type=whole_number(0), default=0, help="seed of the first run; the others follow it"
    )
    made.add_argument(
        "--engine",
        choices=ENGINES,
        default="local",
        help="where parallel runs are executed: on this machine (local), or by a Dask cluster (dask)",
    )
    made.add_argument(
        "--out",
        type=output_folder,
        help=f"folder of runs and bags (default {OUT}); with --case: folder of the page (default: that of "
        "the file)",
    )
    made.add_argument(
        "--air",
        default="",
        help="air model, in place of wake and disturbance: a shipped name, a .air file or module:Class"
        " (for another air model, give another --out)",
    )
    _add_guided(made)
    made.add_argument("--json", type=output_file, help="write the totals to this file")
    return made


def _add_guided(made: CommandLine) -> None:
    """Add the options of a guided search and its case files."""
    made.add_argument("--guided", action="store_true", help="search for the faults with the smallest margin")
    made.add_argument(
        "--bug-runs",
        type=whole_number(0),
        default=80,
        help="with --guided: runs of each search for each of the 20 seeded bugs; 0: no seeded bugs (default "
        "80)",
    )
    made.add_argument(
        "--case", type=Path, help="fly this case file again; of the other options only --out applies"
    )


if __name__ == "__main__":
    sys.exit(main())
