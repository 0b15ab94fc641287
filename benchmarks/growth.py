"""How the cost of every block grows with the number of vehicles, 2 to 1000, and what 10 000 would cost.

Each row of time has its reference in the same run (`cost_growth.timed_blocks`); rows of slopes are exponents
of a power law fitted in logarithms, with 95 % intervals (`cost_growth.power_law`). `scripts/bench --plots
FOLDER` draws `growth_time.png` and `growth_memory.png` there.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cost_growth.points import Curve, measured_curves
from cost_growth.power_law import PowerLaw
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import LAYOUTS
from q2q_model.signals.stamps import TICK_S
from row import Row

SIZES = (2, 5, 10, 20, 50, 100, 200, 500, 1000)
PAPER_SIZE = 10_000
"""Vehicles reckoned on paper: the most that a message may have."""
DPI = 72


def run(plots: Path | None = None) -> list[Row]:
    """Return the rows of this area; draw the figures into the folder `plots`."""
    curves = measured_curves(SIZES)
    if plots is not None:
        draw(curves, plots)
    return [row for curve in curves for row in _rows(curve)] + _messages()


def draw(curves: Sequence[Curve], folder: Path) -> list[Path]:
    """Write the figures of time and memory into a folder; return the files."""
    from cost_growth.growth_figure import MEMORY, TIME, growth_figure

    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, shown in (("growth_time.png", TIME), ("growth_memory.png", MEMORY)):
        paths.append(folder / name)
        growth_figure(curves, shown).savefig(paths[-1], dpi=DPI)
    return paths


def _rows(curve: Curve) -> list[Row]:
    rows = []
    for one in curve.points:
        name = f"{curve.block}, {one.vehicles} vehicles"
        rows += [
            Row(name, 1e6 * one.seconds, "us", curve.beside, one.reference / one.seconds),
            Row(f"{name}: least", 1e6 * one.least, "us"),
            Row(f"{name}: most", 1e6 * one.most, "us"),
            Row(f"{name}: arrays held", one.held, "byte", "one state message", one.message / one.held),
        ]
    return rows + _law_rows(f"{curve.block}: time", curve.time_law) + _at_paper_size(curve)


def _law_rows(name: str, law: PowerLaw) -> list[Row]:
    parts = (
        {"below the bend": law.below, "above the bend": law.above} if law.bent else {"all sizes": law.above}
    )
    rows = [Row(f"{name}, bend", law.origin, "vehicles")] if law.bent else []
    for where, slope in parts.items():
        half = slope.high - slope.value
        rows += [Row(f"{name}, slope {where}", slope.value, "-"), Row("  its 95 % interval, half", half, "-")]
    return rows


def _at_paper_size(curve: Curve) -> list[Row]:
    law, name = curve.time_law, f"{curve.block}, {PAPER_SIZE} vehicles, reckoned"
    (seconds,) = law.cost(np.array([float(PAPER_SIZE)]))
    low, high = law.cost_interval(PAPER_SIZE)
    return [
        Row(name, 1e3 * seconds, "ms", "a tick of 10 ms", TICK_S / seconds),
        Row(f"{name}: low end of its interval", 1e3 * low, "ms"),
        Row(f"{name}: high end of its interval", 1e3 * high, "ms"),
    ]


def _messages() -> list[Row]:
    """Return the bytes of a tick's messages at PAPER_SIZE, and of a second of them."""
    sizes = {signal.__name__: message_bytes(signal, PAPER_SIZE) for signal in LAYOUTS}
    total = sum(sizes.values())
    rows = [Row(f"{kind} of {PAPER_SIZE} vehicles", size, "byte") for kind, size in sizes.items()]
    return [
        *rows,
        Row(f"messages of {PAPER_SIZE} vehicles, each once a tick", 1e-6 * total / TICK_S, "MB/s"),
    ]


def message_bytes(signal: type, vehicles: int) -> int:
    """Return the bytes of a signal's message."""
    names = tuple(f"cf{k + 1}" for k in range(vehicles))
    arrays = {
        column.attribute: np.zeros(
            (vehicles, column.width), np.uint8 if column.attribute == "status" else np.float64
        )
        for column in LAYOUTS[signal].columns
    }
    return len(encode(signal(t=0.0, names=names, **arrays), 0))
