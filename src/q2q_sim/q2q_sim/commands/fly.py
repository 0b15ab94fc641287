"""Fly a scenario, waypoints or a plan through the nodes: `fly SCENARIO`."""

import argparse
import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.commands.argument_types import output_file, output_folder, whole_number
from q2q_model.commands.command_line import CommandLine, Work, given_options, run_command
from q2q_model.model_files.model_names import check_model_name
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, VEHICLES
from q2q_sim.air.air_names import check_air, flight_path
from q2q_sim.scenarios import scenario_files
from q2q_sim.scenarios.choices import (
    AIR_TERMS,
    DISTRIBUTED_TOPIC,
    REPLANNERS,
    TOPICS,
    WAKES,
    check_controller,
)

EXAMPLE = """  scripts/fly --list
  scripts/fly table6 --aware --lockstep --json out/table6.json
  scripts/fly table6_room --ignoring --seed 3 --bag out/room_3
  scripts/fly plan.json --vehicle crazyflie_2_1 --wake measured --model measured_law
  scripts/fly table6_room --air room --model moving_law
  scripts/fly table6_room --controller my_module:MyController
  scripts/fly --real dc19_swap_ss_02"""

OF_A_REPLAY = ("--real", "--model", "--json")
"""Options of a replayed recording."""


def main(argv: Sequence[str] | None = None) -> int:
    """Fly the scenario of the command line; return the exit status."""
    return run_command(parser(), _prepare, argv, interrupted="interrupted; all nodes are ended")


def _prepare(args: Namespace) -> Work:
    _check(args)
    if args.real:
        _check_replay(args)
    if not args.list:
        from q2q_sim.processes.fork_server import start_fork_server

        print(f"fly: {args.real or args.scenario}: starting", file=sys.stderr, flush=True)
        start_fork_server()  # it imports in parallel
    from q2q_sim.tools.fly_scenario import run

    return run


def _check(args: Namespace) -> None:
    """Raise ValueError for options that cannot be flown, alone or together."""
    if not (args.list or args.real or args.scenario):
        raise ValueError("give a scenario: `scripts/fly --list` names them")
    if args.real and args.scenario:
        raise ValueError(f"{args.scenario} and --real {args.real}: give one of them")
    if args.scenario:
        _check_flight(args)
    if args.air:
        check_air(args.air)
        if args.wake:
            raise ValueError(f"--wake {args.wake} and --air {args.air}: give one of them")
    if args.model:
        check_model_name(args.model)
    if args.bag and args.bag.exists():
        raise ValueError(f"bag {args.bag} exists: choose another folder or delete it")


def _check_flight(args: Namespace) -> None:
    """Raise ValueError for a scenario that cannot be flown, or not with the controller's options."""
    scenario_files.check(args.scenario)
    check_controller(args.controller, correct=args.correct, limit=args.limit)
    if args.distributed and args.controller != "mpc":
        raise ValueError(f"--distributed with --controller {args.controller}: give --controller mpc")
    if DISTRIBUTED_TOPIC in args.record and not args.distributed:
        raise ValueError(
            f"--record {DISTRIBUTED_TOPIC} without --distributed: give both, or record other topics"
        )
    if not (args.aware or args.limit):
        raise ValueError("--ignoring and --no-limit: a controller that ignores the downwash keeps the limit")


def _check_replay(args: Namespace) -> None:
    """Raise ValueError for options of a simulated flight, which a replay would ignore."""
    ignored = [option for option in given_options(args) if option not in OF_A_REPLAY]
    if ignored:
        raise ValueError(
            f"--real {args.real} and {', '.join(ignored)}: a replay takes only --model and --json; "
            "everything else is as recorded"
        )
    flight_path(args.real)


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("fly", __doc__, EXAMPLE)
    made.add_argument(
        "scenario",
        nargs="?",
        help="scenario name (see --list), or a file: scenario or waypoints (.yaml), plan (.json)",
    )
    made.add_argument("--list", action="store_true", help="list the scenarios")
    _add_blocks(made)
    _add_planning(made)
    _add_process(made)
    _add_physics(made)
    _add_output(made)
    return made


def _add_blocks(made: CommandLine) -> None:
    made.add_argument(
        "--controller", default="pid", help="controller: pid (default), mpc, or module:Class of your own"
    )
    made.add_argument(
        "--distributed",
        action="store_true",
        help="with --controller mpc: one MPC node for each vehicle; they exchange predictions",
    )
    _either(
        made,
        ("aware", "compensate the predicted downwash (default)"),
        ("ignoring", "do not compensate the downwash"),
        default=True,
    )
    made.add_argument(
        "--correct",
        action="store_true",
        help="correct the predicted downwash by measured positions and accelerometers",
    )
    _either(
        made,
        ("limit", "limit thrust as the scenario does (default)"),
        ("no-limit", "limit thrust only as the vehicle does"),
        default=True,
    )


def _add_planning(made: CommandLine) -> None:
    made.add_argument(
        "--replan",
        nargs="?",
        const="paper",
        default="none",
        choices=REPLANNERS,
        help="online replanner: none (default), the paper's potential field, or the safe replanner; without a"
        " value: paper",
    )
    made.add_argument(
        "--no-replan", dest="replan", action="store_const", const="none", help="no online replanner (default)"
    )
    made.add_argument(
        "--plan",
        default="none",
        choices=("none", "avoid"),
        help="avoid: plan trajectories around the downwash of the model; none (default): keep the waypoints",
    )


def _add_process(made: CommandLine) -> None:
    _either(
        made,
        ("live", "fly at 100 Hz of wall time"),
        ("lockstep", "fly as fast as commands arrive (default)"),
        default=False,
    )
    _either(
        made,
        ("stack", "run the nodes in one process (default with --lockstep: faster, with the same numbers)"),
        ("no-stack", "run each node in its own process (default with --live)"),
        default=None,
    )


def _add_physics(made: CommandLine) -> None:
    made.add_argument("--seed", type=whole_number(0), default=0, help="random seed")
    made.add_argument(
        "--model",
        default="",
        help="interaction model of the controller, in place of the file's: none, a shipped name, or a .q2q "
        "file",
    )
    made.add_argument(
        "--vehicle",
        default="",
        choices=tuple(VEHICLES),
        help=f"vehicle type, in place of the file's ({DEFAULT_VEHICLE} if the file names none)",
    )
    made.add_argument(
        "--wake",
        default="",
        choices=WAKES,
        help="simulated downwash, in place of the file's (none if the file names none)",
    )
    made.add_argument(
        "--air",
        default="",
        help="air model, in place of the file's wake and disturbance: a shipped name, a .air file, or "
        "module:Class",
    )
    made.add_argument(
        "--air-without",
        nargs="+",
        default=[],
        choices=AIR_TERMS,
        metavar="TERM",
        help="terms of the air model to switch off",
    )


def _add_output(made: CommandLine) -> None:
    made.add_argument(
        "--bag", type=output_folder, help="folder to write the bag to (default: no bag is kept)"
    )
    made.add_argument(
        "--record",
        nargs="+",
        default=[],
        choices=(*TOPICS, DISTRIBUTED_TOPIC),
        metavar="TOPIC",
        help="topics to record in addition to those that metrics and verdict need (default: all; without "
        "--bag: none)",
    )
    made.add_argument("--json", type=output_file, help="write the metrics to this file")
    made.add_argument(
        "--real",
        metavar="FLIGHT",
        help="replay a recorded flight of the folder Q2Q_DATA instead of a scenario; its figure is written to"
        " out/real",
    )


def _either(
    made: argparse.ArgumentParser, yes: tuple[str, str], no: tuple[str, str], *, default: bool | None
) -> None:
    """Add two options that exclude each other, each a name and its help."""
    group = made.add_mutually_exclusive_group()
    group.add_argument(f"--{yes[0]}", action="store_true", default=default, help=yes[1])
    group.add_argument(f"--{no[0]}", dest=yes[0], action="store_false", help=no[1])


if __name__ == "__main__":
    sys.exit(main())
