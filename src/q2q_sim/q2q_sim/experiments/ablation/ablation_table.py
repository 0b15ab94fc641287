"""Markdown page of the ablation: conclusion, plot, and a table for each case.

Values are medians over models and draws with 95 % intervals (two_level_interval).
Ratios are medians of the ratio of each draw, which has the same noise, air and vehicles in every flight.
"""

from collections.abc import Sequence

from q2q_model.signals.values import Array
from q2q_sim.experiments.ablation.ablation_cases import CASES, SHIPPED, Case, Plant
from q2q_sim.experiments.ablation.ablation_numbers import Numbers
from q2q_sim.experiments.ablation.conclusion import (
    MM,
    column,
    conclusion,
    not_smaller,
    ratio,
    words,
    worse_than_ignoring,
)
from q2q_sim.experiments.ablation.contenders import CONTENDERS
from q2q_sim.experiments.ablation.two_level_interval import median_interval

SHOWN = CASES[:2]
"""Cases of the conclusion and the plot."""
READING = """\
Values are medians over models and draws with 95 % intervals over both: models are resampled, and draws
within each. Every draw has its own noise, losses, gusts, turbulence and vehicles; no model has seen a flight
of the air that it flies in. *Under* is the rms height error of vehicles under another and for 1 s after,
*clear* that of the same flight's vehicles under nobody for 3 s, *worst* the largest height error under
another (`q2q_sim.monitors.exposure`). All vehicles are Crazyflies in the room `real` (26 ms of delay, noise,
losses, outliers) with K_p 10 and K_d 5, as `table6_room` is flown with `--air`. What each controller knows:
`q2q_sim.experiments.ablation.contenders`."""
HEAD = (
    "| controller | under [mm] | clear [mm] | worst [mm] | under / clear | under / ignoring's "
    "| worst, ignoring's / own | lowest vehicle, whole flight [mm] | energy above hover [N²s] |\n"
    "|---|--:|--:|--:|--:|--:|--:|--:|--:|"
)


def page(numbers: Numbers, command: str, picture: str) -> str:
    """Return the page; `picture` is the path of the plot from it."""
    missing = sum(numbers.cell(case, name) is None for case in CASES for name in CONTENDERS)
    rest = f"{missing} rows of the tables are missing: run the same command again." if missing else ""
    parts = [
        "# Ablation",
        f"Made by `{command}`; do not edit.",
        rest,
        conclusion(numbers, SHOWN),
        f"![Height errors of each controller in learned air]({picture})",
        f"{READING} {_flights(numbers)}",
        *(_section(numbers, case) for case in CASES),
        "## Models",
        *(_models(numbers, family) for family in numbers.models),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _flights(numbers: Numbers) -> str:
    count = sum(len(flown) for flown in numbers.flights.values())
    return f"There are {count} flights, of 2 to 10 s of CPU each."


def _section(numbers: Numbers, case: Case) -> str:
    rows = [_row(numbers, case, name) for name in CONTENDERS if numbers.cell(case, name) is not None]
    if not rows:
        return ""
    if numbers.cell(case, "ignoring") is None:
        return "\n\n".join([f"## {case.title}", origin(numbers, case.plant), "\n".join([HEAD, *rows])])
    worse = [f"{name} ({words(times, 2)})" for name, times in worse_than_ignoring(numbers, case)]
    said = "No controller is worse than ignoring under another vehicle."
    if worse:
        said = f"**Worse than ignoring** under another vehicle: {', '.join(worse)}."
    if alike := not_smaller(numbers, case):
        said += f" Worst error **not shown to be smaller** than ignoring's: {', '.join(alike)}."
    return "\n\n".join([f"## {case.title}", origin(numbers, case.plant), "\n".join([HEAD, *rows]), said])


def origin(numbers: Numbers, plant: Plant) -> str:
    """Return what was flown in what: air and models, with the flights and family of each."""
    flights, models = numbers.airs.get(plant.air, []), numbers.models_for(plant)
    behind = sorted({one.name.partition(",")[0] for one in models})
    names = _without(plant.family, flights)
    learned = f"learned from {len(flights)} flights of the family {plant.family} ({names})"
    air = f"`{plant.air}`, {learned}" if plant == SHIPPED else learned
    return (
        f"**Air:** {air}: jet as a table, turbulence, gusts, torques. **Models:** {len(models)} Gaussian "
        f"jets, each learned from a flight, or a part of one, of the family {plant.models} "
        f"({_without(plant.models, behind)}); {numbers.draws} draws with each."
    )


def _models(numbers: Numbers, family: str) -> str:
    head = "| learned from | strength [m/s²] | decay [1/m] | width [m] | spread [m/m] | travel speed [m/s] |"
    rows = [
        f"| {one.name} | {one.jet.strength:.2f} | {one.jet.decay_rate:.2f} | {one.jet.width:.3f} "
        f"| {one.jet.spread:.3f} | {one.jet.travel_speed:.2f} |"
        for one in numbers.models[family]
    ]
    return "\n".join([head, "|---|--:|--:|--:|--:|--:|", *rows])


def _row(numbers: Numbers, case: Case, name: str) -> str:
    def of(wanted: str) -> Array:
        return column(numbers, case, name, wanted)

    under, clear = of("under"), of("clear")
    cells = [words(median_interval(MM * values), 1) for values in (under, clear, of("worst"))]
    cells.append(words(median_interval(under / clear), 2))
    if numbers.cell(case, "ignoring") is None:
        cells += ["-", "-"]
    else:
        cells.append(words(ratio(numbers, case, (name, "ignoring"), "under"), 2))
        cells.append(words(ratio(numbers, case, ("ignoring", name), "worst"), 1))
    cells += [words(median_interval(MM * of("lower")), 1), words(median_interval(of("energy")), 3)]
    return f"| {name} | " + " | ".join(cells) + " |"


def _without(family: str, flights: Sequence[str]) -> str:
    """Return names of flights without that of their family."""
    return ", ".join(one.removeprefix(f"{family}_") for one in flights)
