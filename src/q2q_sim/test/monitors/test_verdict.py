"""A verdict is one line that a person reads, however much went wrong; programs get all of it."""

from dataclasses import replace
from pathlib import Path

import pytest

from q2q_sim.loop.flight_recorder import FlightRecorder
from q2q_sim.monitors.flight_verdict import MOST_SHOWN, Finding, FlightVerdict, verdict_line
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_run import FlightRun, runs_json
from q2q_sim.simulator.flight_clock import FlightTiming

MET = tuple(Finding(0.1 * each, f"cf{each} and cf{each + 1} collided") for each in range(190))
FIRST = "; ".join(one.words for one in MET[:MOST_SHOWN])


@pytest.mark.parametrize(
    ("findings", "words"),
    [(MET[:MOST_SHOWN], FIRST), (MET, f"{FIRST}; and {190 - MOST_SHOWN} more")],
)
def test_a_line_tells_the_first_failures_and_how_many_more_there_are(
    findings: tuple[Finding, ...], words: str
) -> None:
    assert verdict_line([("", FlightVerdict(10.0, findings))]) == f"verdict: {words}"


def test_a_line_tells_the_first_of_what_was_not_judged_and_how_many_more_there_are() -> None:
    verdict = FlightVerdict(10.0, unjudged=tuple(f"cf{each}" for each in range(100)))
    assert str(verdict).startswith("ok: 10.0 s flown to the end; not judged: cf0; ")
    assert str(verdict).endswith(f"; not judged: cf{MOST_SHOWN - 1}; and {100 - MOST_SHOWN} more")
    all_judged = replace(verdict, unjudged=verdict.unjudged[:MOST_SHOWN])
    assert str(all_judged).endswith(f"; not judged: cf{MOST_SHOWN - 1}")


def test_the_json_of_a_flight_has_every_failure() -> None:
    run = FlightRun(
        FlightRequest("table6"),
        FlightRecorder(("cf1",), 1).flight("made"),
        FlightMetrics({}, 0.0, 0.0),
        FlightTiming(0, 0, None, None, None),
        Path("bag"),
        FlightVerdict(10.0, MET),
    )
    (one,) = runs_json([run])["runs"]
    assert one["verdict"] == "; ".join(found.words for found in MET)
