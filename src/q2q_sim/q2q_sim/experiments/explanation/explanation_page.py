"""Page of an explanation: sentence, shares with their intervals, flight with and without the first cause."""

from pathlib import Path

from matplotlib.figure import Figure

from q2q_model import palette
from q2q_model.documents.written_file import write_text
from q2q_model.flights.flight import Flight
from q2q_sim.experiments.explanation.causes import without_causes
from q2q_sim.experiments.explanation.explanation import Explanation
from q2q_sim.experiments.explanation.explanation_sentence import KEPT, explanation_sentence
from q2q_sim.experiments.explanation.flight_setup import FlightSetup, fly_setup
from q2q_sim.experiments.explanation.loss import LOST
from q2q_sim.experiments.explanation.recorded_setup import RecordedSetup
from q2q_sim.replay_page import ReplayRun, in_air, replay_element, replay_run
from q2q_sim.report.html_page import Grid, Heading, Markup, PageVerdict, Part, Picture, page
from q2q_sim.report.panels import panels, save
from q2q_sim.report.significant_digits import CM

HEAD = ("cause", "contribution\n[cm]", "from\n[cm]", "to\n[cm]")
NOTES = (
    "The flight is flown again with its causes removed one after the other, in several orders. The "
    "contribution of a cause is the mean of what removing it changes (Shapley value). Contributions, and the "
    "rest, which is left without any of them, add up to the deviation. A contribution below 0 kept the "
    f"vehicle on its path. The deviation is the largest one of the flight, at most {LOST:g} m."
)


def write_page(found: Explanation, recorded: RecordedSetup, name: str, out: Path) -> Path:
    """Write page and picture of a flight's explanation into a folder; return the page's path."""
    shown = found.shares and save(_bars(found), out / "causes.png")
    rows = [(one.cause, *map(_centimetres, (one.share, one.low, one.high))) for one in found.shares]
    parts: list[Part] = [
        PageVerdict(explanation_sentence(found), ok=found.loss.is_ordinary),
        *([[Picture(shown, "Contributions to the deviation, with 95 % intervals")]] if shown else []),
        *_replay(found, recorded),
        Heading("Contributions"),
        Grid(HEAD, [*rows, ("rest", _centimetres(found.rest), "-", "-")]),
        f"{NOTES} {_interval_note(found)}",
        f"Flown again, the vehicles are within {recorded.difference:.1g} m of their recorded positions.",
    ]
    file = out / "index.html"
    write_text(page(_title(found), f"Flight {name}", parts), file)
    return file


def _title(found: Explanation) -> str:
    loss = found.loss
    return KEPT[loss.kind] if loss.is_ordinary else f"Why did {loss.vehicle} leave its path?"


def _interval_note(found: Explanation) -> str:
    """Return what the intervals are of."""
    sources = [] if found.all_orders else ["other orders"]
    if found.draws > 1:
        sources.append("other draws of noise, losses and gusts")
    if not sources:
        return "All orders were flown with one seed, so the contributions have no interval."
    return f"The 95 % interval is that of {' and '.join(sources)}."


def _centimetres(metres: float) -> str:
    return f"{CM * metres:z.1f}"


def _bars(found: Explanation) -> Figure:
    figure, (axes,) = panels(1)
    shown = found.shares[::-1]
    share = [CM * one.share for one in shown]
    beside = [
        [CM * (one.share - one.low) for one in shown],
        [CM * (one.high - one.share) for one in shown],
    ]
    axes.barh([one.cause for one in shown], share, color=palette.MODEL, xerr=beside, ecolor=palette.BLACK)
    axes.set_axisbelow(True)
    axes.axvline(0.0, color=palette.BLACK, linewidth=0.8)
    axes.set_xlabel("contribution to the deviation [cm]")
    return figure


def _replay(found: Explanation, recorded: RecordedSetup) -> list[Part]:
    """Return the replay of the flight next to that without the first cause, alone if there is none."""
    flights = {"as flown": recorded.flight}
    if found.first is not None:
        removed = fly_setup(without_causes(recorded.setup, {found.first}))
        flights[f"without {found.first}"] = removed
    try:
        replay = replay_element(_runs(flights, recorded.setup))
        return [Heading(" and ".join(flights).capitalize()), Markup(replay)]
    except ValueError as lacking:
        return [f"No replay: {lacking}."]


def _runs(flights: dict[str, Flight], setup: FlightSetup) -> list[ReplayRun]:
    flown = setup.scenario
    return [
        in_air(replay_run(flight, flown.vehicle, name), flown.air or flown.wake)
        for name, flight in flights.items()
    ]
