"""Loss of a flight, split among its causes.

The shares are Shapley values (q2q_sim.experiments.explanation.shapley) of the flight with its own seed. Their
95 % interval, which holds the share of a flight with another seed, is share +- w,

    w^2 = w_o^2 + 2 (t s)^2

| symbol | meaning |
|---|---|
| w_o | half width over random orders (half_widths_of_orders); 0 if all are flown [m] |
| s | standard deviation between draws of noise, losses and gusts; 0 if one is flown [m] |
| t | Student's t of one degree of freedom less than there are draws [-] |

The 2 is because the difference of two flights has the variance of both.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from q2q_model.signals.values import Array
from q2q_sim.experiments.explanation.causes import present_causes, without_causes
from q2q_sim.experiments.explanation.first_cause import first_cause
from q2q_sim.experiments.explanation.flight_setup import FlightSetup, fly_setup
from q2q_sim.experiments.explanation.loss import Loss, LossKind, largest_loss, loss_over_time
from q2q_sim.experiments.explanation.shapley import (
    UPPER,
    CauseOrder,
    ValueOfCauses,
    all_orders_fit,
    half_widths_of_orders,
    orders_of,
    shapley_shares,
)
from q2q_sim.random_streams import stream

AFTER = 1.0
"""Time that is flown beyond the loss, in which a flight without a cause may lose later [s]."""

Follow = Callable[[float], None]
"""Function of the finished share of the work, 0 to 1."""


@dataclass(frozen=True, slots=True)
class ExplanationParams:
    """Effort of an explanation."""

    orders: int = 8
    """Orders of the causes, even and at least 4; all of them where they need no more flights."""
    draws: int = 3
    """Draws of noise, losses and gusts that are flown: of the flight's own seed and those after it."""
    kind: LossKind = "distance"
    """What is split."""

    def __post_init__(self) -> None:
        """Check the bounds."""
        if self.orders < 4 or self.orders % 2:
            raise ValueError(f"orders = {self.orders}; must be even and at least 4")
        if self.draws < 1:
            raise ValueError(f"draws = {self.draws}; must be at least 1")


@dataclass(frozen=True, slots=True)
class CauseShare:
    """Part of the loss that a cause has."""

    cause: str
    share: float
    """[m]; below 0 if the cause kept the vehicle on its path."""
    low: float
    high: float
    """95 % interval [m]."""


@dataclass(frozen=True, slots=True)
class Explanation:
    """Loss of a flight and its causes."""

    loss: Loss
    shares: tuple[CauseShare, ...]
    """Of the causes that change something: the first cause, then the largest first."""
    first: str | None
    """First cause; None if none of the causes explains the loss."""
    rest: float
    """Loss without any of them [m]."""
    without_first: float
    """Loss without the first cause alone [m]; the whole loss if there is none."""
    all_orders: bool
    """Whether the shares are means over all orders of the causes, not over random ones."""
    draws: int
    """Draws that were flown."""


def ignore_progress(_: float) -> None:
    """Ignore the progress."""


def explain(
    setup: FlightSetup, params: ExplanationParams | None = None, follow: Follow = ignore_progress
) -> Explanation:
    """Return the explanation of a flight's largest loss; `follow` is called with the flown share, 0 to 1."""
    params = params or ExplanationParams()
    loss = largest_loss(fly_setup(setup), params.kind)
    end = min(setup.scenario.duration, loss.t + AFTER)
    short = cut_setup(setup, end)
    causes = present_causes(short)
    orders = orders_of(causes, params.orders, stream(setup.seed, "explanation orders"))
    values = [loss_without(replace(short, seed=setup.seed + k), loss) for k in range(params.draws)]
    found = _all_shares(causes, orders, values, follow)
    exact = all_orders_fit(causes, params.orders)
    split = _split(causes, found, exact=exact)
    own = values[0]
    rest, shares_of = own(frozenset(causes)), {one.cause: one.share for one in split}
    first = first_cause(short, loss, shares_of, lambda out: own(frozenset(out)), rest)
    return Explanation(
        loss=loss,
        shares=tuple(sorted(split, key=lambda one: one.cause != first)),
        first=first,
        rest=rest,
        without_first=own(frozenset() if first is None else frozenset({first})),
        all_orders=exact,
        draws=params.draws,
    )


def cut_setup(setup: FlightSetup, end: float) -> FlightSetup:
    """Return a flight that ends at a time [s], without the faults that begin later."""
    begun = tuple(fault for fault in setup.scenario.faults if fault.start < end)
    return replace(setup, scenario=replace(setup.scenario, duration=end, faults=begun))


def loss_without(setup: FlightSetup, loss: Loss) -> ValueOfCauses:
    """Return the loss [m] of a vehicle as a function of the causes taken out; each set is flown once."""
    known: dict[frozenset[str], float] = {}

    def value(removed: frozenset[str]) -> float:
        if removed not in known:
            flight = fly_setup(without_causes(setup, removed))
            known[removed] = float(loss_over_time(flight, loss.kind)[:, loss.row].max())
        return known[removed]

    return value


def half_widths_of_shares(found: Array, *, exact: bool) -> Array:
    """Return w of each cause from its shares (draws, orders, causes); `exact` means all orders."""
    draws, _, causes = found.shape
    none = np.zeros(causes)
    by_order = none if exact else half_widths_of_orders(found[0])
    by_draw = none if draws == 1 else stdtrit(draws - 1, UPPER) * found.mean(axis=1).std(axis=0, ddof=1)
    return np.asarray(np.hypot(by_order, np.sqrt(2.0) * by_draw))


def _all_shares(
    causes: Sequence[str], orders: Sequence[CauseOrder], values: Sequence[ValueOfCauses], follow: Follow
) -> Array:
    """Return the shares of the causes of each draw and in each order, (draws, orders, causes)."""
    found = np.empty((len(values), len(orders), len(causes)))
    for k, value in enumerate(values):
        for row, order in enumerate(orders):
            found[k, row] = shapley_shares(causes, [order], value)[0]
            follow((k * len(orders) + row + 1) / (len(values) * len(orders)))
    return found


def _split(causes: Sequence[str], found: Array, *, exact: bool) -> tuple[CauseShare, ...]:
    """Return the mean shares with the first seed and their intervals; `exact` means over all orders.

    A cause whose removal never changed the loss has none.
    """
    means = found.mean(axis=1)  # (draws, causes)
    wide = half_widths_of_shares(found, exact=exact)
    acts = (found != 0.0).any(axis=(0, 1)).tolist()
    split = [
        CauseShare(cause, float(mean), float(mean - one), float(mean + one))
        for cause, mean, one, act in zip(causes, means[0], wide, acts, strict=True)
        if act
    ]
    return tuple(sorted(split, key=lambda one: -one.share))
