"""Plot of the ablation: worst errors of each controller in every air."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_model import palette
from q2q_sim.experiments.ablation.ablation_cases import JUDGED, SHOWN, Case, Plant
from q2q_sim.experiments.ablation.ablation_numbers import Numbers
from q2q_sim.experiments.ablation.conclusion import WORST_MM, median_worst
from q2q_sim.experiments.ablation.variants import NAMES
from q2q_sim.report.significant_digits import MM

SIZE = (5.4, 7.6)
"""[inch]; 11 points are legible on a phone."""
STYLE = {"font.size": 11, "axes.grid": True, "grid.alpha": 0.3, "axes.titlesize": 10}
TITLES = {SHOWN[0]: "A vehicle passes over another", SHOWN[1]: "Two vehicles pass under a third"}
TICKS = (5, 10, 20, 50, 100, 200, 500)
"""[mm]"""


def ablation_figure(numbers: Numbers) -> Figure:
    """Draw the median worst error of each controller in each air that is not of the models' family."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=SIZE, layout="constrained")
        panels = figure.subplots(len(SHOWN), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, SHOWN, strict=True):
        _plot_air(axes, numbers, name)
    panels[0].set_xscale("log")
    panels[0].set_xlim(0.8 * TICKS[0], TICKS[-1] * 1.5)
    panels[0].set_xticks(TICKS, [str(tick) for tick in TICKS])
    panels[0].minorticks_off()
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", fontsize=10, ncols=2)
    panels[-1].set_xlabel("worst height error under another vehicle [mm]")
    return figure


def _plot_air(axes: Axes, numbers: Numbers, name: str) -> None:
    measured, *others = JUDGED
    for row, variant in enumerate(NAMES):
        made = _worst(numbers, name, variant, others)
        real = _worst(numbers, name, variant, [measured])
        first = {} if row else {"air": "other airs", "room": "air of a real room", "all": "median over airs"}
        axes.plot(made, [row] * len(made), "o", color=palette.SKY, markersize=6, label=first.get("air"))
        axes.plot(
            real, [row] * len(real), "D", color=palette.VERMILLION, markersize=6, label=first.get("room")
        )
        if made or real:
            middle = float(np.median(made + real))
            axes.plot(middle, row, "|", color=palette.BLACK, ms=18, mew=2, label=first.get("all"))
    axes.axvline(WORST_MM, color=palette.REFERENCE, linestyle=":", label=f"target, {WORST_MM:g} mm")
    axes.set_yticks(np.arange(len(NAMES)), NAMES)
    axes.invert_yaxis()
    axes.set_title(f"{TITLES[name]} ({name})", x=0.35)


def _worst(numbers: Numbers, name: str, variant: str, plants: Sequence[Plant]) -> list[float]:
    """Return the median worst error in each air that was flown [mm]."""
    cases = [Case(name, plant) for plant in plants]
    return [
        MM * median_worst(numbers, case, variant) for case in cases if numbers.cell(case, variant) is not None
    ]
