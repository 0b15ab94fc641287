"""Each stated property holds in the sound stack and is violated by the seeded bug that breaks it."""

from functools import cache

import pytest

from q2q_sim.experiments.campaign.random_run import Run, drawn
from q2q_sim.experiments.guided.attack_case import with_faults
from q2q_sim.experiments.guided.attacked_flight import AttackedFlight, fly_attacked
from q2q_sim.experiments.guided.seeded_bugs import SEEDED_BUGS
from q2q_sim.faults.faults import Fault

BUGS = {bug.name: bug for bug in SEEDED_BUGS}
PASS = 4.5
"""Time at which cf2 passes above cf1 in Table 2's flights as campaigns cut them [s]."""
CASES: dict[str, tuple[int, str, tuple[Fault, ...]]] = {
    "upper lost": (3, "none", (Fault("dropout", PASS - 0.6, 1.0, ("cf2",)),)),
    "swapped with a lost one": (
        5,
        "none",
        (Fault("swap", 3.5, 0.15, ("cf1", "cf2")), Fault("dropout", 3.0, 0.8, ("cf2",))),
    ),
    "reordered": (3, "none", (Fault("reordered", 3.0, 0.3),)),
    "set back": (3, "none", (Fault("clock_jump", 3.0, 1.0, (), -0.45),)),
    "lost at the zone": (5, "safe", (Fault("dropout", 3.5, 1.0, ("cf2",)),)),
    "restarted in the zone": (3, "safe", (Fault("reordered", PASS - 0.1, 0.3),)),
}
"""Flight of Table 2, replanner and faults."""


@cache
def flown(case: str) -> Run:
    """Return a run of a case, by the PID."""
    number, replan, faults = CASES[case]
    for seed in range(200):
        run = drawn(seed, replan=replan)
        if f"flight {number}," in str(run.document["description"]) and run.options.controller == "pid":
            return with_faults(run, faults)
    raise ValueError(f"no seed below 200 flies flight {number} by the PID")


@cache
def sound(case: str) -> AttackedFlight:
    """Return the outcome of a case without a bug."""
    return fly_attacked(flown(case))


@pytest.mark.parametrize(
    ("bug", "case", "broken"),
    [
        ("long_coast", "upper lost", "lost"),
        ("never_ambiguous", "swapped with a lost one", "swap"),
        ("held_unreported", "reordered", "repeat"),
        ("clock_never_reset", "set back", "hold"),
        ("no_braking", "upper lost", "brake"),
        ("braking_reversed", "upper lost", "brake"),
        ("no_evasion", "upper lost", "evasion"),
        ("evasion_reversed", "upper lost", "evasion"),
        ("hold_forgotten", "lost at the zone", "held_acc"),
        ("break_unreported", "restarted in the zone", "promise"),
    ],
)
def test_a_bug_violates_the_property_that_the_sound_stack_keeps(bug: str, case: str, broken: str):
    assert sound(case).violations == ()
    with BUGS[bug].seeded():
        found = fly_attacked(flown(case))
    assert broken in found.policies


def test_a_reported_entry_into_the_zone_is_near_but_no_violation():
    flight = sound("restarted in the zone")
    assert flight.violations == ()
    assert flight.margins["promise"] < 0.0
