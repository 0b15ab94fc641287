"""Page of the demonstration on recorded flights: replay, numbers, measured and predicted downwash, tables."""

from collections.abc import Sequence
from pathlib import Path
from statistics import median_low

from matplotlib.figure import Figure

from q2q_model.documents.written_file import write_text
from q2q_model.identification.jet.held_out_flights import HeldOutFlight, HeldOutScores
from q2q_sim.node_flights.flight_run import FlightRun
from q2q_sim.report.html_page import Grid, Heading, KeyNumber, PageVerdict, Part, Picture, page
from q2q_sim.report.panels import save
from q2q_sim.report.prediction_figure import PredictedPush, prediction_figure
from q2q_sim.report.run_table import run_grid, run_verdicts
from q2q_sim.report.significant_digits import significant_digits
from q2q_sim.tools.demo.demo_flights import key_numbers, plot_runs, replay_of

HEAD = ("flight", "samples under another", "R2", "R2, 20 ms ahead", "model fitted to")
MOST_NAMED = 3
"""Flights of a fit that are named; of more, the number."""


def write_real_page(origin: str, scores: HeldOutScores, runs: Sequence[FlightRun], out: Path) -> None:
    """Write the page: replay, numbers, measured and predicted downwash, tables."""
    shown = median_flight(scores.flights)
    caption = f"{shown.name}, the flight of median R2, predicted by a model of other flights"
    together = scores.together
    parts: list[Part] = [
        origin,
        replay_of(*runs[:2]),
        [
            KeyNumber(
                f"R2 {significant_digits(together.r2_exposed, 2)}",
                f"of the measured downwash, in {len(scores.flights)} flights left out of the fit",
            ),
            *key_numbers(runs[0].metrics, runs[1].metrics),
        ],
        PageVerdict(run_verdicts(runs), all(run.verdict.ok for run in runs)),
        Heading("Recorded downwash, and its prediction"),
        [Picture(save(held_out_figure(shown), out / "prediction.png"), caption)],
        Grid(HEAD, [_row(one) for one in scores.flights]),
        Heading("The model in flight"),
        run_grid(runs),
        plot_runs(runs, out),
    ]
    lead = (
        "A model of the downwash is fitted to recorded flights, scored on flights that it was not fitted to, "
        "and flown by a controller in air that was learned from other real flights."
    )
    html = page("q2q: from recorded flights to a model that flies", lead, parts)
    write_text(html, out / "index.html")
    print(f"page: {out / 'index.html'}")


def median_flight(flights: Sequence[HeldOutFlight]) -> HeldOutFlight:
    """Return the flight of median R2."""
    known = {one.score.r2_exposed: one for one in flights if one.score.r2_exposed is not None}
    return known[median_low(known)]


def held_out_figure(one: HeldOutFlight) -> Figure:
    """Draw measured and predicted downwash of the vehicles that were under another."""
    pushes = [
        PredictedPush(f"{one.name}, vehicle {part.vehicle + 1}", part.motion.t, part.y, part.exposed, eta)
        for part, eta in zip(one.samples, one.predicted, strict=True)
        if part.exposed.any()
    ]
    return prediction_figure(pushes)


def _row(one: HeldOutFlight) -> tuple[str, ...]:
    score = one.score
    r2, ahead = significant_digits(score.r2_exposed), significant_digits(score.r2_ahead_20ms)
    many = len(one.fitted_to) > MOST_NAMED
    fitted_to = f"{len(one.fitted_to)} other flights" if many else ", ".join(one.fitted_to)
    return (one.name, str(score.n), r2, ahead, fitted_to)
