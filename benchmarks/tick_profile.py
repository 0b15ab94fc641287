"""Draw where the time of a flight's ticks goes, as a flame graph: processes, stack, or without ROS.

The flight is sampled by py-spy (`pip install py-spy`), which needs the right to trace processes of its own
user. Start-up is left out: only stacks within the loop of the flight count. Functions of compiled libraries
count as the Python function that calls them.
"""

import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

from q2q_model.commands.command_line import CommandLine, run_command
from q2q_model.documents.written_file import write_text

EXAMPLE = "  python benchmarks/tick_profile.py stack --out out/stack.svg"
RATE = 500
"""Samples a second."""
SHOWN = 12
"""Functions printed."""
FLY = (sys.executable, "-m", "q2q_sim.commands.fly")


@dataclass(frozen=True, slots=True)
class Way:
    """Way to fly a scenario."""

    command: tuple[str, ...]
    """The scenario's name follows."""
    root: str
    """Function within which the flight's ticks are."""


WAYS = {
    "pure": Way((sys.executable, __file__, "--fly-pure"), "_fly_measured"),
    "stack": Way((*FLY, "--stack"), "_spin"),
    "processes": Way((*FLY, "--no-stack"), "_spin"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Sample a flight, draw it, print its busiest functions; return the exit status."""
    return run_command(_parser(), lambda _: _run, arguments)


def _run(args: Namespace) -> int:
    if args.fly_pure:
        return _fly_pure(args.way)
    if args.way not in WAYS or args.out is None:
        print(f"tick_profile: give one of {', '.join(WAYS)}, and --out FILE", file=sys.stderr)
        return 2
    if which("py-spy") is None:
        print("tick_profile: py-spy is not installed; run: pip install py-spy", file=sys.stderr)
        return 1
    return _profile(args.way, args.scenario, args.out)


def _parser() -> CommandLine:
    made = CommandLine("tick_profile", __doc__, EXAMPLE)
    made.add_argument("way", help=f"one of {', '.join(WAYS)}")
    made.add_argument("--scenario", default="swarm10", help="scenario to fly (default: swarm10)")
    made.add_argument("--out", type=Path, metavar="FILE", help="SVG file to write")
    made.add_argument("--fly-pure", action="store_true", help="fly the scenario WAY without ROS, for py-spy")
    return made


def _profile(way: str, scenario: str, out: Path) -> int:
    from flame_graph.drawing import flame_graph
    from flame_graph.frame_tree import busiest, frame_tree

    with TemporaryDirectory() as folder:
        folded = Path(folder) / "stacks.txt"
        record = ["py-spy", "record", "-f", "raw", "-r", str(RATE), "-s", "-F", "-o", str(folded), "--"]
        done = subprocess.run([*record, *WAYS[way].command, scenario], check=False, stdout=subprocess.DEVNULL)
        if done.returncode or not folded.is_file():
            print(f"tick_profile: the flight ended with {done.returncode}", file=sys.stderr)
            return 1
        try:
            tree = frame_tree(folded.read_text().splitlines(), WAYS[way].root)
        except ValueError as empty:
            print(f"tick_profile: {empty}", file=sys.stderr)
            return 1
    write_text(flame_graph(tree, f"{scenario}, {way}: {tree.samples} samples"), out)
    for name, share in busiest(tree)[:SHOWN]:
        print(f"{100 * share:5.1f} %  {name}")
    print(f"flame graph: {out}")
    return 0


def _fly_pure(name: str) -> int:
    from q2q_model.model_files.find_model import find_model
    from q2q_sim.loop.closed_loop import FlightOptions, fly
    from q2q_sim.scenarios import library

    scenario = library.load(name)
    options = FlightOptions(mode="aware", model=find_model(scenario.model).interaction)
    fly(scenario, options)  # loads the compiled loops
    _fly_measured(lambda: fly(scenario, options))
    return 0


def _fly_measured(flight: Callable[[], object]) -> None:
    """Fly the flight whose stacks count."""
    flight()


if __name__ == "__main__":
    sys.exit(main())
