"""Plot of the ablation: height errors of each controller; colours of Okabe and Ito, 2008."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_sim.experiments.ablation.ablation_cases import Case
from q2q_sim.experiments.ablation.ablation_numbers import Numbers
from q2q_sim.experiments.ablation.conclusion import MM, column
from q2q_sim.experiments.ablation.contenders import CONTENDERS
from q2q_sim.experiments.ablation.two_level_interval import median_interval

WIDTH, ROW, EDGES = 5.4, 0.3, 1.0
"""Width of the figure, height of a row and of a panel's edges [inch]; 11 points are legible on a phone."""
STYLE = {"font.size": 11, "axes.grid": True, "grid.alpha": 0.3, "axes.titlesize": 11}
MARKS = {
    "clear": ("#56b4e9", "o", "rms in clear air"),
    "under": ("#0072b2", "s", "rms under another vehicle"),
    "worst": ("#d55e00", "D", "worst under another vehicle"),
}
"""Colour, marker and label of each column."""
APART = 0.22
"""Distance of the columns of a row [rows]."""


def ablation_figure(numbers: Numbers, cases: Sequence[Case]) -> Figure:
    """Draw medians and 95 % intervals of the height errors in each case."""
    with mpl.rc_context(STYLE):
        height = len(cases) * (ROW * len(CONTENDERS) + EDGES) + 0.8
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        panels = figure.subplots(len(cases), 1, sharex=True, squeeze=False)[:, 0]
    for axes, case in zip(panels, cases, strict=True):
        _draw(axes, numbers, case)
    panels[0].set_xlim(left=0.0)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", fontsize=10, ncols=1)
    panels[-1].set_xlabel("height error [mm], median and 95 % interval")
    return figure


def _draw(axes: Axes, numbers: Numbers, case: Case) -> None:
    flown = [name for name in CONTENDERS if numbers.cell(case, name) is not None]
    for k, (name, (colour, marker, label)) in enumerate(MARKS.items()):
        found = np.array([median_interval(MM * column(numbers, case, one, name)) for one in flown])
        middle, low, high = found.reshape(-1, 3).T
        axes.errorbar(
            middle,
            np.arange(len(flown)) + APART * (k - 1),
            xerr=(middle - low, high - middle),
            fmt=marker,
            color=colour,
            label=label,
            markersize=5,
            capsize=2,
        )
    axes.set_yticks(np.arange(len(flown)), flown)
    axes.invert_yaxis()
    axes.set_title(f"{case.scenario}: air of {case.plant.family}, models of {case.plant.models}")
