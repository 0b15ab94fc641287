"""Tube of tracking error learned from flights by split conformal prediction.

The tube is `horizontal` wide and `vertical` high: in a new flight every vehicle stays within it for all of
the flight with probability 1 - alpha or more. It holds for any distribution of the errors, over the draw of
the flights that it is learned from and of the new one, if all are drawn alike (Vovk, Gammerman and Shafer,
Algorithmic Learning in a Random World, 2005; one score for all of a trajectory: Lindemann et al., Safe
Planning in Dynamic Environments Using Conformal Prediction, RA-L 2023).

Of m flights with largest horizontal and vertical errors h_i and v_i, the first ones give the tube's shape,
the medians h_0 and v_0, and the other n its size s:

    s_i = max(h_i / h_0, v_i / v_0)
    s   = the k-th smallest of s_i,  k = ceil((n + 1)(1 - alpha)),    tube = s (h_0, v_0)

A new flight exceeds s with probability 1 - k / (n + 1) if no two errors are equal. Given the n flights, this
probability is itself distributed as Beta(n + 1 - k, k): at alpha = 0.01 it is below 1.2 alpha with near
certainty only from some 10 000 flights on.

Zones of the replanner, and the distances at which vehicles start, grow with the tube that is flown. So
1 - alpha is proven for flights with the tube that those were flown with which gave the learned one; they stay
within their own tube, too, if the learned one lies within it. How many flights with the learned tube leave it
is counted, in others.
"""

from dataclasses import dataclass
from math import ceil
from pathlib import Path

import numpy as np

from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.signals.values import Array

SHAPE_SHARE = 0.2
"""Share of the flights that gives the tube's shape."""


@dataclass(frozen=True, slots=True)
class TubeConditions:
    """Flights for which a tube holds: those drawn like the ones it is learned from."""

    controller: str
    model: str
    """Interaction model of the controller."""
    air: str
    speed_max: float
    """Of the setpoints [m/s]."""
    acc_max: float
    """Of the setpoints, per axis [m/s^2]."""
    jerk_max: float
    """Of the setpoints, per axis [m/s^3]; 0: not bounded."""
    most_delay: float
    """From camera to actuator [s]."""
    most_loss: float
    """Share of lost commands."""
    most_gap: float = 0.0
    """Longest time for which motion capture loses a vehicle [s]."""
    approach: float | None = None
    """Poles of the way back [1/s]; None: not known, as in older files."""
    grace: float | None = None
    """Age of a measurement up to which the tube covers the drift [s]; None as for `approach`."""


@dataclass(frozen=True, slots=True)
class TubeFlights:
    """Flights that a tube is learned from."""

    first: int
    """Seed of the first."""
    count: int
    horizontal: float
    """Width of the tube that they were flown with [m]."""
    vertical: float
    """Its height [m]."""


@dataclass(frozen=True, slots=True)
class TrackingTube:
    """Bound of the tracking error for all of a flight."""

    alpha: float
    """Probability that a flight leaves the tube."""
    flights: int
    """Flights that give its size."""
    horizontal: float
    """[m]"""
    vertical: float
    """[m]"""
    conditions: TubeConditions
    learned_from: TubeFlights | None = None
    """None: not known, as in older files."""

    def __post_init__(self) -> None:
        """Raise ValueError where a number is out of bounds."""
        if not 0.0 < self.alpha < 1.0:
            raise ValueError(f"alpha = {self.alpha:g}; must be above 0 and below 1")
        if not (self.horizontal > 0.0 and self.vertical > 0.0):
            raise ValueError(f"tube of {self.horizontal:g} m and {self.vertical:g} m; must be above 0")

    def holds(self, errors: Array) -> bool:
        """Return whether a flight with these largest errors (horizontal, vertical) [m] stays within."""
        return bool(errors[0] <= self.horizontal and errors[1] <= self.vertical)


def fewest_flights(alpha: float) -> int:
    """Return the least number of flights that bounds anything at alpha."""
    return ceil((1.0 - alpha) / alpha - 1e-9)


def check_enough_flights(flights: int, alpha: float) -> None:
    """Raise ValueError if `learn_tube` learns no tube from so many flights."""
    sizing = flights - ceil(SHAPE_SHARE * flights)
    if sizing < fewest_flights(alpha):
        raise ValueError(
            f"{flights} flights at alpha = {alpha:g}: {sizing} of them size the tube; must be at least "
            f"{fewest_flights(alpha)}: fly more, or allow a larger alpha"
        )


def conformal_bound(scores: Array, alpha: float) -> float:
    """Return the ceil((n + 1)(1 - alpha))-th smallest of scores (n,) [-].

    Raises:
        ValueError: there are too few scores.
    """
    rank = ceil((len(scores) + 1) * (1.0 - alpha) - 1e-9)  # 0.95 * 100 is 95
    if not 0.0 < alpha < 1.0 or rank > len(scores):
        raise ValueError(
            f"{len(scores)} scores at alpha = {alpha:g}; must be at least {fewest_flights(alpha)}"
        )
    return float(np.sort(scores)[rank - 1])


def learn_tube(
    errors: Array, alpha: float, conditions: TubeConditions, learned_from: TubeFlights | None = None
) -> TrackingTube:
    """Return the tube of flights with largest errors (horizontal, vertical) [m], (m, 2).

    Raises:
        ValueError: alpha is not between 0 and 1, there are too few flights, or their errors give no shape.
    """
    if not 0.0 < alpha < 1.0:
        raise ValueError(f"alpha = {alpha:g}; must be above 0 and below 1")
    check_enough_flights(len(errors), alpha)
    shaping = ceil(SHAPE_SHARE * len(errors))
    sizing = errors[shaping:]
    shape = np.median(errors[:shaping], axis=0) if shaping else np.ones(2)
    if not (np.isfinite(errors).all() and (shape > 0.0).all()):
        raise ValueError(f"errors with medians {shape} m; must all be finite and mostly above 0")
    size = conformal_bound((sizing / shape).max(axis=1, initial=0.0), alpha)
    horizontal, vertical = (size * shape).tolist()
    return TrackingTube(alpha, len(sizing), horizontal, vertical, conditions, learned_from)


def read_tube(path: Path) -> TrackingTube:
    """Return the tube of a file.

    Raises:
        ValueError: the file is not a tube; with key and value.
    """
    return from_plain(TrackingTube, load_yaml(path), str(path))
