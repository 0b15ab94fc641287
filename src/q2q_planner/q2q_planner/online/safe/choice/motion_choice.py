"""Choice, for every vehicle, of a motion that is proven against the motions of all others.

Every vehicle has a new motion and the rest of its old one. Who would be too fast or too low on the new one
begins with the old one. If a pair of new motions fails, one of the two vehicles returns to its old motion,
taking turns, and if that does not suffice, so does the other. Old motions were proven against each other, so
this ends with all pairs proven. They are checked again nevertheless: if even they fail, which requires a
broken condition of the promise, both vehicles are BROKEN and fly the new motion, which at least pushes them
apart.

Rows from `own` on are external vehicles, whose motion cannot be chosen. A new motion is proven against every
motion that an external vehicle may fly. An old one was; once the two are `proven`, it is checked only against
the motion that an external vehicle under this law certainly flies (the rows of `old`).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Mask, Rows
from q2q_planner.online.safe.choice.candidate_motions import (
    CandidateMotions,
    PairedTraffic,
    new_motions,
    old_motions,
)
from q2q_planner.online.safe.choice.desired_motion import FLOOR, OUT_OF_BOUNDS, DesiredMotion, Kinds
from q2q_planner.online.safe.motion.committed_motion import MotionRows
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions, stays_out
from q2q_planner.online.safe.stopping.broad_phase import Pairs
from q2q_planner.online.safe.stopping.jerk_limited import StoppingMotions, with_stops
from q2q_planner.online.safe.stopping.jerk_limited_separation import stays_out_jerk_limited
from q2q_planner.online.safe.stopping.overlapping_reaches import near_pairs

OLD, NEW, BROKEN = 0, 1, 2

Choices = NDArray[np.int8]
Proven = Mask


class ChoiceRule(NamedTuple):
    """Rule by which motions are proven and vehicles yield."""

    law: BrakingLaw
    floor: float
    """Distance that a new motion keeps from the zone [m]."""
    hold: float
    """Time for which a new motion is held [s]."""
    turn: int
    """Number of the tick, at any rate: its parity selects the vehicle of a pair that yields first."""


def choice_rule(params: SafeReplannerParams, turn: int) -> ChoiceRule | None:
    """Return the rule of a tick; None if the replanner is off."""
    law = BrakingLaw(params.eps, params.d, params.acc_max, params.jerk_max)
    return ChoiceRule(law, FLOOR, params.hold, turn) if params.enabled else None


class _Selection(NamedTuple):
    """Motions to choose from, and those chosen."""

    new: StoppingMotions
    old: StoppingMotions
    chosen: StoppingMotions
    choice: Choices
    """OLD, NEW or BROKEN, (rows,)."""
    changes: Rows
    """How often each choice has changed, (rows,)."""
    proven: Proven
    """Pairs of the swarm (n,) and external vehicles (m,) proven together before, (n, m)."""


@compiled(**HOT)
def _stays_out(stopping: StoppingMotions, i: int, j: int, law: BrakingLaw, floor: float) -> bool:
    """Return whether a pair is proven to stay apart, by the law's kind of motion."""
    if law.jerk > 0.0:
        return stays_out_jerk_limited(stopping, i, j, law, floor)
    return stays_out(stopping.motions, i, j, law, floor)


@compiled(**HOT)
def _is_proven(selection: _Selection, i: int, j: int, rule: ChoiceRule) -> bool:
    """Return whether the chosen motions of a pair are proven to stay apart; two old ones need no floor."""
    own, choice = selection.proven.shape[0], selection.choice
    both_old = choice[i] == OLD and (
        (j < own and choice[j] == OLD) or (j >= own and selection.proven[i, j - own])
    )
    if both_old:
        return _stays_out(selection.old, i, j, rule.law, 0.0)
    return _stays_out(selection.chosen, i, j, rule.law, rule.floor)


@compiled
def _take(selection: _Selection, taken: StoppingMotions, row: int, choice: int) -> None:
    selection.choice[row] = choice
    selection.changes[row] += 1
    chosen = selection.chosen
    chosen.motions.acc[row] = taken.motions.acc[row]
    chosen.motions.jerk[row] = taken.motions.jerk[row]
    chosen.motions.hold[row] = taken.motions.hold[row]
    if chosen.phases.size > 0:
        chosen.phases[row] = taken.phases[row]


@compiled
def _resolve(selection: _Selection, i: int, j: int, turn: int) -> bool:
    """Return one vehicle of a failed pair to its old motion, else break both; return whether any changed."""
    own = selection.proven.shape[0]
    first, second = (i, j) if (i + j + turn) % 2 == 0 or j >= own else (j, i)
    for row in (first, second):
        if row < own and selection.choice[row] == NEW:
            _take(selection, selection.old, row, OLD)
            return True
    changed = False
    for row in (i, j):
        if row < own and selection.choice[row] == OLD:
            _take(selection, selection.new, row, BROKEN)
            changed = True
    return changed


@compiled
def _sweep(selection: _Selection, pairs: Pairs, near: Rows, checked: Rows, rule: ChoiceRule) -> bool:
    """Resolve the pairs of rows `near` that fail; return whether any choice changed.

    `checked` (k,) counts the changes of both when a pair was last proven: it is proven again if one changed.
    """
    changed = False
    for k in range(near.size):
        i, j = pairs.i[near[k]], pairs.j[near[k]]
        changes = selection.changes[i] + selection.changes[j]
        if changes == checked[k]:
            continue
        checked[k] = changes
        if not _is_proven(selection, i, j, rule) and _resolve(selection, i, j, rule.turn):
            changed = True
    return changed


@compiled
def _record_proven(selection: _Selection, pairs: Pairs, rule: ChoiceRule) -> None:
    """Record which external vehicles the chosen motions are proven against."""
    own = selection.proven.shape[0]
    for row in range(pairs.i.size):
        i, j = pairs.i[row], pairs.j[row] - own
        if j >= 0 and selection.choice[i] != BROKEN and not selection.proven[i, j]:
            selection.proven[i, j] = _stays_out(selection.chosen, i, j + own, rule.law, rule.floor)


@compiled
def choose_motions(candidates: CandidateMotions, pairs: Pairs, proven: Proven, rule: ChoiceRule) -> Choices:
    """Return the choice of each row, (rows,).

    Args:
        candidates: see CandidateMotions.
        pairs: rows i < j, i of the swarm.
        proven: pairs of the swarm (n,) and external vehicles (m,) proven together before, (n, m); updated in
            place.
        rule: see ChoiceRule.
    """
    new, old, kind = candidates
    starts, rests = with_stops(new, rule.law), with_stops(old, rule.law)
    held = Motions(new.pos, new.vel, new.acc.copy(), new.hold.copy(), new.growth, new.jerk.copy())
    chosen = StoppingMotions(held, starts.phases.copy())
    choice = np.full(new.hold.size, NEW, np.int8)
    selection = _Selection(starts, rests, chosen, choice, np.zeros(choice.size, np.intp), proven)
    for row in range(kind.size):
        if kind[row] == OUT_OF_BOUNDS:
            _take(selection, rests, row, OLD)
    near = near_pairs(starts, rests, pairs, rule.law)
    checked = np.full(near.size, -1, np.intp)
    while _sweep(selection, pairs, near, checked, rule):
        pass
    _record_proven(selection, pairs, rule)
    return choice


@compiled
def choices_alone(kind: Kinds) -> Choices:
    """Return the choices of vehicles in no pair, (n,), by the `kind` of their new motions, (n,)."""
    choice = np.full(kind.size, NEW, np.int8)
    choice[kind == OUT_OF_BOUNDS] = OLD
    return choice


@compiled
def choices_at(
    rows: MotionRows, desired: DesiredMotion, traffic: PairedTraffic, proven: Proven, rule: ChoiceRule
) -> Choices:
    """Return the choice of each vehicle of the swarm, (n,): what is built, then what is chosen of it.

    `proven` (n, m) is that of `choose_motions`.
    """
    new = new_motions(traffic.rows, desired, rule.hold)
    old = old_motions(rows, traffic.rows, traffic.certain)
    candidates = CandidateMotions(new, old, desired.kind)
    return choose_motions(candidates, traffic.pairs, proven, rule)[: rows.hold.size]
