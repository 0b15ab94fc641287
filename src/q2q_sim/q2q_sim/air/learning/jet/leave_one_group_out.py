"""Jets for flights that had no part in them.

What a jet leaves of its own flights is too little: part of their turbulence is in its table. Each group of
flights is therefore compared with the jet of all others, as `validate` compares flights left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from q2q_sim.air.air_terms import JetTerm
from q2q_sim.air.learning.jet.jet_term import jet_alone
from q2q_sim.air.learning.records.air_record import AirRecord

GROUPS = 3
"""Groups of flights: each jet has the rows of two thirds of them."""


@dataclass(frozen=True, slots=True)
class HeldOutGroup:
    """Flights, and a jet learned without them."""

    records: tuple[AirRecord, ...]
    jet: JetTerm


def held_out_groups(records: Sequence[AirRecord], whole: JetTerm) -> list[HeldOutGroup]:
    """Return the flights with a wake in groups; `whole` stands in where the others show no jet."""
    waked = [record for record in records if any(one.exposed.any() for one in record.samples)]
    found = []
    for first in range(min(GROUPS, len(waked))):
        group = tuple(waked[first::GROUPS])
        others = [record for record in waked if all(record is not one for one in group)]
        found.append(HeldOutGroup(group, jet_alone(others) or whole))
    return found
