"""Missing flights of the ablation, and its page."""

import shlex
from argparse import Namespace
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from q2q_sim.experiments.ablation.ablation_cases import CASES, Case
from q2q_sim.experiments.ablation.ablation_numbers import Numbers, key, read
from q2q_sim.experiments.ablation.ablation_plot import ablation_figure
from q2q_sim.experiments.ablation.ablation_table import SHOWN, page
from q2q_sim.experiments.ablation.contender_flight import ContenderFlight, fly_contender
from q2q_sim.experiments.ablation.contenders import CONTENDERS
from q2q_sim.experiments.ablation.learned_models import air_of, models_of
from q2q_sim.scenarios.choices import TABLE_ONLY

DPI = 130


def run(given: Namespace) -> int:
    """Fly what is missing, write page and plot; return the exit status."""
    if not 1 <= given.seeds <= 25 or given.jobs < 1:
        raise ValueError(f"seeds = {given.seeds}, jobs = {given.jobs}: 1 to 25 seeds, 1 job or more")
    unknown = sorted(set(given.only or ()) - {case.scenario for case in CASES})
    if unknown:
        known = ", ".join(sorted({case.scenario for case in CASES}))
        raise ValueError(f"--only {' '.join(unknown)}: choose some of {known}")
    numbers = read(given.json, given.seeds)
    if not given.table_only:
        _fill(numbers, [case for case in CASES if not given.only or case.scenario in given.only], given)
    words = [word for word in given.argv if word != TABLE_ONLY]
    write(numbers, given.out, f"ros2 run q2q_sim ablation {shlex.join(words)}")
    print(f"page: {given.out}\nnumbers: {given.json}")
    return 0


def write(numbers: Numbers, out: Path, command: str) -> None:
    """Write the page and, in `images` beside it, its plot."""
    picture = Path("images") / f"{out.stem}.png"
    (out.parent / picture.parent).mkdir(parents=True, exist_ok=True)
    ablation_figure(numbers, SHOWN).savefig(out.parent / picture, dpi=DPI)
    out.write_text(page(numbers, command, picture.as_posix()), encoding="utf-8")


def _fill(numbers: Numbers, wanted: Sequence[Case], given: Namespace) -> None:
    """Learn missing models, fly missing flights and save the numbers after each."""
    pool = ProcessPoolExecutor(given.jobs, mp_context=get_context("spawn"))
    bar = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with pool, Progress(*bar, console=Console(stderr=True)) as progress:
        asked = _missing(numbers, wanted)
        numbers.save(given.json)
        task = progress.add_task("flights", total=len(asked))
        flights = {pool.submit(fly_contender, one): one for one in asked}
        try:
            for done in as_completed(flights):
                one = flights[done]
                numbers.flights.setdefault(key(one.case, one.contender), {})[one.seed] = done.result()
                numbers.save(given.json)
                progress.advance(task)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _missing(numbers: Numbers, wanted: Sequence[Case]) -> list[ContenderFlight]:
    """Return the missing flights, and learn models and airs for them; a model's number is its seed."""
    asked = []
    for case in wanted:
        plant = case.plant
        if plant.models not in numbers.models:
            numbers.models[plant.models] = models_of(plant.models)
        models = numbers.models_for(plant)
        cells = {name: numbers.flights.get(key(case, name), {}) for name in CONTENDERS}
        left = [(k, name) for k in range(len(models)) for name in CONTENDERS if k not in cells[name]]
        if left:
            air = air_of(plant)
            numbers.airs[plant.air] = list(air.flights)
            asked += [ContenderFlight(case, name, models[k].jet, air, k, numbers.draws) for k, name in left]
    return asked
