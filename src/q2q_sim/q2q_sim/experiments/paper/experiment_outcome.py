"""Outcome of an experiment of `scripts/paper`: numbers by id, and pictures by figure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from q2q_model import palette
from q2q_model.signals.values import Array
from q2q_sim.report.panels import legend_above, panels, save

ASIDE = ("--", ":")
"""Styles of references and limits, which lie in front of the curves."""


@dataclass(frozen=True, slots=True)
class FigurePicture:
    """Picture of a figure."""

    group: str
    """fig10"""
    file: str
    """In the experiment's folder."""
    caption: str


@dataclass(frozen=True, slots=True)
class ExperimentOutcome:
    """Numbers, by id as in paper.yaml, and pictures."""

    values: Mapping[str, float]
    pictures: tuple[FigurePicture, ...] = ()


@dataclass(frozen=True, slots=True)
class Experiment:
    """Experiment behind some of the paper's tables and figures."""

    name: str
    groups: tuple[str, ...]
    seconds: float
    """Time on two idle cores [s]: its weight in the progress bar."""
    run: Callable[[Path], ExperimentOutcome]
    """Called with the folder for its pictures."""


@dataclass(frozen=True, slots=True)
class Line:
    """One curve of a panel."""

    label: str
    x: Array
    y: Array
    style: str = "-"
    colour: str = ""
    """Empty: that of a reference if dashed or dotted, else that of the flight of its place."""


def plot_panel(path: Path, title: str, labels: tuple[str, str], lines: list[Line]) -> str:
    """Plot one panel into a PNG; return the file's name."""
    figure, (axes,) = panels(1)
    for k, line in enumerate(lines):
        front = line.style in ASIDE
        flown = palette.REFERENCE if front else palette.FLIGHTS[k % len(palette.FLIGHTS)]
        axes.plot(
            line.x,
            line.y,
            line.style,
            color=line.colour or flown,
            label=line.label,
            zorder=3.0 if front else 2.0,
        )
    axes.set_title(title)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    legend_above(figure, axes)
    return save(figure, path).name
