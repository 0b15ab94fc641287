"""An encounter in which nothing happens, and the conditions of a promise."""

from q2q_sim.experiments.promise.room_encounter import (
    EncounterRecord,
    PromiseCase,
)

CONDITIONS = PromiseCase().conditions
BLANK = EncounterRecord(
    seed=0, vehicles=2, apart_at_start=True, horizontal=0.05, vertical=0.02, clearance=0.1,
    announced=True, ticks=100, broken_ticks=0, arrived=None, in_reach=None,
)  # fmt: skip
"""Flight in which nothing happens."""
