"""Bounds of what a model of a file or a topic may predict, whatever its numbers are.

    |eta| <= 5 g    at rest and climbing, from CONTACT to the model's reach, above and below the source

A hovering source gives its air the momentum m g in a second. A vehicle of its mass that stops all of this air
feels g, one that turns it back 2 g; a fit to flights 0.4 m below each other gives up to twice that at
contact, by the square of the distance. Controllers follow what a model predicts, up to full thrust, so one
that predicts more is not flown with, nor one whose air arrives after more than LONGEST_S: the positions of
all vehicles are remembered for as long.
"""

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel, PairMotion
from q2q_model.geometry.rotations import UP
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CONTACT, GRAVITY

LARGEST = 5.0 * GRAVITY
"""[m/s^2]"""
LONGEST_S = 10.0
"""Longest transport delay [s]: over 10 m, the largest range of a jet, at 1 m/s."""
CLIMB = 0.5
"""Climb rate of a vehicle that meets the air of one above [m/s]."""
ASIDE = (0.0, 0.05, 0.1, 0.2)
"""Horizontal distances that are looked at [m]; a jet is strongest on its axis, a network anywhere."""
GAPS = 100
"""Height differences that are looked at, each way."""


def check_model(model: InteractionModel) -> None:
    """Raise ValueError if a model predicts more than LARGEST, or has a delay beyond LONGEST_S."""
    if not model.max_delay <= LONGEST_S:
        raise ValueError(f"model: its delay is {model.max_delay:.3g} s; must be at most {LONGEST_S:g} s")
    _check_push(model)


def _check_push(model: InteractionModel) -> None:
    rel_pos = _places(model.reach.vertical)
    if not rel_pos.size:
        return
    still = np.zeros_like(rel_pos)
    for vel in (still, still + CLIMB * UP):
        push = np.abs(model.acceleration(rel_pos, PairMotion(still, still + UP, vel))).max(axis=1)
        worst = int(np.argmax(np.where(np.isnan(push), np.inf, push)))
        if not push[worst] <= LARGEST:
            side = "above" if rel_pos[worst, 2] > 0.0 else "below"
            raise ValueError(
                f"model: a source {abs(rel_pos[worst, 2]):.2f} m {side} a vehicle accelerates it by "
                f"{push[worst]:.3g} m/s^2; must be at most {LARGEST:.1f} (5 g): identify it again"
            )


def _places(reach: float) -> Array:
    """Return the relative positions of sources that are looked at [m], (p, 3)."""
    up = np.linspace(CONTACT, reach, GAPS) if reach > CONTACT else np.zeros(0)
    aside, gap = np.meshgrid(ASIDE, np.concatenate((up, -up)))
    return np.stack((aside.ravel(), np.zeros(aside.size), gap.ravel()), axis=1)
