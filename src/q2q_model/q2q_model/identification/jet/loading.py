"""Growth of a vehicle's downwash with its thrust, from flights of a vehicle under two others.

A source j exposed to downwash e_j itself has the thrust m (g - e_j). By momentum theory its downwash is
proportional to that; in the paper it is constant. With the law f_ij of source j on vehicle i,

    y_i = a (f + l h),   f = sum over j of f_ij,   h = sum over j of f_ij (-e_j / g)

is linear in a and a l. The scale a is fitted too, because otherwise a law that is too weak or too strong
would bias l. Rows in which no source is exposed identify a, the others l.

| symbol | name | meaning [unit] |
|---|---|---|
| y | y | observed vertical push [m/s^2] |
| a | scale | strength on these flights over the law's [-] |
| l | loading | as in q2q_model.downwash.source_strength [-] |
"""

from collections.abc import Sequence

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.identification.jet.jet_fit import BLOCK
from q2q_model.identification.push.along_flight import Motion, eta_on_vehicle
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.identification.statistics.intervals import (
    Interval,
    Stretch,
    cluster_rows,
    intervals,
    least_squares_rows,
)
from q2q_model.signals.values import Array, Rows
from q2q_model.vehicle.constants import GRAVITY

MOST = 2.0
"""Largest loading a controller takes [-]: twice that of momentum theory."""
LEAST_GROWTH = 1e-6
"""Minimum growth of the downwash at a loading of 1, relative, for loading to be identifiable [-]."""


def loading_of(model: InteractionModel, samples: Sequence[PushSamples]) -> Interval | None:
    """Return the loading fitted to exposed rows of whole flights.

    None if no vehicle is under one that is itself under another, or the law vanishes there.
    """
    flights = list(dict.fromkeys(one.flight for one in samples))
    parts = [(flights.index(one.flight), one, np.flatnonzero(one.exposed)) for one in samples]
    parts = [part for part in parts if part[2].size and part[1].motion.pos.shape[1] > 2]
    if not parts:
        return None
    columns = np.concatenate([_push_and_growth(model, one, rows) for _, one, rows in parts])
    if np.linalg.norm(columns[:, 1]) <= LEAST_GROWTH * np.linalg.norm(columns[:, 0]):
        return None
    y = np.concatenate([one.y[rows] for _, one, rows in parts])
    scale, growth = np.linalg.lstsq(columns, y)[0]
    loading = growth / scale
    residual = y - columns @ [scale, growth]
    jacobian = -np.stack([columns @ [1.0, loading], scale * columns[:, 1]], axis=1)
    ends = np.cumsum([rows.size for *_, rows in parts])[:-1]
    stretches = [
        Stretch(flight, one.motion.t[rows], missed)
        for (flight, one, rows), missed in zip(parts, np.split(residual, ends), strict=True)
    ]
    rows = least_squares_rows(jacobian, residual, cluster_rows(stretches, BLOCK))
    return intervals(np.array([scale, loading]), rows)[1]


def usable_loading(loading: Interval | None) -> float:
    """Return the loading for controllers: 0 if unknown or not significant, else at most `MOST`."""
    if loading is None or not loading.is_positive:
        return 0.0
    return min(loading.value, MOST)


def _push_and_growth(model: InteractionModel, one: PushSamples, rows: Rows) -> Array:
    """Return f and h at rows, (k, 2)."""
    n = one.motion.pos.shape[1]
    felt = np.zeros((rows.size, 2))
    for j in (other for other in range(n) if other != one.vehicle):
        push = _vertical(model, one.motion, (one.vehicle, j), rows)
        on_source = sum(
            (_vertical(model, one.motion, (j, k), rows) for k in range(n) if k not in (j, one.vehicle)),
            start=np.zeros(rows.size),
        )
        felt += push[:, None] * np.stack([np.ones_like(push), -on_source / GRAVITY], axis=1)
    return felt


def _vertical(model: InteractionModel, motion: Motion, pair: tuple[int, int], rows: Rows) -> Array:
    """Return the vertical downwash [m/s^2] of pair[1] alone on pair[0], (k,)."""
    both = list(pair)
    two = Motion(motion.t, motion.pos[:, both], motion.vel[:, both], motion.axis[:, both])
    return eta_on_vehicle(model, two, 0, rows)[:, 2]
