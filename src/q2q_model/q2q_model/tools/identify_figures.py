"""Figures of an identification, as the paper's Figs 4 to 9."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from q2q_model.downwash.interaction_model import InteractionModel, at_rest
from q2q_model.identification.flight_evidence import FlightEvidence, is_lower
from q2q_model.identification.force.along_flight import eta_along
from q2q_model.identification.gains.impulse_response import downwash_response, free_response
from q2q_model.identification.identification import Identification
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop

DPI = 130
MEASURED, SIMULATED, REFERENCE = "#1f77b4", "#c0392b", "#555555"


def draw_all(found: Identification, stem: Path) -> list[Path]:
    """Draw every figure that the flights allow; return the files, whose names begin with `stem`."""
    figures = {} if found.decay is None else {"fig4_dev": _decay_figure(found)}
    loop = found.file.gains
    flight = max(found.evidence, key=_largest_push)
    if loop is not None:
        calm = min(found.evidence, key=_largest_push)
        figures["fig5_gains"] = _altitude_figure(calm, loop, None, "learned loop, no downwash")
        figures["fig6_7_altitude"] = _altitude_figure(
            flight, loop, found.file.interaction, "learned loop and downwash"
        )
    figures["fig8_9_downwash"] = _downwash_figure(found.file.interaction)
    paths = [stem.with_name(f"{stem.name}_{name}.png") for name in figures]
    for path, figure in zip(paths, figures.values(), strict=True):
        figure.savefig(path, dpi=DPI, pil_kwargs={"compress_level": 1})
    return paths


def _largest_push(flight: FlightEvidence) -> float:
    return float(np.abs(flight.record.deviation).max())


def _decay_figure(found: Identification) -> Figure:
    figure, axes = _axes(
        "Deviation under another vehicle (Fig 4)", "average height difference [m]", "dev [m]"
    )
    decay = found.decay
    if decay is not None:
        gaps = np.array([overlap.gap for overlap in decay.overlaps])
        axes.plot(gaps, [overlap.dev for overlap in decay.overlaps], "o", color=MEASURED, label="flights")
        along = np.linspace(0.0, 1.5 * gaps.max(), 200)
        curve = decay.alpha.value * np.exp(-decay.beta.value * along)
        axes.plot(along, curve, color=SIMULATED, label="alpha exp(-beta dz)")
        axes.legend()
    return figure


def _altitude_figure(
    flight: FlightEvidence, loop: AltitudeLoop, model: InteractionModel | None, title: str
) -> Figure:
    record, n = flight.record, len(flight.record.names)
    deviation = free_response(loop, record.dt, record.start, record.jerk)
    if model is not None:
        deviation = deviation + downwash_response(loop, record.dt, eta_along(model, flight.motion)[..., 2])
    figure = Figure(figsize=(9.0, 2.8 * n))
    figure.subplots_adjust(left=0.09, right=0.98, top=1.0 - 0.2 / n, bottom=0.18 / n, hspace=0.08)
    figure.suptitle(f"{record.name}: {title}")
    for i, axes in enumerate(figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0]):
        role = "lower" if is_lower(record)[i] else "upper"
        axes.plot(record.t, record.ref[:, i, 0], "--", color=REFERENCE, label="reference")
        axes.plot(record.t, record.pos[:, i, 2], color=MEASURED, label="measured")
        axes.plot(record.t, record.ref[:, i, 0] + deviation[:, i], color=SIMULATED, label="simulated")
        axes.set_ylabel(f"{record.names[i]} ({role}): z [m]")
        axes.grid(alpha=0.3)
        axes.legend(loc="upper right")
    axes.set_xlabel("t [s]")
    return figure


def _downwash_figure(model: InteractionModel) -> Figure:
    """Return a map of eta on the lower and the upper vehicle over relative position (Figs 8 and 9)."""
    figure = Figure(figsize=(10.0, 4.2))
    figure.subplots_adjust(left=0.07, right=0.97, top=0.92, bottom=0.13, wspace=0.32)
    across = np.linspace(0.0, 0.4, 81)
    for axes, sign, title in zip(figure.subplots(1, 2), (1.0, -1.0), ("lower", "upper"), strict=True):
        gap = np.linspace(0.1, 1.5, 141)
        eta = _grid(model, across, sign * gap)
        drawn = axes.pcolormesh(across, gap, eta, cmap="viridis", shading="auto")
        figure.colorbar(drawn, ax=axes, label="eta z [m/s²]")
        axes.set(
            title=f"downwash on the {title} vehicle", xlabel="across [m]", ylabel="height difference [m]"
        )
    return figure


def _grid(model: InteractionModel, across: Array, dz: Array) -> Array:
    x, z = np.meshgrid(across, dz)
    rel_pos = np.stack([x, np.zeros_like(x), z], axis=-1)
    return np.asarray(model.acceleration(rel_pos, at_rest(rel_pos))[..., 2])


def _axes(title: str, x: str, y: str) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(7.0, 4.0))
    figure.subplots_adjust(left=0.11, right=0.97, top=0.92, bottom=0.13)
    axes = figure.add_subplot()
    axes.set(title=title, xlabel=x, ylabel=y)
    axes.grid(alpha=0.3)
    return figure, axes
