"""JSON of flights as `fly` and `demo` write it, a contract with other programs."""

import math
from collections.abc import Sequence

from q2q_sim.monitors.metrics import VehicleMetrics
from q2q_sim.node_flights.scenario_flight import FlightRun

Json = dict[str, "Json"] | list["Json"] | str | float | int | bool | None


def runs_json(runs: Sequence[FlightRun]) -> Json:
    """Return {"runs": [...]}; missing quantities are null."""
    return {"runs": [_run(run) for run in runs]}


def _run(run: FlightRun) -> Json:
    return {
        "scenario": run.request.scenario,
        "mode": run.request.mode,
        "controller": run.request.controller,
        "vehicles": {name: _vehicle(one) for name, one in run.metrics.vehicles.items()},
        "min_separation_m": finite(run.metrics.min_separation_m),
        "zone_time_s": finite(run.metrics.zone_time_s),
        "real_time_factor": run.timing.real_time_factor,
        "missed_ticks": run.timing.missed_ticks,
        "verdict": run.verdict.full_text,
        "ok": run.verdict.ok,
        "latency_ms": {"p50": run.timing.latency_p50_ms, "p99": run.timing.latency_p99_ms},
    }


def _vehicle(one: VehicleMetrics) -> Json:
    return {
        "z_rmse_m": finite(one.z_rmse_m),
        "xy_rmse_m": finite(one.xy_rmse_m),
        "u1_energy": finite(one.u1_energy),
        "u1_energy_above_hover": finite(one.u1_energy_above_hover),
        "u1_max": finite(one.u1_max),
        "under_rms_m": finite(one.under_rms_m),
        "clear_rms_m": finite(one.clear_rms_m),
        "worst_m": finite(one.worst_m),
    }


def finite(value: float | None) -> float | None:
    """Return a finite number, else None."""
    return value if value is not None and math.isfinite(value) else None
