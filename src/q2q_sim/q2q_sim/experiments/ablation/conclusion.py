"""Conclusion of the ablation, made from its numbers.

A list names the best controllers, the errors that they reach, how often they meet the targets, and which
controllers are worse than ignoring, on all paths. A table has the effect of each part of a controller. All
ratios are of the same draw, and ranges are those of the medians in air that is not of the models' family.
"""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from q2q_model.counted import counted
from q2q_model.signals.values import Array
from q2q_sim.experiments.ablation.ablation_cases import JUDGED, PATHS, SHOWN, Case
from q2q_sim.experiments.ablation.ablation_numbers import Numbers
from q2q_sim.experiments.ablation.two_level_interval import MedianInterval, median_interval
from q2q_sim.experiments.ablation.variant_flight import COLUMNS
from q2q_sim.experiments.ablation.variants import NAMES, TWINS
from q2q_sim.report.markdown_table import markdown_table
from q2q_sim.report.significant_digits import MM, significant_digits

UNDER_CLEAR, GAIN, UNDER_MM, WORST_MM = 2.0, 6.0, 12.0, 40.0
"""Targets: rms under another vehicle over that in clear air, worst error of ignoring over the own, rms and
worst error under another vehicle [mm]."""
PARTS = """\
Effect of each part of a controller: worst error with it over that of the same controller without it, median
over the pairs and range."""


def conclusion(numbers: Numbers) -> str:
    """Return a list and a table on the cases that are flown whole; empty if none is."""
    cases = [case for case in judged_cases() if is_whole(numbers, case)]
    if not cases:
        return ""
    items = (_best(numbers, cases), _reached(numbers, cases), _missed(numbers, cases), _worse(numbers))
    return "\n".join(f"- {one}" for one in items) + f"\n\n{PARTS}\n\n{_parts(numbers, cases)}"


def judged_cases() -> list[Case]:
    """Return the shown paths in the airs that are not of the models' family."""
    return [Case(name, plant) for name in SHOWN for plant in JUDGED]


def is_whole(numbers: Numbers, case: Case) -> bool:
    """Return whether all variants were flown."""
    return len(flown_variants(numbers, case)) == len(NAMES)


def flown_variants(numbers: Numbers, case: Case) -> list[str]:
    """Return the variants that were flown."""
    return [name for name in NAMES if numbers.cell(case, name) is not None]


def best_variant(numbers: Numbers, case: Case) -> str:
    """Return the variant that misses the fewest targets; of those, the one with the least worst error."""

    def rank(name: str) -> tuple[int, float]:
        return len(missed_targets(numbers, case, name)), median_worst(numbers, case, name)

    return min(flown_variants(numbers, case), key=rank)


def missed_targets(numbers: Numbers, case: Case, variant: str) -> list[str]:
    """Return the targets that a variant's medians miss, with what it reaches."""
    under, clear, worst = (column(numbers, case, variant, name) for name in COLUMNS)
    gain = float(np.median(ratios(numbers, case, ("ignoring", variant), "worst")))
    over = float(np.median(under / clear))
    reached = (
        (over <= UNDER_CLEAR, f"under / clear {over:.1f}"),
        (gain >= GAIN, f"gain {gain:.1f}"),
        (MM * np.median(under) <= UNDER_MM, f"{millimetres(MM * float(np.median(under)))} mm rms"),
        (MM * np.median(worst) <= WORST_MM, f"{millimetres(MM * float(np.median(worst)))} mm worst"),
    )
    return [words for met, words in reached if not met]


def worse_than_ignoring(numbers: Numbers, case: Case) -> list[str]:
    """Return the variants whose rms error under another vehicle has an interval above ignoring's."""
    flown = flown_variants(numbers, case)
    return [name for name in flown if median_ratio(numbers, case, (name, "ignoring"), "under").low > 1.0]


def column(numbers: Numbers, case: Case, variant: str, name: str) -> Array:
    """Return a column of a flown cell, (models, draws)."""
    cell = numbers.cell(case, variant)
    if cell is None:
        raise ValueError(f"{variant} was not flown in {case.title}: run the command without --table-only")
    return np.asarray(cell[..., COLUMNS.index(name)])


def median_ratio(numbers: Numbers, case: Case, pair: tuple[str, str], name: str) -> MedianInterval:
    """Return the median and interval of `ratios`."""
    return median_interval(ratios(numbers, case, pair, name))


def ratios(numbers: Numbers, case: Case, pair: tuple[str, str], name: str) -> Array:
    """Return a column of one variant over that of another, (models, draws); as many draws as both have."""
    first, second = (column(numbers, case, one, name) for one in pair)
    draws = min(first.shape[1], second.shape[1])
    return np.asarray(first[:, :draws] / second[:, :draws])


def millimetres(value: float) -> str:
    """Return a length [mm] with two or three digits."""
    return significant_digits(value, 2 if value < 100.0 else 3)


def median_worst(numbers: Numbers, case: Case, variant: str) -> float:
    """Return the median worst error of a flown cell [m]."""
    return float(np.median(column(numbers, case, variant, "worst")))


def _best(numbers: Numbers, cases: Sequence[Case]) -> str:
    best = Counter(best_variant(numbers, case) for case in cases).most_common()
    others = f" (in the others {', '.join(name for name, _ in best[1:])})" if best[1:] else ""
    return (
        f"**{best[0][0]}** is the best controller in {best[0][1]} of {len(cases)} pairs of paths and "
        f"air model{others}. The best one misses the fewest targets and, among equals, has the smallest "
        "worst error."
    )


def _reached(numbers: Numbers, cases: Sequence[Case]) -> str:
    parts = []
    for name in SHOWN:
        own = [case for case in cases if case.name == name]
        if own:
            worst = _span([MM * median_worst(numbers, one, best_variant(numbers, one)) for one in own])
            ignored = _span([MM * median_worst(numbers, one, "ignoring") for one in own])
            parts.append(f"{worst} mm in `{name}` (*ignoring*: {ignored} mm)")
    reached = " and ".join(parts)
    return f"The worst height error of each pair's best controller, under another vehicle, is {reached}."


def _parts(numbers: Numbers, cases: Sequence[Case]) -> str:
    rows = []
    for one, without in TWINS:
        both = [case for case in cases if {one, without} <= set(flown_variants(numbers, case))]
        times = [median_ratio(numbers, case, (one, without), "worst").middle for case in both]
        if times:
            rows.append([one, without, f"{np.median(times):.2f} ({min(times):.2f} to {max(times):.2f})"])
    return markdown_table(["controller", "compared with", "ratio of worst errors"], rows, 2)


def _missed(numbers: Numbers, cases: Sequence[Case]) -> str:
    missed = {case: missed_targets(numbers, case, best_variant(numbers, case)) for case in cases}
    met = sum(not one for one in missed.values())
    return (
        f"The best one meets all targets in {met} of {len(cases)} pairs: under / clear at most "
        f"{UNDER_CLEAR:g}, a worst error {GAIN:g} times smaller than that of *ignoring*, {UNDER_MM:g} mm "
        f"rms, {WORST_MM:g} mm worst."
    )


def _worse(numbers: Numbers) -> str:
    """Return which controllers are worse than ignoring, on all paths that are flown whole."""
    cases = [case for name in PATHS for plant in JUDGED if is_whole(numbers, case := Case(name, plant))]
    worse = [(name, case) for case in cases for name in worse_than_ignoring(numbers, case)]
    where = f"On all paths ({counted(len(cases), 'pair')})"
    if not worse:
        return f"{where} no controller has a larger rms error under another vehicle than *ignoring*."
    found = "; ".join(f"{name} in {case.title} ({_times(numbers, case, name)})" for name, case in worse)
    return f"{where} these have a larger rms error under another vehicle than *ignoring*: {found}."


def _times(numbers: Numbers, case: Case, name: str) -> str:
    """Return a variant's rms error over ignoring's, as text."""
    found = median_ratio(numbers, case, (name, "ignoring"), "under")
    return f"{found.middle:.2f} times, {found.low:.2f} to {found.high:.2f}"


def _span(values: Sequence[float]) -> str:
    return f"{millimetres(min(values))} to {millimetres(max(values))}"
