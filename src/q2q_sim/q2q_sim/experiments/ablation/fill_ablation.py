"""Missing flights of the ablation, and its page."""

import shlex
from argparse import Namespace
from collections.abc import Sequence
from concurrent.futures import as_completed
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from q2q_model.documents.written_file import write_text
from q2q_sim.air.lookup.find_air import FlownAir, find_air
from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.ablation.ablation_cases import CASES, Case
from q2q_sim.experiments.ablation.ablation_numbers import Numbers, cell_name, read_numbers
from q2q_sim.experiments.ablation.ablation_plot import ablation_figure
from q2q_sim.experiments.ablation.ablation_table import ablation_page
from q2q_sim.experiments.ablation.learned_models import models_of
from q2q_sim.experiments.ablation.variant_flight import VariantFlight, fly_variant
from q2q_sim.experiments.ablation.variants import NAMES
from q2q_sim.processes.resume_log import exclusive_file
from q2q_sim.processes.worker_pool import worker_pool
from q2q_sim.scenarios.choices import TABLE_ONLY

DPI = 160


def run(given: Namespace) -> int:
    """Fly what is missing, write page and plot; return the exit status."""
    wanted = [(case, name) for case in CASES for name in NAMES if _is_wanted(given, case, name)]
    numbers = read_numbers(given.json, given.draws) if given.table_only else _filled(wanted, given)
    if not numbers.flights:
        raise ValueError(f"{given.json} holds no flights: leave out {TABLE_ONLY}")
    words = [word for word in given.argv if word != TABLE_ONLY]
    write(numbers, given.out, f"ros2 run q2q_sim ablation {shlex.join(words)}")
    print(f"page: {given.out}\nnumbers: {given.json}")
    return 0


def write(numbers: Numbers, out: Path, command: str) -> None:
    """Write the page and, in `images` next to it, its plot."""
    picture = Path("images") / f"{out.stem}.png"
    (out.parent / picture.parent).mkdir(parents=True, exist_ok=True)
    ablation_figure(numbers).savefig(out.parent / picture, dpi=DPI)
    write_text(ablation_page(numbers, command, picture.as_posix()), out)


def _is_wanted(given: Namespace, case: Case, variant: str) -> bool:
    """Return whether a flight is among the chosen ones.

    Raises:
        ValueError: an option names something that is not flown.
    """
    airs = sorted({one.plant.air for one in CASES})
    chosen = True
    for option, value, known in (
        ("only", case.name, sorted({one.name for one in CASES})),
        ("airs", case.plant.air, airs),
        ("controllers", variant, list(NAMES)),
    ):
        asked = getattr(given, option) or known
        unknown = sorted(set(asked) - set(known))
        if unknown:
            raise ValueError(f"--{option} {' '.join(unknown)}: choose some of {', '.join(known)}")
        chosen = chosen and value in asked
    return chosen


def _filled(wanted: Sequence[tuple[Case, str]], given: Namespace) -> Numbers:
    """Return the numbers in the file and those of missing flights, which are added to it."""
    with exclusive_file(given.json):
        numbers = read_numbers(given.json, given.draws)
        _fill(numbers, wanted, given)
    return numbers


def _fill(numbers: Numbers, wanted: Sequence[tuple[Case, str]], given: Namespace) -> None:
    """Learn missing models, fly missing flights and save the numbers after each."""
    pool = worker_pool(given.jobs)
    bar = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with pool, Progress(*bar, console=Console(stderr=True)) as progress:
        asked = _missing(numbers, wanted)
        numbers.save(given.json)
        task = progress.add_task("flights", total=len(asked))
        flights = {pool.submit(fly_variant, one): one for one in asked}
        try:
            for done in as_completed(flights):
                one = flights[done]
                numbers.flights[cell_name(one.case, one.variant)] = done.result()
                numbers.save(given.json)
                progress.advance(task)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _missing(numbers: Numbers, wanted: Sequence[tuple[Case, str]]) -> list[VariantFlight]:
    """Return the missing flights, and learn models and airs for them."""
    left = [(case, name) for case, name in wanted if cell_name(case, name) not in numbers.flights]
    airs: dict[str, FlownAir] = {}
    asked = []
    for case, name in left:
        plant = case.plant
        if plant.models not in numbers.models:
            numbers.models[plant.models] = models_of(plant.models)
        if plant.air not in airs:
            airs[plant.air] = air = find_air(plant.air)
            numbers.airs[plant.air] = list(air.flights) if isinstance(air, RoomAir) else []
        models = tuple(numbers.models_for(case))
        asked.append(VariantFlight(case, name, models, airs[plant.air], numbers.draws_of(case)))
    return asked
