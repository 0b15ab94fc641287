"""Options of `plan --risk`: parameters, zone, and what the files say of them."""

from argparse import Namespace
from dataclasses import replace

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS, ResidualProcess
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.jet import Jet
from q2q_model.downwash.level_set import push_at_range
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import ModelFile
from q2q_model.vehicle.constants import CONTACT, GRAVITY, Vehicle
from q2q_planner.offline.certificate.convex_zone import ConvexZone
from q2q_planner.offline.zones.risk_zone import RiskParams, RiskTube, largest_push, risk_zone

MODEL = "measured_law"
"""Downwash without --model: fitted to real flights."""
MANOEUVRES = 1.0
"""Acceleration that is kept for the plan itself [m/s^2]: 4 m in 5.5 s."""


def risk_params(asked: Namespace) -> RiskParams:
    """Return the parameters of the command line; raise ValueError naming the option that is not allowed."""
    if asked.tube is None:
        raise ValueError(f"--risk {asked.risk:g} needs --tube, the largest tracking error of a flight [m]")
    tube_risk = 0.5 * asked.risk if asked.tube_risk is None else asked.tube_risk
    vehicle: Vehicle = asked.vehicle
    spare = vehicle.rpyt_thrust_max / vehicle.mass - GRAVITY
    words = f"{vehicle.name} has a thrust margin of {spare:.2f} m/s^2"
    if asked.hold is None and spare <= MANOEUVRES:
        raise ValueError(f"{words}: give --hold")
    if asked.hold is not None and asked.hold > spare:
        raise ValueError(f"--hold {asked.hold:g}: {words}; give less, as the plan needs some of it")
    hold = spare - MANOEUVRES if asked.hold is None else asked.hold
    horizontal, vertical = asked.tube
    touch = CONTACT if asked.touch is None else asked.touch
    return RiskParams(asked.risk, hold, RiskTube(horizontal, vertical, tube_risk), touch)


def zone_by_risk(asked: Namespace) -> tuple[ConvexZone, str]:
    """Return the zone of the command line, and its description."""
    params, file = risk_params(asked), find_model(asked.model or MODEL)
    residual = residual_of(file)
    push, tube = largest_push(params, residual), params.tube
    words = (
        f"risk {params.alpha:g} a vehicle: {params.touch:g} m apart, {asked.model or MODEL} below {push:.2f} "
        f"m/s^2, tube {tube.horizontal:g} m horizontally and {tube.vertical:g} m vertically at {tube.risk:g}"
    )
    return risk_zone(file.interaction, params, residual), words + range_note(file.interaction, push)


def residual_of(file: ModelFile) -> ResidualProcess:
    """Return the residual of a model: its own, or that of real flights.

    A jet without its own keeps a larger `relative_std`, as one scaled to an airframe never flown has. Its
    `std_floor` is not counted: that of the moving law, 0.40 m/s^2, is 0.28 m/s^2 here (docs/risk.md).
    """
    if file.residual is not None or not isinstance(file.interaction, Jet):
        return file.residual or REAL_FLIGHTS
    return replace(REAL_FLIGHTS, slope=max(REAL_FLIGHTS.slope, file.interaction.relative_std))


def range_note(model: InteractionModel, threshold: float) -> str:
    """Return that a zone ends at the range of a model, if its downwash still exceeds the threshold there."""
    left = push_at_range(model)
    if left <= threshold:
        return ""
    return f", down to {model.reach.vertical:g} m, the range of the model, where it is still {left:.2f} m/s^2"


def risk_facts(asked: Namespace, vehicles: int, *, certified: bool) -> dict[str, float | None]:
    """Return what --json says of the risk: of one vehicle, and, if `certified`, of any of them (Boole)."""
    if asked.risk is None:
        return {}
    params = risk_params(asked)
    return {
        "risk": params.alpha,
        "swarm_risk": min(1.0, vehicles * params.alpha) if certified else None,
        "hold": params.hold,
        "tube_horizontal_m": params.tube.horizontal,
        "tube_vertical_m": params.tube.vertical,
    }
