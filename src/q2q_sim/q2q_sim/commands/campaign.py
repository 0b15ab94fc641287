"""Fly random faults in random scenarios and check every flight: `campaign --runs N`.

A run is a seed. Finished runs are kept in a file of JSON lines, from which an interrupted campaign resumes;
a violation prints its seed and keeps its bag and scenario. The exit status is 1 if any policy is violated.
"""

import argparse
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from q2q_model.commands.command_line import CommandLine, Work, run_command
from q2q_sim.air.air_names import check_air
from q2q_sim.scenarios.choices import ENGINES

EXAMPLE = """  scripts/campaign --runs 20
  scripts/campaign --runs 2000 --jobs 2 --through-nodes 200 --json out/campaign.json
  DASK_SCHEDULER_ADDRESS=tcp://host:8786 scripts/campaign --runs 20000 --engine dask"""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly the campaign of the command line; return the exit status."""
    return run_command(
        parser(), _prepare, argv, interrupted="interrupted; run the same command to resume", refused=2
    )


def _prepare(args: Namespace) -> Work:
    if args.through_nodes > args.runs:
        raise ValueError(f"--through-nodes {args.through_nodes}: at most the {args.runs} --runs")
    if args.air:
        check_air(args.air)
    from q2q_sim.experiments.campaign.resume import run

    return run


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("campaign", __doc__, EXAMPLE)
    made.add_argument("--runs", type=_count, default=20, help="number of runs (default 20)")
    made.add_argument("--jobs", type=_count, default=1, help="number of parallel runs (default 1)")
    made.add_argument(
        "--through-nodes", type=_count, default=0, help="number of runs through the real nodes, in lockstep"
    )
    made.add_argument("--seed", type=_count, default=0, help="seed of the first run; the others follow it")
    made.add_argument("--engine", choices=ENGINES, default="local", help="engine of parallel runs")
    made.add_argument("--out", type=Path, default=Path("out/campaign"), help="folder of runs and bags")
    made.add_argument(
        "--air",
        default="",
        help="air in place of wake and disturbance: a shipped name, a .air file or module:Class"
        " (runs of another air need another --out)",
    )
    made.add_argument("--json", type=Path, help="write the totals to this file")
    return made


def _count(text: str) -> int:
    count = int(text) if text.isdigit() else -1
    if count < 0:
        raise argparse.ArgumentTypeError(f"{text}: a whole number, 0 or above")
    return count


if __name__ == "__main__":
    sys.exit(main())
