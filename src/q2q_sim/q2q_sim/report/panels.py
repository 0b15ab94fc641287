"""Panels over each other in one style, legible on a phone: text of 11 points in a picture 5.4 inches wide."""

import re
from pathlib import Path
from zlib import crc32

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_model.documents.written_file import naming_written

WIDTH, PANEL, MARGIN = 5.4, 2.3, 0.9
"""Width of a figure, height of a panel, and of title, legend and label together [inch]."""
DPI = 130
LETTERS = 45
"""Most letters of a legend in one row."""
TITLE_LETTERS = 44
"""Most letters of a title: those of 11 points that fit the width, if they are not wide ones."""
SHORT_NAME = 8
"""Letters that a title keeps of a long name, at least."""
MOST_LETTERS = 50
"""Most letters of a vehicle's or flight's name in the name of a file."""
STYLE = {
    "font.size": 11,
    "axes.titlesize": 11,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def panels(count: int, *, sharey: bool = False) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels over each other that share time, and the scale if `sharey`."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, PANEL * count + MARGIN), layout="constrained")
        found = figure.subplots(count, 1, sharex=True, sharey=sharey, squeeze=False)
    return figure, list(found[:, 0])


def legend_above(figure: Figure, axes: Axes) -> None:
    """Write the legend of a panel above all panels, off the curves."""
    handles, labels = axes.get_legend_handles_labels()
    columns = len(labels) if sum(map(len, labels)) <= LETTERS else 2
    if handles:
        figure.legend(handles, labels, loc="outside upper center", fontsize=9, ncols=columns, frameon=False)


def literal(words: str) -> str:
    """Return words for matplotlib that it draws as they are.

    Otherwise `$` begins a formula, and a legend leaves out what begins with `_`.
    """
    plain = words.replace("$", r"\$")
    return f" {plain}" if plain.startswith("_") else plain


def panel_title(name: str, quantity: str, flight: str = "") -> str:
    """Return the title of a panel in one row; long names of vehicle and flight lose their middle."""
    named = f", {_shortened(flight, SHORT_NAME)}" if flight else ""
    rest = f": {quantity}{named}"
    return literal(_shortened(name, max(TITLE_LETTERS - len(rest), SHORT_NAME)) + rest)


def _shortened(name: str, most: int) -> str:
    end = (most - 1) // 2
    return name if len(name) <= most else f"{name[: most - 1 - end]}…{name[-end:]}"


def picture_file(folder: Path, name: str, what: str = "") -> Path:
    """Return the file of a picture in a folder, for any name of a vehicle or flight.

    A name that is changed for the file ends in its checksum, so that no two names share a file.
    """
    stem = re.sub(r"[^\w.-]", "_", name)[:MOST_LETTERS]
    distinct = stem if stem == name else f"{stem}_{crc32(name.encode()):08x}"
    return folder / f"{distinct}{what and f'_{what}'}.png"


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG; return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with naming_written(path):
        figure.savefig(path, dpi=DPI)
    return path
