"""Markdown page of the robustness: a table for each controller, perturbations by airs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from q2q_sim.experiments.robustness.perturbations import PERTURBATIONS, without_model_errors
from q2q_sim.experiments.robustness.perturbed_flight import Errors, PerturbedFlight
from q2q_sim.report.markdown_table import markdown_table
from q2q_sim.report.significant_digits import MM

MORE = 1.05
"""Largest error over that of ignoring that counts as not worse [-]."""
READING = """\
Cells: rms height error under another vehicle [mm], and in brackets its ratio to that of the same controller
without compensation, in the same room with the same noise. A ratio above 1.05 is **bold**. Model:
`measured_law` (in air `paper`: `paper_law`), changed as in the row; other changes are unknown to the
controller. Thrust is that of the stock firmware, 1.32 times the weight for an offboard command. Paths are
flown in half the time of the scenario.

- *residual error*: rms height error in the last 2 s, at least 2 s after the last passage [mm], in the air
  model where it is largest with compensation; beside it that without compensation in the same air. It shows
  wind-up and limit cycles, and is in no ratio or verdict below.
- *floor*: thrust does not carry the vehicles, so none is left under another. In bold if thrust carries them
  without compensation.

Flights per cell:"""


def flight_key(asked: PerturbedFlight) -> str:
    """Return the name of a flight."""
    one = asked.perturbation
    way = "corrected" if asked.corrects else "ignoring"
    faults = "+".join(fault.kind for fault in one.faults)
    numbers = f"{one.strength:g} {one.delay:g} {one.latency:g} {int(one.silent)} {faults}"
    return f"{asked.air}|{asked.controller} {way}|{one.scenario} {numbers}"


def ignoring_flight(asked: PerturbedFlight) -> PerturbedFlight:
    """Return the flight to compare with."""
    return replace(asked, perturbation=without_model_errors(asked.perturbation), corrects=False)


def page(
    found: Mapping[str, Errors], flights: Sequence[PerturbedFlight], command: str, flown: str = ""
) -> str:
    """Return the page of the corrected `flights` whose errors, and those of ignoring, are in `found`.

    `flown` says when, and by which commits.
    """
    draws, seed = flights[0].draws, flights[0].seed
    made = f"Made by `{command}`; do not edit." + (f" Flown {flown}." if flown else "")
    parts = ["# Robustness", made, f"{READING} {draws} draws side by side, seed {seed}."]
    for controller in dict.fromkeys(one.controller for one in flights):
        own = [one for one in flights if one.controller == controller]
        parts += [f"## `{controller}` with `correct`", _table(found, own), _verdict(found, own)]
    return "\n\n".join(parts) + "\n"


def _table(found: Mapping[str, Errors], flights: Sequence[PerturbedFlight]) -> str:
    airs = list(dict.fromkeys(one.air for one in flights))
    rows = []
    for wanted in PERTURBATIONS:
        cells = {one.air: one for one in flights if one.perturbation == wanted}
        if cells:
            rows.append(_row(found, airs, cells))
    return markdown_table(["perturbation", *airs, "residual error"], rows, 1)


def _row(found: Mapping[str, Errors], airs: Sequence[str], cells: Mapping[str, PerturbedFlight]) -> list[str]:
    """Return a row; the cell of an air that was not flown is empty."""
    own = {air: found[flight_key(one)] for air, one in cells.items()}
    other = {air: found[flight_key(ignoring_flight(one))] for air, one in cells.items()}
    words = [_cell(own[air], other[air]) if air in own else "" for air in airs]
    worst = max(own, key=lambda air: own[air].left)
    most = [MM * errors[worst].left for errors in (own, other)]
    name = next(iter(cells.values())).perturbation.name
    return [name, *words, f"{most[0]:.0f}, {most[1]:.0f}"]


def _cell(own: Errors, other: Errors) -> str:
    if math.isnan(own.under):
        return "**floor**" if _is_worse(own, other) else "floor"
    text = f"{MM * own.under:.1f} ({own.under / other.under:.2f})"
    return f"**{text}**" if _is_worse(own, other) else text


def _is_worse(own: Errors, other: Errors) -> bool:
    """Return whether errors are above those of ignoring; NaN is that of vehicles on the floor."""
    if math.isnan(own.under):
        return not math.isnan(other.under)
    return own.under > MORE * other.under


def _verdict(found: Mapping[str, Errors], flights: Sequence[PerturbedFlight]) -> str:
    worse = [
        f"{one.perturbation.name} in `{one.air}`"
        for one in flights
        if _is_worse(found[flight_key(one)], found[flight_key(ignoring_flight(one))])
    ]
    if worse:
        return f"Worse under another vehicle than without compensation: {', '.join(worse)}."
    return "Under another vehicle never worse than without compensation."
