"""Page of a validation: verdict, numbers, and recorded and simulated errors over each other."""

from collections.abc import Sequence
from pathlib import Path

from q2q_model.documents.written_file import write_text
from q2q_sim.experiments.validation.error_figures import error_figure, spectrum_figure
from q2q_sim.experiments.validation.error_statistics import (
    Comparison,
    ErrorSums,
    comparison,
    flight_intervals,
)
from q2q_sim.experiments.validation.flight_alone import ComparedAlone
from q2q_sim.experiments.validation.validated_flight import (
    COVERAGE,
    RMS_RATIO,
    SPECTRUM_DB,
    ValidatedFlight,
    is_told_apart,
    pooled_comparison,
    validation_sentence,
)
from q2q_sim.experiments.validation.validation_replay import longest_under_wake, replayed_runs
from q2q_sim.replay_page import replay_element
from q2q_sim.report.html_page import Grid, Heading, Markup, PageVerdict, Part, Picture, page
from q2q_sim.report.panels import picture_file, save
from q2q_sim.report.significant_digits import significant_digits

HEAD = (
    "flight",
    "rows",
    "recorded rms [cm]",
    "rms ratio",
    "correlation",
    "spectrum [dB]",
    "in band [%]",
    "worst ratio",
)
LEAD = "Recorded flights, flown again in simulated air and compared by their height errors."
NOTES = (
    "Each recorded flight is flown again by its own control law, read from its thrust commands, along its "
    "recorded references. The height error is altitude minus its reference. Ratios are simulated over "
    "recorded; the spectrum is the largest difference of power in an octave band from 0.2 to 10 Hz; the band "
    "is the one that holds 95 % of a further draw."
)
TARGETS = (
    f"Targets under a wake: rms ratio {RMS_RATIO[0]} to {RMS_RATIO[1]}, spectrum within "
    f"{SPECTRUM_DB:.0f} dB, {COVERAGE[0]:.0%} to {COVERAGE[1]:.0%} of the recorded samples in the band."
)
ALONE_NOTES = (
    "Flights of one vehicle whose log has setpoints but no thrust commands: flown again along the setpoints "
    "by the emulated firmware's position PID, from the recorded first state."
)


def write_page(
    flights: Sequence[ValidatedFlight],
    alone: Sequence[ComparedAlone],
    air: str,
    out: Path,
    notes: Sequence[str] = (),
) -> Path:
    """Draw the pictures into a folder and write the page there, with notes; return its path."""
    under = [part for one in flights for part in one.under]
    clear = [part for one in flights for part in one.clear]
    spectra = [
        Picture(save(spectrum_figure(parts, title), out / f"spectrum_{name}.png"), f"All flights, {title}")
        for name, title, parts in (("wake", "under a wake", under), ("clear", "in clear air", clear))
        if any(part.power.any() for part in parts)
    ]
    curves = [
        Picture(save(error_figure(one), picture_file(out, one.flight.name)), one.flight.name)
        for one in flights
        if any(part.n for part in (*one.under, *one.clear))
    ]
    whole = pooled_comparison(flights)
    parts: list[Part] = [
        PageVerdict(validation_sentence(whole), whole.n == 0 or not is_told_apart(whole)),
        *notes,
        *_replay(flights),
        TARGETS,
        *_table("Under a wake", [(one.flight.name, comparison(one.under)) for one in flights], under),
        *([_interval_text(flight_intervals([one.under for one in flights]))] if flights else []),
        *_table("In clear air", [(one.flight.name, comparison(one.clear)) for one in flights], clear),
        *([spectra] if spectra else []),
        *_titled("Height error of each flight", curves),
        *_alone_panel(alone, out),
        NOTES,
    ]
    file = out / "index.html"
    write_text(page(f"Validation of {air}", LEAD, parts), file)
    return file


def _replay(flights: Sequence[ValidatedFlight]) -> list[Part]:
    """Return the replay of the flight with the longest time under a wake, empty without any flight."""
    if not flights:
        return []
    shown = longest_under_wake(flights)
    title = Heading(f"{shown.flight.name}, recorded and flown again")
    try:
        return [title, Markup(replay_element(replayed_runs(shown)))]
    except ValueError as lacking:
        return [title, f"No replay: {lacking}."]


def _titled(title: str, pictures: Sequence[Picture]) -> list[Part]:
    """Return pictures under a heading, empty without any."""
    return [Heading(title), pictures] if pictures else []


def _table(title: str, flights: Sequence[tuple[str, Comparison]], parts: Sequence[ErrorSums]) -> list[Part]:
    """Return title and table of the flights that are compared, empty without any."""
    rows = _rows(flights, comparison(parts))
    return [Heading(title), Grid(HEAD, rows)] if rows else []


def _alone_panel(alone: Sequence[ComparedAlone], out: Path) -> list[Part]:
    """Return table and spectra of the flights of one vehicle alone, empty without any."""
    if not alone:
        return []
    height, lateral = [one.vertical for one in alone], [one.lateral for one in alone]
    rows = _rows([(one.name, comparison([one.vertical])) for one in alone], comparison(height))
    spectra = [
        Picture(save(spectrum_figure(parts, title), out / f"spectrum_alone_{name}.png"), f"Alone, {title}")
        for name, title, parts in (("height", "height", height), ("lateral", "x and y", lateral))
        if any(part.power.any() for part in parts)
    ]
    beside = _row("all, x and y", comparison(lateral))
    table = Grid(HEAD, [*rows, beside])
    return [Heading("One vehicle alone"), ALONE_NOTES, table, *([spectra] if spectra else [])]


def _rows(flights: Sequence[tuple[str, Comparison]], whole: Comparison) -> list[tuple[str, ...]]:
    """Return the cells of the compared flights, then of all together."""
    return [_row(name, one) for name, one in (*flights, ("all", whole)) if one.n]


def _row(name: str, one: Comparison) -> tuple[str, ...]:
    recorded = None if one.z_rms_recorded_m is None else 100.0 * one.z_rms_recorded_m
    inside = None if one.coverage95 is None else 100.0 * one.coverage95
    numbers = (recorded, one.z_rms_ratio, one.correlation, one.spectrum_db, inside, one.worst_ratio)
    return (name, str(one.n), *(significant_digits(value, 2) for value in numbers))


def _interval_text(intervals: dict[str, tuple[float, float]]) -> str:
    if not intervals:
        return "Fewer than three flights have a wake: no intervals."
    words = [f"{name} {low:.2f} to {high:.2f}" for name, (low, high) in intervals.items()]
    return f"95 % intervals of all together, by a bootstrap over flights: {', '.join(words)}."
