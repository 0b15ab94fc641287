"""Command line of one flight: `fly SCENARIO`."""

import argparse
import json
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from q2q_model.tools.command_line import CommandLine
from q2q_sim import scenarios
from q2q_sim.assembly import CONTROLLERS, REPLANNERS
from q2q_sim.tools.flight import MEASURED, FlightRequest, FlightRun, fly
from q2q_sim.tools.interruption import Interruption
from q2q_sim.tools.processes import NodeDiedError
from q2q_sim.tools.run_json import runs_json
from q2q_sim.tools.run_table import run_notes, run_table, run_verdicts

EXAMPLE = """  scripts/fly --list
  scripts/fly table6 --aware --lockstep --json out/table6.json
  scripts/fly table6_room --ignoring --seed 3 --bag out/room_3
  scripts/fly --real dc19_swap_ss_02"""


def main(arguments: list[str] | None = None) -> int:
    """Fly as the command line says; return the exit status."""
    asked = parser().parse_args(arguments)
    warn_plainly("fly")
    try:
        return _run(asked)
    except KeyboardInterrupt:
        print("fly: interrupted; all nodes are ended", file=sys.stderr)
        return 130
    except (ValueError, OSError, NodeDiedError, TimeoutError) as refusal:
        print(f"fly: {refusal}", file=sys.stderr)
        return 1


def parser() -> CommandLine:
    """Return the parser of the command line."""
    made = CommandLine("fly", __doc__, EXAMPLE)
    made.add_argument("scenario", nargs="?", help="scenario name or YAML file; see --list")
    made.add_argument("--list", action="store_true", help="name the scenarios, one line each")
    made.add_argument("--controller", default="pid", choices=CONTROLLERS, help="who computes the commands")
    _either(made, "aware", "ignoring", "compensate the draft, or ignore it", default=True)
    _either(
        made, "limit", "no-limit", "hold the scenario's thrust limit, or only the vehicle's", default=True
    )
    made.add_argument(
        "--replan",
        nargs="?",
        const="paper",
        default="none",
        choices=REPLANNERS,
        help="law of the online replanner (--replan alone: paper)",
    )
    made.add_argument("--no-replan", dest="replan", action="store_const", const="none", help="--replan none")
    made.add_argument(
        "--plan",
        default="none",
        choices=("none", "avoid"),
        help="plan ahead around the model's draft, or not",
    )
    _either(made, "live", "lockstep", "100 Hz of wall time, or as fast as the commands come", default=False)
    made.add_argument(
        "--stack", action="store_true", help="run filter, model, planner and controller in one process"
    )
    made.add_argument("--seed", type=int, default=0, help="seed of everything random")
    made.add_argument("--model", default="", help="interaction model: none, a shipped name, or a .q2q file")
    made.add_argument("--bag", type=Path, help="folder for the bag (default: not kept)")
    made.add_argument(
        "--record",
        nargs="+",
        default=[],
        metavar="TOPIC",
        help="topics for the bag (default: all; without --bag what the numbers need)",
    )
    made.add_argument("--json", type=Path, help="write the numbers to this file")
    made.add_argument("--real", metavar="FLIGHT", help="play a recorded flight of Q2Q_DATA instead")
    return made


def _either(made: argparse.ArgumentParser, yes: str, no: str, words: str, *, default: bool) -> None:
    group = made.add_mutually_exclusive_group()
    name = yes.replace("-", "_")
    group.add_argument(f"--{yes}", dest=name, action="store_true", default=default, help=words)
    group.add_argument(f"--{no}", dest=name, action="store_false", help=f"not --{yes}")


def _run(asked: argparse.Namespace) -> int:
    if asked.list:
        for name in scenarios.names():
            print(f"{name:14} {scenarios.describe(name)}")
        return 0
    if asked.real:
        from q2q_sim.tools.real import fly_real

        return fly_real(asked.real, asked.model, asked.json)
    if not asked.scenario:
        raise ValueError("give a scenario: `scripts/fly --list` names them")
    run = _fly(asked)
    show([run])
    if asked.json:
        asked.json.parent.mkdir(parents=True, exist_ok=True)
        asked.json.write_text(json.dumps(runs_json([run]), indent=1) + "\n")
    return conclude([run])


def conclude(runs: Sequence[FlightRun]) -> int:
    """Print the verdict on some flights as the last line; return the exit status, 1 where one is not ok."""
    print(run_verdicts(runs))
    return int(not all(run.verdict.ok for run in runs))


def show(runs: Sequence[FlightRun]) -> None:
    """Print the table of some flights, and their timing."""
    console = Console()
    console.print(run_table(runs))
    for note in run_notes(runs):
        console.print(note, highlight=False)


def request_of(asked: argparse.Namespace) -> FlightRequest:
    """Return what the command line asks for."""
    mode = "ignoring" if not asked.aware else "aware" if asked.limit else "aware_unlimited"
    return FlightRequest(
        scenario=asked.scenario,
        mode=mode,
        controller=asked.controller,
        replan=asked.replan,
        plan=asked.plan,
        live=asked.live,
        stack=asked.stack,
        seed=asked.seed,
        model=asked.model,
        record=tuple(asked.record) or (() if asked.bag else MEASURED),
    )


def _fly(asked: argparse.Namespace) -> FlightRun:
    request = request_of(asked)
    interruption = Interruption()
    with tempfile.TemporaryDirectory(prefix="q2q-fly-") as scratch:
        bag = asked.bag or Path(scratch) / "bag"
        return fly_with_progress(request, Path(scratch) / "nodes", bag, interruption)


def fly_with_progress(
    request: FlightRequest, folder: Path, bag: Path, interruption: Interruption
) -> FlightRun:
    """Fly with a progress bar on the terminal; a signal ends the flight."""
    columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(f"{request.scenario} {request.mode}", total=1.0)

        def follow(share: float) -> None:
            interruption.check()
            bar.update(task, completed=share)

        run = fly(request, folder, bag, follow)
        bar.update(task, completed=1.0)
    return run


def warn_plainly(program: str) -> None:
    """Let warnings be one line each, without the place in the code."""
    warnings.formatwarning = lambda message, *_, **__: f"{program}: warning: {message}\n"


if __name__ == "__main__":
    sys.exit(main())
