"""A warm-up walks the ways of real ticks, for a swarm of any size."""

import numpy as np
import pytest

from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.node.warm_up import LOST_S, TICKS, synthetic_signal
from q2q_model.signals.values import MocapFrame, SwarmState, TrackStatus


@pytest.mark.parametrize("vehicles", [1, 2, 200])
def test_every_track_is_accepted_and_one_is_bridged(vehicles: int) -> None:
    names = tuple(f"cf{row + 1}" for row in range(vehicles))
    block = MocapFilter(MocapFilterParams(), names)
    states = [block.update(synthetic_signal(MocapFrame, t, names, unseen=unseen)) for t, unseen in TICKS]
    first = [state.status[0] for state in states]
    tracked, coasting = TrackStatus.TRACKED, TrackStatus.COASTING
    assert first == [coasting, tracked, tracked, coasting, tracked]
    assert all((state.status[1:] == tracked).all() for state in states[1:])
    assert block.report.refused == block.report.restarted == 0


def test_an_unseen_vehicle_is_lost_in_the_state() -> None:
    state = synthetic_signal(SwarmState, 0.0, ("cf1", "cf2"), unseen=True)
    assert isinstance(state, SwarmState)
    np.testing.assert_array_equal(state.status, [TrackStatus.LOST, TrackStatus.TRACKED])
    np.testing.assert_array_equal(state.age, [LOST_S, 0.0])
