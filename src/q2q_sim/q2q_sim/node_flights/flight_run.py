"""Finished flight through nodes, and its JSON as `fly` and `demo` write it, which other programs read."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from q2q_model.documents.json_file import Json
from q2q_model.flights.flight import Flight
from q2q_sim.monitors.flight_verdict import FlightVerdict
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.simulator.flight_clock import FlightTiming


@dataclass(frozen=True, slots=True)
class FlightRun:
    """Finished flight with its metrics."""

    request: FlightRequest
    flight: Flight
    metrics: FlightMetrics
    timing: FlightTiming
    bag: Path
    verdict: FlightVerdict


def runs_json(runs: Sequence[FlightRun]) -> Json:
    """Return {"runs": [...]}; NaN where a quantity is unknown."""
    return {"runs": [_run(run) for run in runs]}


def _run(run: FlightRun) -> Json:
    return {
        "scenario": run.request.scenario,
        "mode": run.request.mode,
        "correct": run.request.correct,
        "controller": run.request.controller,
        "vehicles": {name: asdict(one) for name, one in run.metrics.vehicles.items()},
        "min_separation_m": run.metrics.min_separation_m,
        "zone_time_s": run.metrics.zone_time_s,
        "real_time_factor": run.timing.real_time_factor,
        "missed_ticks": run.timing.missed_ticks,
        "verdict": run.verdict.full_text,
        "ok": run.verdict.ok,
        "latency_ms": {"p50": run.timing.latency_p50_ms, "p99": run.timing.latency_p99_ms},
    }
