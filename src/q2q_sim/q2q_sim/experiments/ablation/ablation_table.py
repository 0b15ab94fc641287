"""Markdown page of the ablation: medians over replicas with 95 % intervals of the median.

Intervals are percentiles of the medians of RESAMPLES bootstrap samples (Efron, Tibshirani, 1993), always
drawn with the same seed. Ratios are medians of the ratio of each replica, which has the same noise, air and
rotors in every flight.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.experiments.ablation.ablation_cases import CASES, Case
from q2q_sim.experiments.ablation.contenders import CONTENDERS
from q2q_sim.experiments.ablation.trial import COLUMNS

RESAMPLES = 1000
MM = 1e3
"""Millimetres in a metre."""

Cells = Mapping[str, Array]
"""COLUMNS of each replica, (replicas, 6), by `key`."""

HEAD = (
    "| controller | n | z RMSE, lower [mm] | under [mm] | clear air [mm] | worst [mm] "
    "| energy above hover [N²s] | under / clear | worst over ignoring's |\n"
    "|---|--:|--:|--:|--:|--:|--:|--:|--:|\n"
)


def key(case: Case, contender: str) -> str:
    """Return the name of a cell."""
    return f"{case.scenario}|{case.wake}|{contender}"


def page(cells: Cells, notes: Sequence[str], command: str) -> str:
    """Return the page, without cases and contenders that have not been flown."""
    parts = ["# Ablation\n", f"Made by `{command}`; do not edit.\n", *(f"{note}\n" for note in notes)]
    for case in CASES:
        rows = [_row(cells, case, contender) for contender in CONTENDERS if key(case, contender) in cells]
        if rows:
            parts.append(f"## {case.scenario}, {case.wake} wake\n\n{HEAD}" + "\n".join(rows) + "\n")
    return "\n".join(parts)


def median_interval(values: Array) -> tuple[float, float, float]:
    """Return median and 95 % interval of `values` (n,) without NaN."""
    known = values[np.isfinite(values)]
    if known.size == 0:
        return (np.nan, np.nan, np.nan)
    rng = np.random.default_rng(0)
    medians = np.median(rng.choice(known, (RESAMPLES, known.size)), axis=1)
    low, high = np.percentile(medians, [2.5, 97.5])
    return float(np.median(known)), float(low), float(high)


def ratio_to_clear_air(values: Array) -> Array:
    """Return z RMSE under another over that in clear air, each replica of a cell (n, 6), (n,)."""
    return np.asarray(values[:, COLUMNS.index("under")] / values[:, COLUMNS.index("clear")])


def worst_to_ignoring(cells: Cells, case: Case, contender: str) -> Array:
    """Return the ignoring PD's worst error over this contender's, each replica, (n,)."""
    column = COLUMNS.index("worst")
    here, ignoring = cells[key(case, contender)], cells.get(key(case, "ignoring"))
    if ignoring is None or len(ignoring) != len(here):
        return np.full(len(here), np.nan)
    return np.asarray(ignoring[:, column] / here[:, column])


def _row(cells: Cells, case: Case, contender: str) -> str:
    values = cells[key(case, contender)]
    shown = [_cell(MM * values[:, COLUMNS.index(name)], 2) for name in ("lower", "under", "clear", "worst")]
    shown.append(_cell(values[:, COLUMNS.index("energy")], 4))
    shown.append(_cell(ratio_to_clear_air(values), 2))
    factor = _cell(worst_to_ignoring(cells, case, contender), 1)
    shown.append(factor if factor == "-" else f"1 / {factor}")
    return f"| {contender} | {len(values)} | " + " | ".join(shown) + " |"


def _cell(values: Array, digits: int) -> str:
    middle, low, high = median_interval(values)
    if not np.isfinite(middle):
        return "-"
    if len(values) == 1:
        return f"{middle:.{digits}f}"
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"
