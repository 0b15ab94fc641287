"""A vehicle that the room loses while its plan goes on is led back, and does not swing beyond the plan."""

import numpy as np
import pytest

from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run, fault_document
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies.inputs.limits import Limits

NEAR = Limits().back
LOST = Fault("dropout", 1.2, 2.4, ("cf2",), 0.0)
"""It brakes and sinks where it is, while its plan leaves for a passage at 1.5 m/s."""


@pytest.mark.parametrize("seed", [102959, 310001])
def test_a_vehicle_found_far_from_a_moving_plan_is_back_in_one_swing(seed: int) -> None:
    run = draw_run(seed)
    document = {**run.document, "faults": [fault_document(LOST)]}
    topics = fly_pure(Run(seed, document, run.options)).topics
    row = topics["truth"][0].names.index("cf2")
    pairs = zip(topics["truth"], topics["reference_safe"], strict=True)
    off = np.array([np.hypot(*(flown.pos[row, :2] - planned.pos[row, :2])) for flown, planned in pairs])
    farthest = int(np.argmax(off))
    assert off[farthest] > 2.0
    back = farthest + int(np.argmax(off[farthest:] < NEAR))
    assert off[back:].max() < NEAR
