"""Only causes that act in the explained part of a flight are causes of its loss."""

from dataclasses import replace

from q2q_sim.experiments.explanation.causes import present_causes
from q2q_sim.experiments.explanation.explanation import cut_setup
from q2q_sim.experiments.explanation.flight_setup import flight_setup
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.scenarios import library


def test_a_fault_that_begins_after_the_explained_part_is_no_cause() -> None:
    still = replace(library.load("table6"), wake="none")
    faults = (Fault("radio_loss", 0.4, 9.0, (), 0.9), Fault("outlier", 0.5, 1.0, ("cf1",), 0.2))
    setup = flight_setup(replace(still, faults=faults), BlockChoices("ignoring"), 0)
    begun = {"battery and saturation", "lost messages", "control"}
    assert set(present_causes(cut_setup(setup, 0.5))) == begun
    assert set(present_causes(cut_setup(setup, 0.51))) == begun | {"motion capture"}
