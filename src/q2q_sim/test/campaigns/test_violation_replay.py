"""Replay of a violation in a campaign: marked where it was, left out where there is nothing to replay."""

from dataclasses import replace
from pathlib import Path

import pytest

from q2q_model.signals.layout import Signal
from q2q_sim.campaigns.random_runs import campaign_flight
from q2q_sim.campaigns.random_runs.random_run import draw_run
from q2q_sim.campaigns.random_runs.violation_replay import write_replay
from q2q_sim.faults.faults import Fault
from q2q_sim.loop import closed_loop
from q2q_sim.monitors.policies import Violation
from q2q_sim.scenarios import library

TILTED = Violation("tilt", "cf1", 1.0, 0.5, 0.36)


def test_a_violation_is_reported_and_marked(tmp_path: Path):
    scenario = replace(library.load("table6"), duration=2.0)
    topics: dict[str, list[Signal]] = {}
    options = closed_loop.FlightOptions(
        on_signal=lambda topic, _, signal: topics.setdefault(topic, []).append(signal)
    )
    closed_loop.fly(scenario, options)
    write_replay(tmp_path / "7.html", scenario, topics, [TILTED])
    page = (tmp_path / "7.html").read_text()
    assert '"name":"table6"' in page
    assert str(TILTED) in page
    assert '"events":[{"t":1.0,"words":"cf1, tilt"}]' in page


def test_the_faults_of_a_run_are_reported_with_their_units(tmp_path: Path):
    weak = Fault("weak_rotor", 1.0, 0.25, ("cf1",), 0.1)
    off = Fault("outlier", 0.5, 0.0, (), 0.3)
    scenario = replace(library.load("table6"), duration=0.1, faults=(weak, off))
    topics: dict[str, list[Signal]] = {}
    options = closed_loop.FlightOptions(
        on_signal=lambda topic, _, signal: topics.setdefault(topic, []).append(signal)
    )
    closed_loop.fly(scenario, options)
    write_replay(tmp_path / "7.html", scenario, topics, [TILTED])
    message = f"{TILTED}. Faults: weak_rotor 0.1 on cf1 at 1.0 s for 0.25 s, outlier 0.3 m at 0.5 s"
    assert message in (tmp_path / "7.html").read_text()


def test_a_run_that_crashed_at_once_has_no_replay_nor_that_of_an_earlier_run(tmp_path: Path):
    (tmp_path / "7.html").write_text("an earlier run")
    write_replay(tmp_path / "7.html", library.load("table6"), {}, [replace(TILTED, t=float("nan"))])
    assert not (tmp_path / "7.html").exists()


def test_a_campaign_keeps_the_replay_of_a_violation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    run = draw_run(3)
    flight = campaign_flight.JudgedFlight(campaign_flight.fly_pure(run).topics, (TILTED,))
    monkeypatch.setattr(campaign_flight, "fly_pure", lambda _: flight)
    campaign_flight.fly_and_judge(3, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"3", "3.html", "3.yaml", "3.options.yaml"}
