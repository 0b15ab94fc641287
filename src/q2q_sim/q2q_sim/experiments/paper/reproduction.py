"""Reproduction of every table and figure of the paper with the project's own flights, next to its numbers.

Finished experiments are cached in OUT/cache and not run again until the code changes; interrupted runs
resume.
"""

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from q2q_model.documents.json_file import text_stream, write_json
from q2q_sim.experiments.paper import learning_tables, planning_tables, tracking_tables
from q2q_sim.experiments.paper.experiment_cache import PaperCache, fingerprint
from q2q_sim.experiments.paper.experiment_outcome import Experiment, ExperimentOutcome
from q2q_sim.experiments.paper.paper_numbers import PaperNumber, paper_numbers, select_numbers
from q2q_sim.experiments.paper.paper_page import as_json, write_page, write_pdf

EXPERIMENTS = (
    Experiment("vehicle", ("table1",), 0.1, learning_tables.vehicle),
    Experiment("pid", ("table6", "table7", "fig14"), 36.0, tracking_tables.pid),
    Experiment("planning", ("table5", "fig10", "fig11"), 35.0, planning_tables.planning),
    Experiment("replanning", ("fig12", "fig13"), 15.0, planning_tables.replanning),
    Experiment(
        "learning",
        ("table2", "table3", "table4", "fig4", "fig5", "fig6", "fig7", "fig8", "fig9"),
        90.0,
        learning_tables.learning,
    ),
    Experiment("mpc", ("table7", "fig15"), 70.0, tracking_tables.mpc),
)
"""In the order of execution: quick ones first."""


def run(args: Namespace) -> int:
    """Reproduce the requested tables and figures; return the exit status."""
    return _reproduce(select_numbers(paper_numbers(), args.only), args.out, args.json, again=args.again)


def needed_experiments(numbers: Sequence[PaperNumber]) -> list[Experiment]:
    """Return the experiments behind any of these numbers."""
    groups = {one.group for one in numbers}
    return [one for one in EXPERIMENTS if groups & set(one.groups)]


def _reproduce(numbers: Sequence[PaperNumber], out: Path, json_file: Path | None, *, again: bool) -> int:
    cache = PaperCache(out, fingerprint())
    outcomes = run_all(needed_experiments(numbers), cache, again=again)
    write_page(numbers, outcomes, out)
    write_pdf(numbers, outcomes, out)
    if json_file:
        write_json(as_json(numbers, outcomes), json_file)
    print(f"paper: {out / 'index.html'}, {out / 'paper.pdf'}", file=text_stream(json_file))
    return 0


def run_all(experiments: Sequence[Experiment], cache: PaperCache, *, again: bool) -> list[ExperimentOutcome]:
    """Return the outcome of every experiment, cached if finished, with a progress bar."""
    columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    outcomes = []
    with Progress(*columns, console=Console(stderr=True), speed_estimate_period=3600.0) as bar:
        task = bar.add_task("paper", total=sum(one.seconds for one in experiments))
        for one in experiments:
            bar.update(task, description=one.name)
            found = None if again else cache.load(one.name)
            if found is None:
                found = one.run(cache.folder(one.name))
                cache.save(one.name, found)
            outcomes.append(found)
            bar.advance(task, one.seconds)
    return outcomes
