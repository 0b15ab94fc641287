"""Doubts of an identified model: why it is not to be flown with, as far as its flights show it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.identification.gains.command_gains import GainFit
from q2q_model.identification.jet.jet_form import FREE_PARAMETERS
from q2q_model.identification.push.along_flight import eta_along, motion_along
from q2q_model.identification.selection.cross_validation import Score
from q2q_model.identification.selection.identification_data import (
    IdentificationData,
    every_record,
)
from q2q_model.identification.statistics.intervals import Interval

MEASURED = "record the topics command and state, or command and imu, which measure it"
SHOWN = 0.2
"""R2 on its own flights from which a model shows downwash, however uncertain its strength [-].

Of one recorded flight with downwash it is 0.55 or more, of made ones without, in calm air, 0.07 or less. The
strength alone may be unknown there: at one gap, a larger virtual origin has the same downwash.
"""


@dataclass(frozen=True, slots=True)
class Scores:
    """Scores of a model."""

    train: Score
    """On the flights that it is fitted to."""
    held_out: Score


def model_doubts(
    gains: GainFit,
    scores: Scores,
    data: Sequence[IdentificationData],
    model: InteractionModel,
    spread: Mapping[str, Interval],
) -> list[str]:
    """Return the doubts of a model with these scores and these intervals of its parameters."""
    if isinstance(model, NoInteraction):
        return []
    return [
        *_doubts_of_gains(gains, data),
        *_doubts_of_score(scores.held_out, len(data)),
        *(_doubts_of_sign(model, data) or _doubts_of_intervals(spread, scores.train)),
    ]


def _doubts_of_gains(gains: GainFit, data: Sequence[IdentificationData]) -> list[str]:
    known = gains.k_p.is_positive and gains.k_d.is_positive
    if known or any(one.pushes for one in data):
        return []
    return [
        "the downwash is inferred with gains that these flights do not determine, and is just as uncertain: "
        + MEASURED
    ]


def _doubts_of_score(held_out: Score, flights: int) -> list[str]:
    share = held_out.r2.lower
    if flights < 2:
        return [
            "no flight was left out, so the model's accuracy on other flights is unknown: give two or more"
        ]
    if share is not None and share <= 0.0:
        return [f"on flights left out the model is no better than none (R2 {share:.3f}): do not use it"]
    return []


def _doubts_of_sign(model: InteractionModel, data: Sequence[IdentificationData]) -> list[str]:
    """Return a doubt if the model lifts the vehicles of these flights: downwash pushes them down."""
    eta = [eta_along(model, motion_along(record))[..., 2].ravel() for record in every_record(data)]
    lift = float(np.concatenate(eta).mean())
    if lift <= 0.0:
        return []
    return [
        (
            "the model lifts vehicles that are under others, which downwash does not (on average of these "
            f"flights {lift:.3g} m/s^2): do not compensate with it. Check that z is up, that the force in a "
            "log (faz_est) is positive upwards, and that the accelerometer shows 9.81 m/s^2 upwards at rest"
        )
    ]


def _doubts_of_intervals(spread: Mapping[str, Interval], train: Score) -> list[str]:
    """Return a doubt if the downwash may be none, else one on what the flights do not determine."""
    strength = spread.get("strength")
    if strength is not None and strength.low <= 0.0 and (train.r2.lower or 0.0) < SHOWN:
        return [
            (
                f"these flights do not show downwash (strength {strength.value:.3g} m/s^2 "
                f"[{strength.low:.3g}, {strength.high:.3g}]): do not compensate with the model; fly more "
                "passes of one vehicle under another"
            )
        ]
    unknown = [name for name, one in spread.items() if _is_anything(name, one)]
    doubts = []
    if unknown:
        which = ", ".join(unknown)
        doubts = [f"these flights do not determine {which}: the interval is the range of the search"]
    if strength is not None and strength.low <= 0.0 and "strength" not in unknown:
        ends = f"[{strength.low:.3g}, {strength.high:.3g}]"
        doubts.append(f"these flights do not determine strength: its interval {ends} m/s^2 contains 0")
    return doubts


def _is_anything(name: str, one: Interval) -> bool:
    """Return whether an interval is the whole range of the search."""
    allowed = FREE_PARAMETERS[name]
    return one.low <= allowed.low and one.high >= allowed.high
