"""Conclusion of the ablation in three sentences, made from its numbers.

The first names the best controllers and what they reach; the second what each part is worth; the third how
often the targets are met, and what is worse than ignoring, on all paths. All ratios are of the same draw, and
ranges are those of the medians in air that is not of the models' family.
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
from q2q_sim.report.significant_digits import MM, significant_digits

UNDER_CLEAR, GAIN, UNDER_MM, WORST_MM = 2.0, 6.0, 12.0, 40.0
"""Targets: rms under another vehicle over that in clear air, worst error of ignoring over the own, rms and
worst error under another vehicle [mm]."""


def conclusion(numbers: Numbers) -> str:
    """Return three sentences, one a line, on the cases that are flown whole; empty if none is."""
    cases = [case for case in judged_cases() if is_whole(numbers, case)]
    if not cases:
        return ""
    sentences = (_reached(numbers, cases), _parts(numbers, cases), _missed(numbers, cases))
    return "\n".join(f"- {sentence}" for sentence in sentences)


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


def _reached(numbers: Numbers, cases: Sequence[Case]) -> str:
    best = Counter(best_variant(numbers, case) for case in cases).most_common()
    parts = []
    for name in SHOWN:
        own = [case for case in cases if case.name == name]
        if own:
            worst = _span([MM * median_worst(numbers, one, best_variant(numbers, one)) for one in own])
            ignored = _span([MM * median_worst(numbers, one, "ignoring") for one in own])
            parts.append(f"{worst} mm in `{name}` (ignoring {ignored} mm)")
    others = f" (in the others {', '.join(name for name, _ in best[1:])})" if best[1:] else ""
    rule = "fewest targets missed, of those the least worst error"
    return (
        f"**{best[0][0]}** is best ({rule}) in {best[0][1]} of {len(cases)} pairs of paths and air{others}; "
        f"the best of each has a worst height error under another vehicle of {'; '.join(parts)}."
    )


def _parts(numbers: Numbers, cases: Sequence[Case]) -> str:
    parts = []
    for one, without in TWINS:
        both = [case for case in cases if {one, without} <= set(flown_variants(numbers, case))]
        times = [median_ratio(numbers, case, (one, without), "worst").middle for case in both]
        if not times:
            continue
        parts.append(f"{one} {np.median(times):.2f} ({min(times):.2f} to {max(times):.2f}) times {without}'s")
    return f"The worst error, against that of the same controller without one part, is {', '.join(parts)}."


def _missed(numbers: Numbers, cases: Sequence[Case]) -> str:
    missed = {case: missed_targets(numbers, case, best_variant(numbers, case)) for case in cases}
    met = sum(not one for one in missed.values())
    said = (
        f"The best controller meets all targets (under / clear at most {UNDER_CLEAR:g}, worst "
        f"error {GAIN:g} times smaller than ignoring's, {UNDER_MM:g} mm rms, {WORST_MM:g} mm worst) in "
        f"{met} of {len(cases)}"
    )
    return f"{said}; {_worse(numbers)}."


def _worse(numbers: Numbers) -> str:
    """Return which controllers are worse than ignoring, on all paths that are flown whole."""
    cases = [case for name in PATHS for plant in JUDGED if is_whole(numbers, case := Case(name, plant))]
    worse = [(name, case) for case in cases for name in worse_than_ignoring(numbers, case)]
    where = f"on all paths, in {counted(len(cases), 'pair')},"
    if not worse:
        return f"{where} no controller is worse than ignoring under another vehicle"
    found = "; ".join(f"{name} in {case.title} ({_times(numbers, case, name)})" for name, case in worse)
    return f"{where} worse than ignoring in rms error under another vehicle are {found}"


def _times(numbers: Numbers, case: Case, name: str) -> str:
    """Return a variant's rms error over ignoring's, as text."""
    found = median_ratio(numbers, case, (name, "ignoring"), "under")
    return f"{found.middle:.2f} times, {found.low:.2f} to {found.high:.2f}"


def _span(values: Sequence[float]) -> str:
    return f"{millimetres(min(values))} to {millimetres(max(values))}"
