"""Reproduced numbers and figures as JSON, as one HTML page and as a PDF."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.image import imread

from q2q_model.documents.json_file import Json
from q2q_model.documents.written_file import write_text
from q2q_sim.experiments.paper.experiment_outcome import ExperimentOutcome, FigurePicture
from q2q_sim.experiments.paper.paper_numbers import PaperNumber
from q2q_sim.report.html_page import Grid, Part, Picture, page

TITLE = "Reproduction of the paper"
CITATION = (
    "I. Matei, C. Zeng, S. Chowdhury, R. Rai, J. de Kleer: Controlling Draft Interactions Between "
    "Quadcopter Unmanned Aerial Vehicles with Physics-aware Modeling. Journal of Intelligent & Robotic "
    "Systems 101 (2021)."
)
"""The paper, as README.md, docs/README.md and CITATION.cff name it."""
LEAD = (
    f"The paper: {CITATION} Every table and figure of it that holds a number, from the project's own "
    "flights, all simulated. The paper's flights are not published: the downwash they are flown in is a "
    "reconstruction from its tables, so absolute values may differ. Controllers are given that downwash's "
    "own law, as in the paper: these numbers reproduce the paper and are no claim about real air. For that, "
    "the rows learned_air of Tables 6 and 7 fly the passage in air learned from recorded flights, with a "
    "model learned from others."
)
HEAD = ("number", "paper", "ours", "ratio", "unit", "where", "why they differ")
"""Numbers first: a phone shows the first columns, and the others aside."""
ROWS_A_PAGE = 18
"""Rows of a PDF page."""
WHOLE = 1000.0
"""Size from which a number is written without decimals, and below with three significant digits."""
NOTE_WIDTH = 92
"""Characters of a note on one line of a page."""
A4_WIDE = (11.7, 8.3)
"""[inch]"""
CLOSE = 0.1
"""Difference to the paper's number up to which ours counts as close, as a share of it."""
REPEATED = "no result"
"""In the note of a number that is taken from the paper."""
EXPONENT = re.compile(r"e([+-])0*(\d+)$")
POWER = re.compile(r"\^(-?\d+)")
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def as_json(numbers: Sequence[PaperNumber], outcomes: Sequence[ExperimentOutcome]) -> Json:
    """Return {"rows": [...]}, one for each number."""
    found = found_values(outcomes)
    return {
        "rows": [
            {
                "id": one.id,
                "paper": one.paper,
                "ours": found.get(one.id),
                "unit": one.unit,
                "note": one.note,
            }
            for one in numbers
        ]
    }


def found_values(outcomes: Sequence[ExperimentOutcome]) -> dict[str, float]:
    """Return every finite number that was found."""
    pairs = (pair for outcome in outcomes for pair in outcome.values.items())
    return {name: value for name, value in pairs if math.isfinite(value)}


def table_cells(
    numbers: Sequence[PaperNumber], outcomes: Sequence[ExperimentOutcome]
) -> list[tuple[str, ...]]:
    """Return the cells of the table."""
    found = found_values(outcomes)
    return [_row(one, found.get(one.id)) for one in numbers]


def without_repeated_notes(cells: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Return cells in which a note that is that of the row above is marked as such."""
    above = [None, *(row[-1] for row in cells)]
    return [
        (*row[:-1], "as above") if row[-1] == note else row for row, note in zip(cells, above, strict=False)
    ]


def closeness_sentence(numbers: Sequence[PaperNumber], outcomes: Sequence[ExperimentOutcome]) -> str:
    """Return how many numbers are close to the paper's, of the results that it prints too."""
    found = found_values(outcomes)
    ratios = [
        ours / one.paper
        for one in numbers
        if one.paper and REPEATED not in one.note and (ours := found.get(one.id)) is not None
    ]
    close = sum(abs(ratio - 1.0) <= CLOSE for ratio in ratios)
    return (
        f"Within {100.0 * CLOSE:.0f} % of the paper's: {close} of {len(ratios)} numbers, those taken from "
        "the paper not counted. Energies count, though plain hover is within 2 % of them. The last column "
        "says why others differ."
    )


def write_page(numbers: Sequence[PaperNumber], outcomes: Sequence[ExperimentOutcome], out: Path) -> None:
    """Write index.html into a folder."""
    pictures = [Picture(path, one.caption) for one, path in _pictures(numbers, outcomes, out)]
    cells = without_repeated_notes(table_cells(numbers, outcomes))
    parts: list[Part] = [closeness_sentence(numbers, outcomes), Grid(HEAD, cells, has_code=True), pictures]
    write_text(page(TITLE, LEAD, parts), out / "index.html")


def write_pdf(numbers: Sequence[PaperNumber], outcomes: Sequence[ExperimentOutcome], out: Path) -> None:
    """Write paper.pdf into a folder: the table, then one picture per page."""
    cells = table_cells(numbers, outcomes)
    with PdfPages(out / "paper.pdf") as pdf:
        for start in range(0, len(cells), ROWS_A_PAGE):
            sheet = _table_page(cells[start : start + ROWS_A_PAGE])
            sheet.text(0.03, 0.01, CITATION, fontsize=7)
            pdf.savefig(sheet)
        for one, path in _pictures(numbers, outcomes, out):
            pdf.savefig(_picture_page(one.caption, path))


def _pictures(
    numbers: Sequence[PaperNumber], outcomes: Sequence[ExperimentOutcome], out: Path
) -> list[tuple[FigurePicture, Path]]:
    """Return the pictures of the chosen figures with their files, in the order of the numbers."""
    groups = list(dict.fromkeys(one.group for one in numbers))
    drawn = [one for outcome in outcomes for one in outcome.pictures if one.group in groups]
    files = {path.name: path for path in out.glob("*/*.png")}
    return [(one, files[one.file]) for one in sorted(drawn, key=lambda one: groups.index(one.group))]


def _row(one: PaperNumber, ours: float | None) -> tuple[str, ...]:
    ratio = "-" if ours is None or not one.paper else _text(ours / one.paper)
    papers = "-" if one.paper is None else _raised(f"{one.paper:g}")
    unit = POWER.sub(lambda power: power[1].translate(RAISED), one.unit)
    return (one.id, papers, _text(ours), ratio, unit, one.where, one.note)


def _text(value: float | None) -> str:
    if value is None:
        return "-"
    return _raised(f"{value:.3g}" if abs(value) < WHOLE else f"{value:.0f}")


def _raised(number: str) -> str:
    """Return a number with its power of ten as books print it: 3.14 · 10⁻⁵."""
    return EXPONENT.sub(lambda found: f" · 10{(found[1] + found[2]).lstrip('+').translate(RAISED)}", number)


def _table_page(cells: Sequence[tuple[str, ...]]) -> Figure:
    figure = Figure(figsize=A4_WIDE)
    axes = figure.add_axes((0.03, 0.03, 0.94, 0.94))
    axes.set_axis_off()
    short = [(*row[:5], fill(row[-1], NOTE_WIDTH)) for row in cells]
    table = axes.table(
        short,
        colLabels=(*HEAD[:5], HEAD[-1]),
        colWidths=(0.2, 0.07, 0.07, 0.06, 0.06, 0.54),
        cellLoc="left",
        loc="upper center",
    )
    table.auto_set_font_size(value=False)
    table.set_fontsize(7)
    height = table[0, 0].get_height()
    for row, text in enumerate(short, start=1):
        for column in range(len(text)):
            table[row, column].set_height(height * (1 + 0.8 * text[-1].count("\n")))
    return figure


def _picture_page(caption: str, path: Path) -> Figure:
    figure = Figure(figsize=A4_WIDE)
    axes = figure.add_axes((0.05, 0.08, 0.9, 0.86))
    axes.imshow(imread(path))
    axes.set_axis_off()
    figure.text(0.05, 0.03, caption)
    return figure
