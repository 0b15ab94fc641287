"""Bags are judged as their signals are, by the policies of which they have something."""

import json
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from changed_flights import changed, received, with_row

from q2q_model.bag import BagWriter, FlightFacts
from q2q_model.signals.values import (
    SwarmCommand,
    SwarmState,
)
from q2q_sim.commands import policies as tool
from q2q_sim.monitors.policies import RecordedSignal


def bag_of(
    recorded: Iterable[RecordedSignal], folder: Path, namespace: str = "/", facts: FlightFacts | None = None
) -> None:
    """Write a bag of what was recorded."""
    with BagWriter(folder, facts=facts) as writer:
        for one in recorded:
            writer.write_signal(f"{namespace}{one.topic}", round(one.at * 1e9), one.signal)


def test_a_bag_is_judged_as_its_signals_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change = changed(SwarmCommand, 3.0, 3.01, roll=with_row(2, 0.5))
    bag_of(received(), tmp_path / "good")
    bag_of(map(change, received()), tmp_path / "bad")
    assert tool.main([str(tmp_path / "good")]) == 0
    assert "keeps separation, zone" in capsys.readouterr().out
    assert tool.main([str(tmp_path / "bad"), "--scenario", "stack3"]) == 1
    assert "tilt: cf3 at 3.00 s" in capsys.readouterr().out
    assert tool.main([str(tmp_path / "none")]) == 2
    assert "no bag at" in capsys.readouterr().err


def test_a_bag_is_judged_by_the_faults_that_it_records_if_no_scenario_is_given(tmp_path: Path) -> None:
    at = received()[0].signal
    assert isinstance(at, SwarmState)
    near = changed(SwarmState, 3.0, 3.1, pos=with_row(0, at.pos[1] + np.array([0.0, 0.10, 0.0])))
    seen = [near(one) for one in received() if one.topic in ("mocap", "state", "reference_safe")]
    displaced = json.dumps(
        [{"kind": "jump", "start": 2.9, "duration": 1.0, "vehicles": ["cf1"], "size": 1.0}]
    )
    bag_of(seen, tmp_path / "sound")
    bag_of(seen, tmp_path / "displaced", facts=FlightFacts(faults=displaced))
    assert tool.main([str(tmp_path / "sound")]) == 1
    assert tool.main([str(tmp_path / "displaced")]) == 0
    assert tool.main([str(tmp_path / "displaced"), "--scenario", "stack3"]) == 1


def test_a_bag_recorded_in_a_namespace_is_judged_and_one_without_a_clock_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    still = (replace(one, signal=replace(one.signal, t=0.0)) for one in received())
    bag_of(received(), tmp_path / "good", "/room/")
    bag_of(still, tmp_path / "bad", "/room/")
    assert tool.main([str(tmp_path / "good")]) == 0
    assert "keeps separation, zone" in capsys.readouterr().out
    assert tool.main([str(tmp_path / "bad")]) == 2
    assert "messages on truth are stamped 0 s: stamp each" in capsys.readouterr().err


UNSEEN = "separation, zone, setpoint_error, floor"
UNCOMMANDED = "thrust, tilt, state_age, fallback_latency, silence"


@pytest.mark.parametrize(("topics", "status", "said"), [
    ("mocap", 2, ("nothing to judge: record state or", f"{UNSEEN}, {UNCOMMANDED}, state_error, return")),
    ("mocap state reference_safe", 1, ("separation: cf1 and cf2", f"{UNCOMMANDED}, state_error, return")),
    ("mocap command", 0,
     ("keeps thrust, tilt, numbers, fallback_latency, silence", f"{UNSEEN}, state_age, state_error, return")),
])  # fmt: skip
def test_policies_of_which_a_bag_has_nothing_are_named_and_positions_are_the_filtered_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], topics: str, status: int, said: tuple[str, str]
) -> None:
    at = received()[0].signal
    assert isinstance(at, SwarmState)
    near = changed(SwarmState, 3.0, 3.1, pos=with_row(0, at.pos[1] + np.array([0.0, 0.10, 0.0])))
    bag_of((near(one) for one in received() if one.topic in topics.split()), tmp_path / "bag")
    assert tool.main([str(tmp_path / "bag"), "--scenario", "stack3"]) == status
    texts = capsys.readouterr()
    assert said[0] in texts.out
    assert texts.err.strip().endswith(f"as not recorded: {said[1]}")
