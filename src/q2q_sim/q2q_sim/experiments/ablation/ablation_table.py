"""Markdown page of the ablation: conclusion, plot, a table of each case, then the intervals.

Values are medians over models and draws with 95 % intervals (two_level_interval).
Ratios are medians of the ratio of each draw, which has the same noise, air and vehicles in every flight.
"""

import numpy as np

from q2q_model.counted import counted
from q2q_sim.experiments.ablation.ablation_cases import CASES, LAW, PATHS, PLANTS, SHOWN, Case
from q2q_sim.experiments.ablation.ablation_numbers import Numbers
from q2q_sim.experiments.ablation.conclusion import (
    best_variant,
    column,
    conclusion,
    flown_variants,
    is_whole,
    judged_cases,
    median_ratio,
    millimetres,
    missed_targets,
)
from q2q_sim.experiments.ablation.two_level_interval import MedianInterval, median_interval
from q2q_sim.experiments.ablation.variant_flight import COLUMNS
from q2q_sim.experiments.ablation.variants import NAMES
from q2q_sim.report.markdown_table import markdown_table
from q2q_sim.report.significant_digits import MM

READING = """\
All vehicles are Crazyflies in the room `real` (26 ms of delay, noise, losses, outliers; accelerometers with
0.2 m/s² of noise) with K_p 10 and K_d 5, as `table6_room` is flown with `--air`.
`q2q_sim.experiments.ablation.variants` lists what each controller knows; *ignoring* is the controller without
any compensation of the downwash.

| column | meaning (`q2q_sim.monitors.metrics.exposure`) |
| --- | --- |
| under | rms height error of vehicles under another and for 1 s after |
| clear | rms height error in the same flight of vehicles under no other for 3 s |
| worst | largest height error under another |
| gain | worst error of *ignoring* over that of the controller |

Values are medians over draws, each with its own noise, losses, gusts, turbulence and vehicles. A dash means
that the flight was not made.

**Interaction models and air models share no flight.** For the airs `room` and `recorded`, learned from the
flights dc21, the controllers' models are learned from dc19. `ring`, `heavy_tailed`, `bent` and `meandering`
have other forms than the controllers' models, and the strength of a law fitted to dc19; for them the models
are learned from dc21. `paper` is the exception: the controllers know its law, and it is not judged.

**Thrust.** The vehicles have the thrust of the firmware of the recorded flights (`stock_2025_02`: 0.59 N,
1.76 times the weight; recorded are 1.81 and 1.95). An RPYT setpoint, as an offboard controller sends it, can
demand 1.62 times the weight. With firmware from 2025.12 on these ratios are 1.44 and 1.32;
[Correction](correction.md) has the effect.

**Onboard controllers.** *Mellinger* is the vehicle's own controller with its stock gains, on full states
without compensation; *on board* is the same with the [app](onboard.md). The estimate of its own motion is
exact; 20 % of the broadcasts are lost."""
UNDER_WORST = "rms error under another vehicle / worst error [mm]"


def ablation_page(numbers: Numbers, command: str, picture: str) -> str:
    """Return the page; `picture` is the path of the plot from it."""
    missing = sum(len(NAMES) - len(flown_variants(numbers, case)) for case in CASES)
    rest = f"{counted(missing, 'flight')} not flown: the same command flies the rest." if missing else ""
    parts = [
        "# Ablation",
        f"Made by `{command}`; do not edit.",
        rest,
        conclusion(numbers),
        f"![Worst height error of each controller in each air model]({picture})",
        "## Best controller in each air model",
        _best(numbers),
        "## Conditions and definitions",
        READING,
        *(_overview(numbers, name) for name in PATHS),
        "## Intervals",
        _resampling(numbers),
        *(_detail(numbers, case) for case in CASES if case.name in SHOWN),
        "## Models",
        _models(numbers),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _resampling(numbers: Numbers) -> str:
    return (
        f"Median with 95 % interval over {numbers.draws} draws with each of five models, each learned from a "
        "part of a flight. The bootstrap resamples models, and draws within each."
    )


def _best(numbers: Numbers) -> str:
    head = ["paths", "air", "controller", "under [mm]", "worst [mm]", "under / clear", "gain", "missed"]
    rows = []
    for case in judged_cases():
        if is_whole(numbers, case):
            name = best_variant(numbers, case)
            missed = ", ".join(missed_targets(numbers, case, name)) or "none"
            rows.append([case.name, case.plant.air, name, *_values(numbers, case, name), missed])
    return markdown_table(head, rows, 3) if rows else ""


def _values(numbers: Numbers, case: Case, name: str) -> list[str]:
    """Return the medians of under, worst, under / clear and gain."""
    under, clear, worst = (column(numbers, case, name, one) for one in COLUMNS)
    gain = median_ratio(numbers, case, ("ignoring", name), "worst").middle
    lengths = [millimetres(MM * float(np.median(one))) for one in (under, worst)]
    return [*lengths, f"{np.median(under / clear):.1f}", f"{gain:.1f}"]


def _overview(numbers: Numbers, name: str) -> str:
    """Return the table of some paths: a row for each controller, a column for each air."""
    rows = [[one, *(_short(numbers, Case(name, plant), one) for plant in PLANTS)] for one in NAMES]
    if all(cell == "-" for row in rows for cell in row[1:]):
        return ""
    paths = PATHS[name]
    draws = numbers.draws_of(Case(name))
    kind = "one model, of all flights" if paths.draws else "five models"
    if len(paths.scenarios) > 1:
        kind = f"{kind}, of each of {len(paths.scenarios)} flights"
    if not paths.draws:
        kind += f" (in `{LAW}` with one)"
    said = f"{UNDER_WORST}; {draws} draws with {kind}; {paths.start:g} to {paths.end:g} s of the scenario."
    table = markdown_table(["controller", *(plant.air for plant in PLANTS)], rows, 1)
    return "\n\n".join([f"## {name}", said[0].upper() + said[1:], table])


def _short(numbers: Numbers, case: Case, variant: str) -> str:
    if numbers.cell(case, variant) is None:
        return "-"
    under, worst = (np.median(column(numbers, case, variant, one)) for one in ("under", "worst"))
    return f"{millimetres(MM * float(under))} / {millimetres(MM * float(worst))}"


def _detail(numbers: Numbers, case: Case) -> str:
    flown = flown_variants(numbers, case)
    if "ignoring" not in flown:
        return ""
    head = ["controller", "under [mm]", "clear [mm]", "worst [mm]", "under / clear", "gain"]
    rows = [[name, *_intervals(numbers, case, name)] for name in flown]
    return "\n\n".join([f"### {case.title}", markdown_table(head, rows, 1)])


def _intervals(numbers: Numbers, case: Case, name: str) -> list[str]:
    under, clear, worst = (column(numbers, case, name, one) for one in COLUMNS)
    lengths = [_lengths(median_interval(MM * one)) for one in (under, clear, worst)]
    gain = median_ratio(numbers, case, ("ignoring", name), "worst")
    return [*lengths, _times(median_interval(under / clear)), _times(gain)]


def _lengths(found: MedianInterval) -> str:
    return f"{millimetres(found.middle)} ({millimetres(found.low)} to {millimetres(found.high)})"


def _times(found: MedianInterval) -> str:
    return f"{found.middle:.1f} ({found.low:.1f} to {found.high:.1f})"


def _models(numbers: Numbers) -> str:
    head = [
        "learned from",
        "strength [m/s²]",
        "decay [1/m]",
        "width [m]",
        "spread [m/m]",
        "travel speed [m/s]",
    ]
    head += ["residual [m/s²]", "time [s]"]
    rows = []
    for one in (model for family in numbers.models.values() for model in family):
        jet, residual = one.jet, one.process
        shape = [f"{jet.strength:.2f}", f"{jet.decay_rate:.2f}", f"{jet.width:.3f}", f"{jet.spread:.3f}"]
        size = f"{residual.floor:.2f} + {residual.slope:.2f} eta"
        rows.append([one.name, *shape, f"{jet.travel_speed:.2f}", size, f"{residual.time_s:.2f}"])
    return markdown_table(head, list(dict.fromkeys(map(tuple, rows))), 1)
