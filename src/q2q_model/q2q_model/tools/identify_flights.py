"""Identification of a model from recorded flights, with progress bar, report and plots."""

import sys
from argparse import Namespace
from dataclasses import dataclass, field
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from threadpoolctl import threadpool_limits

from q2q_model.documents.json_file import write_json
from q2q_model.documents.plain_values import Plain, PlainValueError, to_plain
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.flights.units_and_frames.frame_notes import axis_notes
from q2q_model.identification.identification import Identification, ProcedureParams, identify
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import save
from q2q_model.plain_console import plain_console
from q2q_model.recordings.bag_vehicle import common_vehicle
from q2q_model.recordings.recordings_of_bags import bags_among, recordings_of_bags, topic_map
from q2q_model.tools.identify_report import report, summary
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, Vehicle, vehicle_by_name

STEPS = 14
"""Steps of a run with all candidates, for the progress bar."""


def run(args: Namespace) -> int:
    """Identify a model, write and print the results, and return the exit status."""
    if args.live:
        return _refine_online(args.model, args.vehicle, args.out)
    with threadpool_limits(1, user_api="blas"):  # more threads are slower on small matrices
        found, seconds = _run(args, plain_console(stderr=True))
    report_file = args.json or args.out.with_suffix(".json")
    write_json(_as_json(found, seconds), report_file)  # first: it says why a model is refused
    save(args.out, found.file)
    pictures = [] if args.no_plots else _draw(found, report_file.with_suffix(""))
    print(summary(found))
    print(f"model: {args.out}\nreport: {report_file}")
    for picture in pictures:
        print(f"plot: {picture}")
    return 0


def _refine_online(model: str, vehicle: str, out: Path) -> int:
    base, flown = find_model(model), vehicle_by_name(vehicle or DEFAULT_VEHICLE)
    if base.interaction == NoInteraction():
        raise ValueError(f"--model {model} has no downwash for --live to scale: give another model")
    if not vehicle:
        print(f"identify: {flown.name} is assumed to fly; name the vehicle with --vehicle", file=sys.stderr)
    # needs a sourced ROS, which reading bags does not
    from q2q_model.ros.online_identification import refine_online

    if reason := refine_online(base, flown, out):
        print(f"identify: {out} is not written: {reason}", file=sys.stderr)
        return 1
    print(f"model: {out}")
    return 0


def _params(args: Namespace, vehicle: Vehicle) -> ProcedureParams:
    return ProcedureParams(model_type=args.model_type, threshold=args.threshold, vehicle=vehicle)


def _cpu_time() -> float:
    """Return the CPU time of this process and of its children that have ended [s]."""
    used = (getrusage(RUSAGE_SELF), getrusage(RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


@dataclass(slots=True)
class _Steps:
    """Duration of each step, for the progress bar and the report."""

    progress: Progress
    seconds: dict[str, float] = field(default_factory=dict)
    began: float = field(default_factory=_cpu_time)
    name: str = ""

    def begin(self, name: str) -> None:
        """Begin a step."""
        self._close()
        self.name, self.began = name, _cpu_time()
        for task in self.progress.task_ids:
            self.progress.update(task, description=name, advance=1, refresh=True)

    def _close(self) -> None:
        if self.name:
            self.seconds[self.name] = _cpu_time() - self.began

    def finish(self) -> dict[str, float]:
        """Return the CPU seconds of every step."""
        self._close()
        return self.seconds


def _run(args: Namespace, console: Console) -> tuple[Identification, dict[str, float]]:
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, auto_refresh=False) as progress:  # no thread
        progress.add_task("read", total=STEPS)
        steps = _Steps(progress)
        steps.begin("read")
        kept, left_out = bags_among(args.bags)
        flown = common_vehicle(kept, args.vehicle)
        recordings, repairs = recordings_of_bags(kept, topic_map(args.topics))
        doubts = [note for one in recordings for note in axis_notes(one.flight)]
        repaired = (f"repaired: {repair}" for repair in repairs)
        notes = [*doubts, *repaired, *left_out, *filter(None, [flown.note])]
        for note in notes:  # first: an error may follow from them
            progress.console.print(f"identify: {note}", soft_wrap=True)
        return identify(recordings, _params(args, flown.vehicle), steps.begin), steps.finish()


def _as_json(found: Identification, seconds: dict[str, float]) -> Plain:
    try:
        return to_plain(report(found, seconds))
    except PlainValueError as wrong:
        raise ValueError(f"the report contains a value that JSON cannot express: {wrong}") from wrong


def _draw(found: Identification, folder: Path) -> list[Path]:
    from q2q_model.tools.identify_figures import draw_all

    return draw_all(found, folder)
