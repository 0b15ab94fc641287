"""Motion capture that lies for seconds: it is frozen, exchanges names for good, or turns a body over."""

import pytest

from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run, fault_document
from q2q_sim.faults.faults import Fault


@pytest.mark.parametrize("seed", [660023, 660103])
@pytest.mark.parametrize(
    "lie",
    [
        Fault("stale", 2.2, 1.5),
        Fault("swap", 2.2, 9.0, ("cf1", "cf2")),
        Fault("flip", 2.2, 2.5, ("cf1",)),
    ],
    ids=lambda lie: lie.kind,
)
def test_frozen_swapped_or_flipped_poses_for_seconds_violate_no_policy(seed: int, lie: Fault) -> None:
    run = draw_run(seed)
    document = {**run.document, "faults": [fault_document(lie)]}
    assert fly_pure(Run(seed, document, run.options)).violations == ()
