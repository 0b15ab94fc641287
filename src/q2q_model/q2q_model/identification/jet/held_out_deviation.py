"""Deviation of a jet from cross-validation over two halves of the flights."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.jet_deviation import affine_deviation, pushes_and_errors
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.push.push_samples import PushSamples


def with_held_out_deviation(jet: Jet, samples: Sequence[PushSamples], form: JetForm) -> Jet:
    """Return a jet whose deviation comes from cross-validation over two halves of the flights.

    A single flight is split at the median time of its exposed rows. Without exposed rows in both halves, the
    jet keeps the deviation of its training residuals.
    """
    halves = _halves(samples)
    if not all(any(one.exposed.any() for one in half) for half in halves):
        return jet
    parts = [pushes_and_errors(fit_to_pushes(halves[1 - k], form).jet, halves[k]) for k in (0, 1)]
    floor, share = affine_deviation(*(np.concatenate(some) for some in zip(*parts, strict=True)))
    return replace(jet, std_floor=floor, relative_std=share)


def _halves(samples: Sequence[PushSamples]) -> list[list[PushSamples]]:
    """Return the samples of each half of the flights, or of the only flight with exposed rows."""
    flights = list(dict.fromkeys(one.flight for one in samples if one.exposed.any()))
    if len(flights) > 1:
        return [[one for one in samples if one.flight in flights[k::2]] for k in (0, 1)]
    own = [one for one in samples if one.flight in flights]
    middle = float(np.median(np.concatenate([one.motion.t[one.exposed] for one in own]))) if own else 0.0
    early = [one.motion.t < middle for one in own]
    return [
        [
            replace(one, exposed=one.exposed & rows, upper=one.upper & rows)
            for one, rows in zip(own, half, strict=True)
        ]
        for half in (early, [~rows for rows in early])
    ]
