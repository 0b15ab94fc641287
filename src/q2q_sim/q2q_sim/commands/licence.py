"""Test an unmodified program for Crazyflies: fly it with emulated vehicles, without and with injected faults.

The program uses cflib, or crazyflie_py of Crazyswarm2, which is replaced by a substitute of the same
interface. Every URI that it opens is an emulated vehicle that stands on the floor. It must fly and end safely
without faults, then in one flight for each fault: radio, motion capture, battery, arming, downwash.

The exit status is 0 if every flight passes, 1 if one fails, and 2 if the command line is wrong or if no
flight fails but the simulator failed in one. Options of the program come after `--`.
"""

import math
import sys
from argparse import Namespace
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from q2q_model.commands.argument_paths import require_existing
from q2q_model.commands.argument_types import finite_number, output_file, output_folder, whole_number
from q2q_model.commands.command_line import CommandLine, UsageError, Work, given_options, run_command
from q2q_model.commands.ros_arguments import outside_ros

EXAMPLE = """  scripts/licence my_flight.py --out out/licence
  scripts/licence pair.py --start 0 -0.5 0 --start 0 0.5 90 --junit licence.xml -- --speed 0.5
  scripts/licence swarm.py --crazyflies crazyflies.yaml
  scripts/licence --score test/licence_scripts --json out/score.json"""
MOST_JOBS = 64
MOST_SCANNED = 15
"""Vehicles of one radio."""
OF_ONE = (
    "--start",
    "--scan",
    "--crazyflies",
    "--arming",
    "--room",
    "--air",
    "--limit",
    "--out",
    "--junit",
)
"""Options of the licence of one program; those of a score have theirs from its folder."""


def main(argv: Sequence[str] | None = None) -> int:
    """Judge the program of the command line; return the exit status."""
    own, after_dashes = _split(outside_ros(argv))
    return run_command(parser(), partial(_prepare, after_dashes), own, refused=2)


def _split(words: list[str]) -> tuple[list[str], list[str]]:
    """Return the words before and after the first `--`.

    argparse ends SCRIPT and ARGUMENT at the first option, so that it would refuse what follows a later `--`.
    """
    end = words.index("--") if "--" in words else len(words)
    return words[:end], words[end + 1 :]


def _add_words(args: Namespace, after_dashes: list[str]) -> None:
    """Append the words after `--` to those of the program."""
    words = [*([args.script] if args.script else []), *args.arguments, *after_dashes]
    args.script, args.arguments = (Path(words[0]), words[1:]) if words else (None, [])


def _prepare(after_dashes: list[str], args: Namespace) -> Work:
    _add_words(args, after_dashes)
    if bool(args.script) == bool(args.score):
        raise UsageError("give either a program or --score FOLDER")
    _check_partners(args)
    if not all(0.0 < size < math.inf for size in args.room):
        raise ValueError(f"--room {args.room}; sizes must be above 0 m")
    if not 0.0 < args.limit <= 3000.0:
        raise ValueError(f"--limit {args.limit}; must be in (0, 3000] s")
    require_existing("file", args.crazyflies)
    require_existing("program", args.script)
    require_existing("folder", args.score)
    if args.script and args.script.is_dir() and not (args.script / "__main__.py").exists():
        raise UsageError(
            f"{args.script} is a folder without __main__.py: give a program, or --score {args.script}"
        )
    from q2q_sim.licence.licence_command import judge_program, score_programs

    return judge_program if args.script else score_programs


def _check_partners(args: Namespace) -> None:
    """Raise UsageError for an option that would change nothing, with or without --score."""
    if not args.score:
        if args.only:
            raise UsageError("--only needs --score")
        return
    for option in given_options(args):
        if option in OF_ONE:
            raise UsageError(
                f"{option} applies to one program, but --score judges a folder: give one of them"
            )


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("licence", __doc__, EXAMPLE)
    made.add_argument("script", nargs="?", type=Path, metavar="SCRIPT", help="Python file of the program")
    made.add_argument("arguments", nargs="*", metavar="ARGUMENT", help="arguments of the program, after --")
    _add_vehicles(made)
    made.add_argument(
        "--room",
        nargs=3,
        type=float,
        default=[6.0, 6.0, 2.5],
        metavar=("X", "Y", "Z"),
        help="size of the room [m], whose floor is centred on the origin (default 6 6 2.5)",
    )
    made.add_argument("--air", default="room", help="air model of the flights (default room)")
    made.add_argument(
        "--limit", type=float, default=300.0, metavar="S", help="time limit of a flight [s] (default 300)"
    )
    made.add_argument("--seed", type=whole_number(0), default=0, help="random seed")
    made.add_argument(
        "--jobs",
        type=whole_number(1, MOST_JOBS),
        default=2,
        metavar="N",
        help="number of parallel flights (default 2)",
    )
    made.add_argument("--out", type=output_folder, metavar="FOLDER", help="folder to write the page to")
    made.add_argument("--junit", type=output_file, metavar="FILE", help="file to write JUnit XML to")
    made.add_argument("--json", type=output_file, metavar="FILE", help="file to write the findings to")
    made.add_argument(
        "--score",
        type=Path,
        metavar="FOLDER",
        help="test all programs of a folder, whose bugs are known, instead of SCRIPT",
    )
    made.add_argument(
        "--only", nargs="+", default=[], metavar="NAME", help="with --score: test only these programs"
    )
    return made


def _add_vehicles(made: CommandLine) -> None:
    """Add the options that say which vehicles there are."""
    made.add_argument(
        "--start",
        nargs=3,
        action="append",
        default=[],
        type=finite_number,
        metavar=("X", "Y", "YAW"),
        help="start position and yaw of a vehicle [m, deg]; repeat it for each, ordered by URI; default: rows"
        " along y, "
        "1 m apart",
    )
    made.add_argument(
        "--scan",
        type=whole_number(0, MOST_SCANNED),
        default=0,
        metavar="N",
        help="number of vehicles that a scan of the program finds, or that Crazyswarm2 has without "
        "--crazyflies "
        "(default: one for each --start)",
    )
    made.add_argument(
        "--crazyflies",
        type=Path,
        metavar="FILE",
        help="crazyflies.yaml of Crazyswarm2: names, URIs, starts and parameters of the vehicles",
    )
    made.add_argument(
        "--arming", action="store_true", help="vehicles do not arm themselves: the program must arm them"
    )


if __name__ == "__main__":
    sys.exit(main())
