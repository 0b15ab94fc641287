"""Rules of two vehicles: collision, downwash."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.licence.room.licence_log import LicenceLog
from q2q_sim.licence.room.trials import TrialKind
from q2q_sim.licence.rules.broken_rule import BrokenRule, first_lasting_tick, first_tick
from q2q_sim.licence.rules.licence_causes import failure_cause
from q2q_sim.licence.rules.licence_limits import LicenceLimits


def nearness(log: LicenceLog, limits: LicenceLimits) -> Iterator[BrokenRule | None]:
    """Return which vehicles collide, or fly in the downwash of another."""
    for i, j in combinations(range(len(log.uris)), 2):
        apart = log.pos[:, i] - log.pos[:, j]
        flying = log.airborne[:, i] | log.airborne[:, j]
        tick = first_tick(np.asarray(flying & (np.linalg.norm(apart, axis=-1) < limits.gap)))
        if tick >= 0:
            t = float(log.t[tick])
            why = "; ".join(
                f"for {log.name(row)}, {failure_cause(log, row, t)}"
                for row in (i, j)
                if log.airborne[tick, row]
            )
            lost = log.trial.kind == TrialKind.LOST and log.trial.exempt in {i, j}
            yield BrokenRule("collision", t, f"{log.name(i)} and {log.name(j)} collide", why, remark=lost)
        elif log.trial.kind == TrialKind.NOMINAL:
            yield _exposure(log, (i, j), apart, limits)


def _exposure(
    log: LicenceLog, pair: tuple[int, int], apart: Array, limits: LicenceLimits
) -> BrokenRule | None:
    i, j = pair
    scaled = apart / np.array([limits.beside, limits.beside, limits.below])
    inside = (np.linalg.norm(scaled, axis=-1) < 1.0) & log.airborne[:, i] & log.airborne[:, j]
    tick = first_lasting_tick(inside, round(limits.exposed_s / log.tick))
    if tick < 0:
        return None
    below, above = (i, j) if apart[tick, 2] < 0.0 else (j, i)
    t, depth = float(log.t[tick]), abs(float(apart[tick, 2]))
    what = f"{log.name(below)} flies in the downwash of {log.name(above)}, {depth:.2f} m below it"
    return BrokenRule("downwash", t, what, failure_cause(log, below, t))
