"""Outcome of an experiment of `scripts/paper`: numbers by id, and pictures by figure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_model.signals.values import Array


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


def drawn(path: Path, title: str, labels: tuple[str, str], lines: list[Line]) -> str:
    """Draw one panel into a PNG; return the file's name."""
    with mpl.rc_context({"font.size": 10, "axes.grid": True, "grid.alpha": 0.3}):
        figure = Figure(figsize=(7.2, 3.6), layout="constrained")
        axes: Axes = figure.add_subplot()
        for line in lines:
            axes.plot(line.x, line.y, line.style, label=line.label)
        axes.set_title(title)
        axes.set_xlabel(labels[0])
        axes.set_ylabel(labels[1])
        axes.legend()
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=120)
    return path.name
