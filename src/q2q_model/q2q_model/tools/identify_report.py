"""Results of an identification as the JSON of `identify` and as text."""

from collections.abc import Sequence
from dataclasses import asdict, fields

from q2q_model.counted import counted
from q2q_model.documents.plain_values import Plain
from q2q_model.downwash.jet import Jet
from q2q_model.identification.deviation import DeviationParams
from q2q_model.identification.identification import Identification
from q2q_model.identification.jet.loading import usable_loading
from q2q_model.identification.selection.identification_data import every_record
from q2q_model.identification.selection.model_choice import Trial
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.model_files.model_file import RoleScores
from q2q_model.tunable import tunable_of

UNITS = {one.name: tunable_of(one).unit for one in fields(Jet)} | {"slowness": "s/m"}
"""Unit of each fitted parameter."""


def report(found: Identification, seconds: dict[str, float]) -> dict[str, object]:
    """Return the report in the form documented for `identify`."""
    return {
        "outliers": {
            "found": sum(one.outliers for one in every_record(found.data)),
            "samples": sum(one.samples for one in every_record(found.data)),
        },
        "gains": _gains(found),
        "zone": _zone(found),
        "model": _model(found),
        "loading": {
            "interval": found.loading.as_list() if found.loading else None,
            "used": usable_loading(found.loading),
        },
        "residual": {name: one.as_list() if one else None for name, one in found.residual.intervals}
        if found.residual
        else None,
        "candidates": [_candidate(trial) for trial in found.trials],
        "remarks": list(found.remarks),
        "seconds": seconds | {"total": sum(seconds.values())},
    }


def _spans(found: Sequence[tuple[str, Interval]]) -> list[tuple[str, list[float]]]:
    return [(name, one.as_list()) for name, one in found]


def summary(found: Identification) -> str:
    """Return the results as text."""
    gains, held = found.gains, found.held_out
    flights = counted(len(found.data), "flight")
    outliers = counted(sum(one.outliers for one in every_record(found.data)), "outlier")
    lines = [
        f"{flights}, {outliers}; 95 % intervals in brackets",
        _gain("K_p", gains.k_p, "1/s^2"),
        _gain("K_d", gains.k_d, "1/s"),
    ]
    if found.decay is not None:
        d = found.decay.d
        lines.append(f"zone from dev: d {_ranged(d, 'm', digits=2)}")
    if found.zone is not None:
        lines.append(
            f"zone from the downwash, |eta| >= {found.zone.threshold} m/s^2: "
            f"{found.zone.eps:.2f} m horizontally, {found.zone.d:.2f} m vertically"
        )
    lines.append(f"model: {found.chosen.name} ({counted(found.chosen.parameters, 'parameter')})")
    if held.r2.lower is not None:
        lines.append(f"  on flights left out: R2 {held.r2.lower:.3f} of the lower vehicle's {held.r2_of}")
    lines += [f"  {name} {_ranged(one, UNITS.get(name, ''))}" for name, one in found.spread]
    if found.loading is not None:
        lines.append(f"loading {_ranged(found.loading)}: {usable_loading(found.loading):.2f} is used")
    return "\n".join(lines + [f"note: {remark}" for remark in found.remarks])


def _ranged(one: Interval, unit: str = "", digits: int = 3) -> str:
    value = f"{one.value:.{digits}f} {unit}".rstrip()
    return f"{value} [{one.low:.{digits}f}, {one.high:.{digits}f}]"


def _gain(name: str, found: Interval, unit: str) -> str:
    remark = "" if found.is_positive else ": not identifiable from these flights"
    if found.high < 0.0:
        remark = ": negative, the commands lead away from the reference"
    return f"{name} {_ranged(found, unit, digits=5)}{remark}"


def _gains(found: Identification) -> dict[str, object]:
    loop = found.file.gains
    return {
        "k_p": found.gains.k_p.as_list(),
        "k_d": found.gains.k_d.as_list(),
        "identifiable": {"k_p": found.gains.k_p.is_positive, "k_d": found.gains.k_d.is_positive},
        "k_i": found.gains.loop.k_i,
        "offset_mps2": found.gains.loop.offset,
        "lag_s": loop.lag if loop else 0.0,
        "needs_offset": found.gains.needs_offset,
        "needs_integral": found.gains.needs_integral,
        "source": "commands" if found.gains.from_commands else "trajectories",
    }


def _zone(found: Identification) -> dict[str, object]:
    decay, learned = found.decay, found.zone
    return {
        "eps_m": DeviationParams().eps,
        "d_m": decay.d.as_list() if decay else None,
        "alpha_m": decay.alpha.as_list() if decay else None,
        "beta_per_m": decay.beta.as_list() if decay else None,
        "extrapolated": decay.extrapolated if decay else None,
        "dev": [asdict(overlap) for overlap in found.overlaps],
        "learned": {"threshold_mps2": learned.threshold, "eps_m": learned.eps, "d_m": learned.d}
        if learned
        else None,
    }


def _model(found: Identification) -> dict[str, object]:
    return {
        "type": found.chosen.kind,
        "name": found.chosen.name,
        "parameters": found.chosen.parameters,
        "train_mse_m2": _roles(found.train.mse_m2),
        "r2_of": found.train.r2_of,
        "train_r2": _roles(found.train.r2),
        "heldout_mse_m2": _roles(found.held_out.mse_m2),
        "heldout_r2": _roles(found.held_out.r2),
        "intervals": dict(_spans(found.spread)),
    }


def _roles(scores: RoleScores) -> Plain:
    return {"lower": scores.lower, "upper": scores.upper}


def _candidate(trial: Trial) -> dict[str, object]:
    return {
        "name": trial.candidate.name,
        "type": trial.candidate.kind,
        "parameters": trial.candidate.parameters,
        "heldout_mse_m2": _roles(trial.held_out.mse_m2),
        "heldout_r2": _roles(trial.held_out.r2),
    }
