"""Conclusion of the ablation in three sentences, made from its numbers.

The first names the controller with the least worst error in each case, those that cannot be told from it, and
what it reaches; the second what knowing the downwash changes in controllers that differ in nothing else; the
third what is worse than ignoring, and how far the models move the result. Ratios are of the same draw.
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.experiments.ablation.ablation_cases import Case
from q2q_sim.experiments.ablation.ablation_numbers import Numbers
from q2q_sim.experiments.ablation.contender_flight import COLUMNS
from q2q_sim.experiments.ablation.contenders import CONTENDERS, TWINS
from q2q_sim.experiments.ablation.two_level_interval import MedianInterval, median_interval

MM = 1e3
"""Millimetres in a metre."""


def conclusion(numbers: Numbers, cases: Sequence[Case]) -> str:
    """Return three sentences, one a line, on the cases that are flown whole; empty if none is."""
    whole = [case for case in cases if all(numbers.cell(case, name) is not None for name in CONTENDERS)]
    if not whole:
        return ""
    sentences = (_reached(numbers, whole), _known(numbers, whole), _worse(numbers, whole))
    return "\n".join(f"- {sentence}" for sentence in sentences)


def best_contender(numbers: Numbers, case: Case) -> str:
    """Return the contender with the least median worst error."""
    return min(CONTENDERS, key=lambda name: float(np.median(column(numbers, case, name, "worst"))))


def worse_than_ignoring(numbers: Numbers, case: Case) -> list[tuple[str, MedianInterval]]:
    """Return the contenders whose rms error under another vehicle is above ignoring's, and by what ratio.

    The whole interval of the ratio is above 1.
    """
    found = []
    for name in CONTENDERS:
        if numbers.cell(case, name) is not None and numbers.cell(case, "ignoring") is not None:
            times = ratio(numbers, case, (name, "ignoring"), "under")
            found += [(name, times)] if times.low > 1.0 else []
    return found


def not_smaller(numbers: Numbers, case: Case) -> list[str]:
    """Return the contenders whose worst error is not shown to be smaller than ignoring's."""
    others = [name for name in CONTENDERS if name != "ignoring" and numbers.cell(case, name) is not None]
    return [one for one in others if ratio(numbers, case, (one, "ignoring"), "worst").high >= 1.0]


def column(numbers: Numbers, case: Case, contender: str, name: str) -> Array:
    """Return a column of a cell that is flown whole, (models, draws)."""
    cell = numbers.cell(case, contender)
    if cell is None:
        raise ValueError(f"{contender} is not flown whole in {case.title}")
    return np.asarray(cell[..., COLUMNS.index(name)])


def ratio(numbers: Numbers, case: Case, pair: tuple[str, str], name: str) -> MedianInterval:
    """Return a column of one contender over that of another, draw by draw."""
    first, second = (column(numbers, case, one, name) for one in pair)
    return median_interval(first / second)


def words(found: MedianInterval, digits: int) -> str:
    """Return a median with its interval as text."""
    return f"{found.middle:.{digits}f} ({found.low:.{digits}f} to {found.high:.{digits}f})"


def _reached(numbers: Numbers, cases: Sequence[Case]) -> str:
    parts = []
    for case in cases:
        best = best_contender(numbers, case)
        alike = [
            name
            for name in CONTENDERS
            if name != best and ratio(numbers, case, (name, best), "worst").low <= 1.0
        ]
        besides = f" (not told from it: {', '.join(alike)})" if alike else ""
        times = ratio(numbers, case, ("ignoring", best), "worst")
        under, clear = (column(numbers, case, best, name) for name in ("under", "clear"))
        parts.append(
            f"in {_place(case)} that of **{best}**{besides}, {words(times, 1)} times smaller than "
            f"ignoring's, with {words(median_interval(MM * under), 0)} mm rms under another vehicle, "
            f"{words(median_interval(under / clear), 1)} times that in clear air"
        )
    return f"The least worst height error is {'; '.join(parts)}."


def _known(numbers: Numbers, cases: Sequence[Case]) -> str:
    parts = []
    for aware, blind in TWINS.items():
        found = [words(ratio(numbers, case, (aware, blind), "under"), 2) for case in cases]
        parts.append(f"{aware} {' and '.join(found)} times {blind}'s")
    return (
        "What a learned model is worth, as rms error under another vehicle over that of the same controller "
        f"without one, in the same order: {'; '.join(parts)}."
    )


def _worse(numbers: Numbers, cases: Sequence[Case]) -> str:
    worse = [
        f"{name} in {_place(case)} ({words(times, 2)} times)"
        for case in cases
        for name, times in worse_than_ignoring(numbers, case)
    ]
    said = "No controller is worse than ignoring under another vehicle"
    if worse:
        said = f"Worse than ignoring under another vehicle: {', '.join(worse)}"
    alike = [
        f"{', '.join(names)} in {_place(case)}" for case in cases if (names := not_smaller(numbers, case))
    ]
    if alike:
        said += f"; the worst error of {' and of '.join(alike)} is not shown to be smaller than ignoring's"
    spread = []
    for case in cases:
        best = best_contender(numbers, case)
        each = MM * np.median(column(numbers, case, best, "under"), axis=1)
        spread.append(f"{best}'s from {each.min():.0f} to {each.max():.0f} mm in {_place(case)}")
    return f"{said}; from model to model, the median rms there goes: {', '.join(spread)}."


def _place(case: Case) -> str:
    return f"`{case.scenario}`"
