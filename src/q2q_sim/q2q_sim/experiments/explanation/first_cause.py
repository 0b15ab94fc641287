"""First cause of a loss: of the causes that it takes, the one that made the flight an unusual one.

Causes often act together: a vehicle that receives no commands is carried off by gusts, and without either
nothing happens. Their shares are then alike, whatever came first. A loss takes a cause if without it alone at
most SPARED of it is left. Of these causes one is named before others

1. that strikes during the flight, as a fault;
2. that is not ordinary: gusts up to ORDINARY_GUSTS are in every real room;
3. whose share is larger.

If the loss takes none of its causes, the one with the largest share is named, unless the rest, which is lost
without any of them, is larger than all their shares together: then most of it has another reason. A cause
without a positive share is never first, nor is one of no loss.
"""

from collections.abc import Callable, Collection, Mapping

from q2q_sim.air.room_air import RoomAir
from q2q_sim.experiments.explanation.causes import FAULTS
from q2q_sim.experiments.explanation.flight_setup import FlightSetup
from q2q_sim.experiments.explanation.loss import Loss

SPARED = 0.5
"""Largest part of a loss that is left without a cause that it takes [-]."""
ORDINARY_GUSTS = 0.25
"""Largest standard deviation of ordinary gusts [m/s^2]: the air `room` has 0.22, of real flights."""
WIND = "wind"


def first_cause(
    setup: FlightSetup,
    loss: Loss,
    shares: Mapping[str, float],
    left: Callable[[Collection[str]], float],
    rest: float,
) -> str | None:
    """Return the first cause; None if none of the causes explains the loss.

    Args:
        setup: the flight.
        loss: its loss.
        shares: of the causes in it [m].
        left: returns the loss without some causes [m].
        rest: the loss without any of them [m].
    """
    if loss.size == 0.0:
        return None
    lossy = [cause for cause in shares if shares[cause] > 0.0]
    taken = [cause for cause in lossy if left({cause}) <= SPARED * loss.size]
    faulty = _causes_with_faults(setup, loss)
    usual = {WIND} if _gusts(setup) <= ORDINARY_GUSTS else set()
    return max(
        taken or (lossy if sum(shares[cause] for cause in lossy) >= rest else ()),
        key=lambda cause: (cause in faulty, cause not in usual, shares[cause]) if taken else shares[cause],
        default=None,
    )


def _causes_with_faults(setup: FlightSetup, loss: Loss) -> set[str]:
    """Return the causes with faults that began after the start and before the loss."""
    kinds = {fault.kind for fault in setup.scenario.faults if 0.0 < fault.start <= loss.t}
    return {cause for cause, own in FAULTS.items() if kinds & {*own}}


def _gusts(setup: FlightSetup) -> float:
    """Return the standard deviation of a flight's gusts [m/s^2]; infinite with a steady wind beyond that."""
    if setup.air is None:
        return setup.scenario.disturbance.air_std
    term = setup.air.wind if isinstance(setup.air, RoomAir) else None
    if term is None:
        return 0.0
    steady = max(map(abs, term.mean_mps2))
    return term.gust_std_mps2 if steady <= ORDINARY_GUSTS else float("inf")
