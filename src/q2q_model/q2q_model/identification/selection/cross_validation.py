"""Cross-validation of interaction models over whole flights.

Each fold of flights is scored by the model fitted on the others, with two scores for each role:

    mse     mean square of z - z_free - (h * eta)      altitudes, loss (16)
    r2      1 - sum (y - eta)^2 / sum y^2              pushes: lower on exposed rows, upper on upper rows
            1 - mse / mse without downwash                altitudes, if no pushes were measured
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.identification.gains.impulse_response import downwash_response, undisturbed
from q2q_model.identification.push.along_flight import eta_along, eta_on_vehicle, motion_along
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.identification.selection.identification_data import IdentificationData, is_lower
from q2q_model.model_files.model_file import RoleScores
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.altitude_loop import AltitudeLoop

MOST_FOLDS = 3
"""Most folds; each costs a fit to at least two thirds of the flights."""

R2Quantity = Literal["downwash", "altitude deviation"]
"""Quantity that R2 is of: the measured downwash, or altitude where no downwash was measured."""
Fitter = Callable[[Sequence[IdentificationData]], InteractionModel]


@dataclass(frozen=True, slots=True)
class Score:
    """Scores of a model on held-out flights."""

    mse_m2: RoleScores
    r2: RoleScores
    r2_of: R2Quantity = "downwash"

    @property
    def unexplained(self) -> float:
        """Return the unexplained share of the lower vehicle's `r2_of`, which selection minimises."""
        return 1.0 - self.r2.lower if self.r2.lower is not None else float("inf")


@dataclass(frozen=True, slots=True)
class _Sums:
    """Sums of squares (missed, total) and counts, for the lower and the upper role."""

    altitude: Array
    """(2 roles, missed total count)."""
    push: Array
    """(2, missed total)."""


def score_held_out(fit: Fitter, flights: Sequence[IdentificationData], loop: AltitudeLoop) -> Score:
    """Return the score on held-out flights; empty for a single flight."""
    folds = min(MOST_FOLDS, len(flights))
    if folds < 2:
        return Score(RoleScores(), RoleScores())
    parts = []
    for k in range(folds):
        model = fit([one for index, one in enumerate(flights) if index % folds != k])
        parts += [_sums(model, one, loop) for one in flights[k::folds]]
    return _score(parts)


def score_on(model: InteractionModel, flights: Sequence[IdentificationData], loop: AltitudeLoop) -> Score:
    """Return the score of a model on flights."""
    return _score([_sums(model, one, loop) for one in flights])


def _sums(model: InteractionModel, flight: IdentificationData, loop: AltitudeLoop) -> _Sums:
    altitude, push = np.zeros((2, 3)), np.zeros((2, 2))
    for record in flight.records:
        free = record.deviation - undisturbed(record, loop)
        missed = free - downwash_response(loop, record.dt, eta_along(model, motion_along(record))[..., 2])
        for i, lower in enumerate(is_lower(record)):
            sums = [missed[:, i] @ missed[:, i], free[:, i] @ free[:, i], free.shape[0]]
            altitude[0 if lower else 1] += sums
    for one in flight.pushes:
        push[0] += _push_sums(model, one, one.exposed)
        push[1] += _push_sums(model, one, one.upper)
    return _Sums(altitude, push)


def _push_sums(model: InteractionModel, one: PushSamples, mask: Mask) -> Array:
    rows = np.nonzero(mask)[0]
    y = one.y[rows]
    miss = y - eta_on_vehicle(model, one.motion, one.vehicle, rows)[:, 2]
    return np.array([miss @ miss, y @ y])


def _score(parts: Sequence[_Sums]) -> Score:
    altitude = np.sum([part.altitude for part in parts], axis=0)
    push = np.sum([part.push for part in parts], axis=0)
    mse = [float(a[0] / a[2]) if a[2] > 0.0 else None for a in altitude]
    r2_of: R2Quantity = "downwash" if push[0, 1] > 0.0 else "altitude deviation"
    sums = push if r2_of == "downwash" else altitude[:, :2]
    r2 = [float(1.0 - a[0] / a[1]) if a[1] > 0.0 else None for a in sums]
    return Score(RoleScores(*mse), RoleScores(*r2), r2_of)
