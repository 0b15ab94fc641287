"""Figures of an identification, as the paper's Figs 4 to 9."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_model import palette
from q2q_model.documents.written_file import naming_written
from q2q_model.downwash.interaction_model import InteractionModel, downwash_at_rest
from q2q_model.downwash.level_set import peak_downwash
from q2q_model.forked import forked
from q2q_model.identification.deviation import DecayFit
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.impulse_response import downwash_response, undisturbed
from q2q_model.identification.identification import Identification
from q2q_model.identification.push.along_flight import eta_along, motion_along
from q2q_model.identification.selection.identification_data import every_record, is_lower
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop

DPI = 130
"""Dots per inch of the figures: 900 to 1300 pixels wide."""

DrawFigure = Callable[[], Figure]


def draw_all(found: Identification, stem: Path) -> list[Path]:
    """Draw every figure that the flights allow; return the files, whose names begin with `stem`."""
    files = {stem.with_name(f"{stem.name}_{name}.png"): draw for name, draw in _figures(found).items()}
    halves = [{file: files[file] for file in list(files)[first::2]} for first in (0, 1)]
    beside = forked(partial(_save, halves[0]))
    _save(halves[1])
    beside()
    return list(files)


def _save(figures: Mapping[Path, DrawFigure]) -> None:
    for file, draw in figures.items():
        with naming_written(file):
            draw().savefig(file, dpi=DPI, pil_kwargs={"compress_level": 1})


def _figures(found: Identification) -> dict[str, DrawFigure]:
    """Return what draws each figure, by name."""
    figures: dict[str, DrawFigure] = {}
    model, loop = found.file.interaction, found.file.gains
    if found.decay is not None:
        figures["fig4_dev"] = partial(_decay_figure, found.decay)
    if loop is not None:
        calm, pushed = (end(every_record(found.data), key=_largest_push) for end in (min, max))
        figures["fig5_gains"] = partial(_altitude_figure, calm, loop, None, "learned loop, no downwash")
        title = "learned loop and downwash"
        figures["fig6_7_altitude"] = partial(_altitude_figure, pushed, loop, model, title)
    if peak_downwash(model) > 0.0:
        figures["fig8_9_downwash"] = partial(_downwash_figure, model)
    return figures


def _largest_push(record: AltitudeRecord) -> float:
    return float(np.abs(record.deviation).max())


def _decay_figure(decay: DecayFit) -> Figure:
    figure, axes = _axes(
        "Deviation under another vehicle (Fig 4)", "average height difference [m]", "dev [m]"
    )
    gaps = np.array([overlap.gap for overlap in decay.overlaps])
    axes.plot(gaps, [overlap.dev for overlap in decay.overlaps], "o", color=palette.MEASURED, label="flights")
    along = np.linspace(0.0, 1.5 * gaps.max(), 200)
    curve = decay.alpha.value * np.exp(-decay.beta.value * along)
    axes.plot(along, curve, color=palette.MODEL, label="alpha exp(-beta dz)")
    axes.legend()
    return figure


def _altitude_figure(
    record: AltitudeRecord, loop: AltitudeLoop, model: InteractionModel | None, title: str
) -> Figure:
    n = len(record.names)
    deviation = undisturbed(record, loop)
    if model is not None:
        eta = eta_along(model, motion_along(record))[..., 2]
        deviation = deviation + downwash_response(loop, record.dt, eta)
    figure = Figure(figsize=(9.0, 2.8 * n))
    figure.subplots_adjust(left=0.09, right=0.98, top=1.0 - 0.2 / n, bottom=0.18 / n, hspace=0.08)
    figure.suptitle(f"{record.name}: {title}", x=0.09, ha="left")
    lines = np.stack([record.ref[:, :, 0], record.pos[:, :, 2], record.ref[:, :, 0] + deviation])  # (3, T, n)
    for i, axes in enumerate(figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0]):
        role = f" ({'lower' if is_lower(record)[i] else 'upper'})" if n > 1 else ""
        axes.plot(record.t, lines[0, :, i], "--", color=palette.REFERENCE, label="reference", zorder=4.0)
        axes.plot(record.t, lines[1, :, i], color=palette.MEASURED, label="measured")
        axes.plot(record.t, lines[2, :, i], color=palette.MODEL, label="simulated")
        axes.set(ylabel=f"{record.names[i]}{role}: z [m]", ylim=_one_span(lines, i))
        axes.grid(alpha=0.3)
    axes.set_xlabel("t [s]")
    figure.legend(*axes.get_legend_handles_labels(), loc="upper right", ncols=3, frameon=False)
    return figure


def _one_span(lines: Array, i: int) -> tuple[float, float]:
    """Return the limits of axis i [m]: the same span around each vehicle's `lines` (..., n)."""
    low, high = (np.asarray(end(lines, axis=(0, 1))) for end in (np.nanmin, np.nanmax))
    half = 0.55 * float((high - low).max())
    return 0.5 * (low[i] + high[i]) - half, 0.5 * (low[i] + high[i]) + half


def _downwash_figure(model: InteractionModel) -> Figure:
    """Return a map of eta on the lower and the upper vehicle over relative position (Figs 8 and 9)."""
    figure = Figure(figsize=(10.0, 4.2))
    figure.subplots_adjust(left=0.07, right=0.92, top=0.92, bottom=0.13, wspace=0.15)
    across, gap = np.linspace(0.0, 0.4, 81), np.linspace(0.1, 1.5, 141)
    maps = [_grid(model, across, sign * gap) for sign in (1.0, -1.0)]
    most = float(np.abs(maps).max())
    both = figure.subplots(1, 2, sharey=True)
    for axes, eta, title in zip(both, maps, ("lower", "upper"), strict=True):
        drawn = axes.pcolormesh(across, gap, eta, cmap="PuOr", vmin=-most, vmax=most, shading="auto")
        axes.set(title=f"downwash on the {title} vehicle", xlabel="horizontal distance [m]")
    both[0].set_ylabel("height difference [m]")
    figure.colorbar(drawn, ax=both, label="eta z [m/s²], downwards negative", fraction=0.05, pad=0.02)
    return figure


def _grid(model: InteractionModel, across: Array, dz: Array) -> Array:
    x, z = np.meshgrid(across, dz)
    rel_pos = np.stack([x, np.zeros_like(x), z], axis=-1)
    return np.asarray(downwash_at_rest(model, rel_pos)[..., 2])


def _axes(title: str, x: str, y: str) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(7.0, 4.0))
    figure.subplots_adjust(left=0.11, right=0.97, top=0.92, bottom=0.13)
    axes = figure.add_subplot()
    axes.set(title=title, xlabel=x, ylabel=y)
    axes.grid(alpha=0.3)
    return figure, axes
