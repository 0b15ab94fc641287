"""Learn gains, interference zone and interaction model from recorded flights."""

import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from threadpoolctl import threadpool_limits

from q2q_model.bag import BagError
from q2q_model.identification.procedure import Identification, ProcedureParams, identify
from q2q_model.model_file import save
from q2q_model.plain_values import Plain, PlainValueError, to_plain
from q2q_model.tools.command_line import CommandLine, without_ros
from q2q_model.tools.identify_report import report, summary
from q2q_model.tools.models import find_model
from q2q_model.tools.recordings import read_recordings, topic_map
from q2q_model.vehicle import VEHICLES, Vehicle, vehicle_by_name

EXAMPLE = """  ros2 run q2q_model identify bags/table2_* --out model.q2q --json report.json
  ros2 run q2q_model identify flight1 flight2 --out model.q2q --model-type jet
  ros2 run q2q_model identify room/* --topics room.yaml --out model.q2q
  ros2 run q2q_model identify --live --model model.q2q --out refined.q2q"""
STEPS = 12
"""Steps of a run with all candidates; the bar is a guide, not a promise."""


def main(arguments: list[str] | None = None) -> int:
    """Identify as the command line says; return 0, or 1 after an error."""
    parser = _command_line()
    given = parser.parse_args(without_ros(arguments))
    if bool(given.bags) == given.live:
        parser.error("give bags of recorded flights, or --live with --model, not both")
    console = Console(stderr=True)
    try:
        if given.live:
            return _refine_live(given.model, vehicle_by_name(given.vehicle), given.out)
        with threadpool_limits(1, user_api="blas"):  # the matrices are small: more threads only wait
            found, seconds = _run(given.bags, given.topics, _params(given), console)
        save(given.out, found.file)
        wanted = given.json or given.out.with_suffix(".json")
        wanted.write_text(json.dumps(_as_json(found, seconds), indent=1) + "\n")
        pictures = [] if given.no_plots else _draw(found, wanted.with_suffix(""))
    except (BagError, ValueError, OSError) as wrong:
        print(f"identify: {wrong}", file=sys.stderr)
        return 1
    print(summary(found))
    print(f"model: {given.out}\nreport: {wanted}")
    for picture in pictures:
        print(f"plot: {picture}")
    return 0


def _command_line() -> CommandLine:
    parser = CommandLine("identify", __doc__, EXAMPLE)
    parser.add_argument("bags", nargs="*", type=Path, metavar="BAG", help="recorded flights")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="model file to write (.q2q)")
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="report to write; default: beside the model"
    )
    parser.add_argument(
        "--model-type",
        default="auto",
        choices=("auto", "jet", "envelope_network"),
        help="auto picks by held-out error",
    )
    parser.add_argument("--topics", type=Path, metavar="MAP.yaml", help="topics of bags that are not q2q's")
    parser.add_argument("--vehicle", default="crazyflie_2_0", choices=tuple(VEHICLES), help="whose mass")
    parser.add_argument(
        "--threshold", type=float, default=0.1, help="|eta| at the learned zone's edge [m/s^2]"
    )
    parser.add_argument("--live", action="store_true", help="refine --model from topics until interrupted")
    parser.add_argument("--model", default="paper_law", help="model that --live begins with")
    parser.add_argument("--no-plots", action="store_true", help="draw nothing")
    return parser


def _refine_live(model: str, vehicle: Vehicle, out: Path) -> int:
    base = find_model(model)
    from q2q_model.ros.live_identification import refine_live  # needs a sourced ROS, which bags do not

    refine_live(base, vehicle, out)
    print(f"model: {out}")
    return 0


def _params(given: object) -> ProcedureParams:
    values = vars(given)
    return ProcedureParams(
        model_type=values["model_type"],
        threshold=values["threshold"],
        vehicle=vehicle_by_name(values["vehicle"]),
    )


@dataclass(slots=True)
class _Steps:
    """Hold how long each step took, on the bar and for the report."""

    progress: Progress
    seconds: dict[str, float] = field(default_factory=dict)
    began: float = field(default_factory=time.process_time)
    name: str = ""

    def tell(self, name: str) -> None:
        """Begin a step."""
        self._close()
        self.name, self.began = name, time.process_time()
        for task in self.progress.task_ids:
            self.progress.update(task, description=name, advance=1)

    def _close(self) -> None:
        if self.name:
            self.seconds[self.name] = time.process_time() - self.began

    def finish(self) -> dict[str, float]:
        """Return the CPU seconds of every step."""
        self._close()
        return self.seconds


def _run(
    bags: Sequence[Path], topics: Path | None, params: ProcedureParams, console: Console
) -> tuple[Identification, dict[str, float]]:
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        progress.add_task("read", total=STEPS)
        steps = _Steps(progress)
        steps.tell("read")
        recordings, repairs = read_recordings(bags, topic_map(topics))
        for repair in repairs:
            progress.console.print(f"identify: mended: {repair}", highlight=False)
        found = identify(recordings, params, steps.tell)
        return found, steps.finish()


def _as_json(found: Identification, seconds: dict[str, float]) -> Plain:
    try:
        return to_plain(report(found, seconds))
    except PlainValueError as wrong:
        raise ValueError(f"the report holds a number that is none: {wrong}") from wrong


def _draw(found: Identification, folder: Path) -> list[Path]:
    from q2q_model.tools.identify_figures import draw_all

    return draw_all(found, folder)


if __name__ == "__main__":
    sys.exit(main())
