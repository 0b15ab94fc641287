"""What `/diagnostics` says of a node's last signal is what the signal holds."""

import numpy as np
import pytest
from resting_signals import level_command, resting_state

from q2q_model.diagnostics.diagnostic_values import diagnostic_values
from q2q_model.diagnostics.smallest_separation import smallest_separation
from q2q_model.signals.values import (
    CommandStatus,
    Interference,
    InterferenceStatus,
    MocapFrame,
    SwarmState,
    TrackStatus,
)

NAMES = ("cf1", "cf2", "cf3")
POS = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5], [0.0, 0.0, 1.6]])


def state(status: tuple[TrackStatus, ...]) -> SwarmState:
    return resting_state(
        0.0, NAMES, POS, age=np.array([0.0, 0.25, 0.125]), status=np.array(status, dtype=np.uint8)
    )


def test_a_state_reports_its_tracks_its_age_and_the_closest_pair():
    tracked, coasting = TrackStatus.TRACKED, TrackStatus.COASTING
    output = diagnostic_values(state((tracked, coasting, tracked)))
    assert (output["coasting"], output["lost"], output["age_max_s"]) == ("1", "0", "0.25")
    assert output["separation_m"] == "0.1"


def test_a_lost_vehicle_is_close_to_nobody():
    output = diagnostic_values(state((TrackStatus.TRACKED, TrackStatus.TRACKED, TrackStatus.LOST)))
    assert output["separation_m"] == "0.5"


def test_a_vehicle_alone_or_unknown_has_no_pair():
    assert smallest_separation(POS[:1]) == np.inf
    assert smallest_separation(np.array([[0.0, 0.0, 0.0], [np.nan] * 3])) == np.inf
    assert smallest_separation(np.zeros((0, 3))) == np.inf


@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_the_smallest_separation_is_that_of_the_closest_of_all_pairs(offset: float):
    rng = np.random.default_rng(7)
    pos = rng.uniform(-5.0, 5.0, (60, 3))
    pos[41] = pos[3] + [0.0, 0.03, 0.04]
    pos[11] = np.nan
    pairs = [(i, j) for i in range(60) for j in range(i)]
    expected = min(d for i, j in pairs if (d := float(np.linalg.norm(pos[i] - pos[j]))) == d)
    assert expected == pytest.approx(0.05, rel=1e-12)
    # 1e4 m away a coordinate holds 2e-12 m
    assert smallest_separation(pos + offset) == pytest.approx(expected, abs=1e-15 + 1e-15 * offset)


def test_a_downwash_reports_its_largest_length():
    acc = np.array([[0.0, 0.0, 0.0], [0.0, -3.0, -4.0], [0.0, 0.0, 1.0]])
    status = np.array(
        [InterferenceStatus.NO_MODEL, InterferenceStatus.STALE_SOURCE, InterferenceStatus.VALID]
    )
    output = diagnostic_values(
        Interference(t=0.0, names=NAMES, acc=acc, std=acc, status=status.astype(np.uint8))
    )
    assert output == {"downwash_max_m_s2": "5", "stale_sources": "1", "no_model": "1"}


@pytest.mark.parametrize(
    ("status", "saturated", "in_fallback"),
    [(CommandStatus.OK, "0", "0"), (CommandStatus.SATURATED, "3", "0"), (CommandStatus.LAND, "0", "3")],
)
def test_a_command_reports_what_is_saturated_and_what_is_in_fallback(
    status: CommandStatus, saturated: str, in_fallback: str
):
    output = diagnostic_values(
        level_command(0.0, NAMES, np.ones(3), status=np.full(3, status, dtype=np.uint8))
    )
    assert output == {"saturated": saturated, "in_fallback": in_fallback}


def test_a_signal_without_facts_reports_nothing():
    frame = MocapFrame(t=0.0, names=NAMES, pos=POS, quat=np.zeros((3, 4)))
    assert diagnostic_values(frame) == {}
