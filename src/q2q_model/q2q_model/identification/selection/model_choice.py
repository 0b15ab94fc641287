"""Choice among candidate models by held-out error.

A later candidate, with more parameters, replaces an earlier one only if it lowers the held-out error by more
than `MARGIN`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.forked import forked
from q2q_model.identification.selection.candidate import Candidate
from q2q_model.identification.selection.cross_validation import Score, score_held_out
from q2q_model.identification.selection.identification_data import IdentificationData
from q2q_model.vehicle.altitude_loop import AltitudeLoop

FAILURES = (ValueError, np.linalg.LinAlgError)
"""Exceptions of a fit that fails."""
MARGIN = 0.02
"""Relative reduction of the held-out error required of a model with more parameters [-]."""


@dataclass(frozen=True, slots=True)
class Trial:
    """Candidate and its score on held-out flights."""

    candidate: Candidate
    held_out: Score


def score_candidates(
    tried: Sequence[Candidate],
    flights: Sequence[IdentificationData],
    loop: AltitudeLoop,
    on_step: Callable[[str], None],
) -> tuple[list[Trial], list[str]]:
    """Return each candidate's held-out score, and remarks on those that cannot be fitted.

    `on_step` is called with the name of each candidate before its fit. The last one, which takes about as
    long as all others together, is fitted by a second process meanwhile.
    """
    trials: list[Trial] = []
    remarks: list[str] = []
    works: list[Callable[[], Score]] = [
        partial(score_held_out, candidate.fit, flights, loop) for candidate in tried
    ]
    works[-1] = forked(works[-1])
    for candidate, work in zip(tried, works, strict=True):
        on_step(candidate.name)
        try:
            trials.append(Trial(candidate, work()))
        except FAILURES as failure:
            remarks.append(f"{candidate.name}: dropped, {failure}")
    return trials, remarks


def fit_best(
    trials: Sequence[Trial], flights: Sequence[IdentificationData], failed: Sequence[str] = ()
) -> tuple[Trial, InteractionModel, list[str]]:
    """Return the best trial, its model fitted to all flights, and remarks on better ones that fail to fit.

    `failed` are the remarks on candidates without a trial.

    Raises:
        ValueError: no candidate can be fitted; the message has the reason of each.
    """
    left = list(trials)
    remarks: list[str] = []
    while left:
        best = best_trial(left)
        try:
            return best, best.candidate.fit(flights), remarks
        except FAILURES as failure:
            remarks.append(f"{best.candidate.name}: dropped, {failure}")
            left.remove(best)
    raise ValueError(f"no model can be fitted to these flights: {'; '.join([*failed, *remarks])}")


def best_trial(trials: Sequence[Trial]) -> Trial:
    """Return the trial with the least held-out error, the earlier of two within `MARGIN`."""
    best = trials[0]
    for trial in trials[1:]:
        if trial.held_out.unexplained < (1.0 - MARGIN) * best.held_out.unexplained:
            best = trial
    return best
